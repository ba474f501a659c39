//! `lab doctor` on robots that are wired rightly and wrongly.

use lab::input::built_in;
use robot::rig::BuiltIn;
use robot_tools::doctor::{Bench, examine};
use wire::{Command, Contacts, Range, Sample};

/// A robot and a person who does what is asked; `order` says which sensor is on which input.
struct Robot {
    order: [usize; 8],
    reversed_left: bool,
    kind: BuiltIn,
    /// Inputs that are on all the time.
    stuck: Contacts,
    sample: Sample,
    said: Vec<String>,
}

impl Robot {
    fn new(order: [usize; 8], reversed_left: bool) -> Self {
        let (kind, stuck) = (BuiltIn::Sharp, Contacts::default());
        Self { order, reversed_left, kind, stuck, sample: Sample::default(), said: Vec::new() }
    }

    fn roll(&mut self, left: i32, right: i32) {
        self.sample.left_ticks += if self.reversed_left { -left } else { left };
        self.sample.right_ticks += right;
    }

    fn examined(mut self) -> (usize, String) {
        let (robot, _) = built_in(self.kind).unwrap();
        let wrong = examine(&mut self, &robot).unwrap();
        (wrong, self.said.join("\n"))
    }
}

impl Bench for Robot {
    fn ask(&mut self, what: &str) -> Result<(), String> {
        // 0.3 m by the built-in rig's law: 1.83 V of 3.3 V in 12 bits.
        let (sensors, free, held) = match self.kind {
            BuiltIn::Sharp => (8, Range::Counts(500), Range::Counts(2268)),
            BuiltIn::TimeOfFlight => (4, Range::Missing, Range::Metres(0.31)),
        };
        self.sample.ranges = (0..sensors).map(|_| free).collect();
        self.sample.contacts = self.stuck;
        let sensor = (0..8).find(|i| what.contains(&format!("sensor {i},")));
        if let Some(sensor) = sensor {
            self.sample.ranges[self.order[sensor]] = held;
        }
        match what {
            what if what.contains("left half") => self.sample.contacts.bump_left = true,
            what if what.contains("right half") => self.sample.contacts.bump_right = true,
            what if what.contains("Take the white card") => self.sample.contacts.cliff = true,
            what if what.contains("Let go of a wheel-drop") => self.sample.contacts.lifted = true,
            what if what.contains("charging") => self.sample.contacts.docked = true,
            what if what.contains("left wheel") => self.roll(400, 0),
            what if what.contains("right wheel") => self.roll(0, 400),
            what if what.contains("push") => self.roll(2247, 2247),
            _ => {}
        }
        Ok(())
    }

    fn say(&mut self, what: &str) {
        self.said.push(what.to_owned());
    }

    fn listen(&mut self, samples: usize) -> Result<Vec<Sample>, String> {
        Ok(vec![self.sample.clone(); samples])
    }

    fn send(&mut self, command: Command) -> Result<(), String> {
        if let Command::Spin { left, right } = command {
            self.roll((1000.0 * left) as i32, (1000.0 * right) as i32);
        }
        Ok(())
    }
}

#[test]
fn a_robot_that_is_right_has_nothing_wrong() {
    let (wrong, said) = Robot::new([0, 1, 2, 3, 4, 5, 6, 7], false).examined();
    assert_eq!(wrong, 0, "{said}");
    assert_eq!(said.matches("ok").count(), 8 + 5 + 4 + 1, "{said}");
}

#[test]
fn swapped_sensors_are_named() {
    let (wrong, said) = Robot::new([0, 2, 1, 3, 4, 5, 6, 7], false).examined();
    assert_eq!(wrong, 2, "{said}");
    assert!(said.contains("WRONG  front_left: sensor 2, left, answered instead"), "{said}");
}

#[test]
fn a_reversed_encoder_is_named() {
    let (wrong, said) = Robot::new([0, 1, 2, 3, 4, 5, 6, 7], true).examined();
    assert_eq!(wrong, 3, "{said}");
    assert!(said.contains("WRONG  left encoder: -400 ticks: it counts backward"), "{said}");
}

/// A cliff sensor that sees no floor.
#[test]
fn an_input_that_is_on_is_named_and_so_are_the_motors_that_it_stops() {
    let stuck = Contacts { cliff: true, ..Contacts::default() };
    let (wrong, said) = Robot { stuck, ..Robot::new([0, 1, 2, 3, 4, 5, 6, 7], false) }.examined();
    assert_eq!(wrong, 3, "{said}");
    assert!(
        said.contains("ok     left bumper") && said.contains("WRONG  cliff sensor: it is on all the time"),
        "{said}"
    );
    assert!(said.contains("WRONG  left motor: cliff sensor on") && said.contains("ok     left encoder"), "{said}");
}

#[test]
fn sensors_that_report_metres_are_checked_the_same() {
    let kind = BuiltIn::TimeOfFlight;
    let (wrong, said) = Robot { kind, ..Robot::new([0, 1, 2, 3, 4, 5, 6, 7], false) }.examined();
    assert_eq!(wrong, 0, "{said}");
    assert!(said.contains("ok     left: 0.31 m"), "{said}");
    let (wrong, said) = Robot { kind, ..Robot::new([1, 0, 2, 3, 4, 5, 6, 7], false) }.examined();
    assert_eq!(wrong, 2, "{said}");
    assert!(said.contains("WRONG  front: sensor 1, left, answered instead"), "{said}");
}
