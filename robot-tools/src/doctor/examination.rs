//! All checks, one after the other: what the person beside the robot does, how many samples are listened to then, and what they
//! say. Who has the robot and the person asks, sends and listens.

use wire::{Command, Sample};

use super::checks::{self, CONTACTS, Finding};
use lab::input::rig_file::Robot;

/// Samples that a check listens to: two seconds.
const LISTEN: usize = 50;
/// Distance at which something is held in front of a sensor, metres.
const HELD_M: f32 = 0.3;
/// Share of the supply that a motor is tried with.
const TRIED_DUTY: f32 = 0.3;
/// How far the robot is pushed to find the encoders' scale, metres.
const PUSHED_M: f32 = 1.0;

/// What is looked at in the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    /// Nothing: they are what later ones are held against.
    Before,
    /// Nothing near any sensor.
    Free,
    /// Something in front of this sensor.
    Sensor(usize),
    /// This contact pressed.
    Contact(usize),
    /// This wheel turned since the samples before.
    Wheel(usize),
    /// The robot pushed since then.
    Scale,
}

/// One step of an examination.
#[derive(Clone, Debug, PartialEq)]
struct Task {
    /// What the person does.
    ask: Option<String>,
    /// What the robot is told then.
    send: Option<Command>,
    /// Samples that are listened to.
    listen: usize,
    look: Look,
}

/// What was found about a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The part's name.
    pub part: String,
    /// What is fine about it, or what is wrong and what would put it right.
    pub finding: Finding,
}

/// An examination under way.
pub struct Examination {
    robot: Robot,
    tasks: Vec<Task>,
    at: usize,
    is_asked: bool,
    is_sent: bool,
    free: Vec<Sample>,
    before: Vec<Sample>,
    heard: Vec<Sample>,
    found: Vec<Found>,
}

impl Examination {
    /// Of a robot with this rig.
    pub fn new(robot: &Robot) -> Self {
        let (before, heard) = (Vec::new(), Vec::new());
        let (tasks, robot) = (tasks_for(robot), robot.clone());
        Self {
            robot,
            tasks,
            at: 0,
            is_asked: false,
            is_sent: false,
            free: Vec::new(),
            before,
            heard,
            found: Vec::new(),
        }
    }

    /// What the person is to do now; none while the robot is listened to, or when it is over.
    pub fn ask(&self) -> Option<&str> {
        self.tasks.get(self.at)?.ask.as_deref().filter(|_| !self.is_asked)
    }

    /// The person has done it.
    pub fn answer(&mut self) {
        self.is_asked = true;
        self.go_on();
    }

    /// What the robot is to be told now, once.
    pub fn send(&mut self) -> Option<Command> {
        if self.ask().is_some() || core::mem::replace(&mut self.is_sent, true) {
            return None;
        }
        let command = self.tasks.get(self.at)?.send;
        self.go_on();
        command
    }

    /// Samples that are still to be listened to before the person is asked or told something again.
    pub fn listens(&self) -> usize {
        let task = self.tasks.get(self.at).filter(|_| self.ask().is_none());
        task.map_or(0, |task| task.listen.saturating_sub(self.heard.len()))
    }

    /// Takes in a sample that was listened to.
    pub fn take(&mut self, sample: Sample) {
        if self.listens() > 0 {
            self.heard.push(sample);
            self.go_on();
        }
    }

    /// Looks at what was heard once it is enough, and begins the next step.
    fn go_on(&mut self) {
        let Some(task) = self.tasks.get(self.at).filter(|_| self.listens() == 0) else { return };
        let Self { robot, free, before, heard, .. } = &*self;
        let found = match task.look {
            Look::Before | Look::Free => None,
            Look::Sensor(index) => {
                Some((robot.names[index].clone(), checks::sensor(index, robot, HELD_M, free, heard)))
            }
            Look::Contact(index) => {
                let contact = &CONTACTS[index];
                Some((contact.name.to_owned(), checks::contact(contact, before, heard)))
            }
            Look::Wheel(wheel) => {
                let is_motor = task.send.is_some();
                let what = if is_motor { "motor" } else { "encoder" };
                let blocked = checks::blocking(heard).filter(|_| is_motor);
                let finding = blocked.map_or_else(
                    || checks::turned(wheel, before, heard),
                    |names| Err(format!("{names} on: the robot does not turn its wheels forward then")),
                );
                Some((format!("{} {what}", WHEELS[wheel]), finding))
            }
            Look::Scale => Some(("encoder scale".to_owned(), checks::scale(robot, PUSHED_M, before, heard))),
        };
        let is_free = task.look == Look::Free;
        self.found.extend(found.map(|(part, finding)| Found { part, finding }));
        let heard = core::mem::take(&mut self.heard);
        if is_free {
            self.free = heard;
        } else if !heard.is_empty() {
            self.before = heard;
        }
        self.at += 1;
        (self.is_asked, self.is_sent) = (false, false);
    }

    /// Whether all was looked at.
    pub fn is_over(&self) -> bool {
        self.at >= self.tasks.len()
    }

    /// What was found so far.
    pub fn found(&self) -> &[Found] {
        &self.found
    }

    /// Share that is done, 0 to 1.
    pub fn share(&self) -> f64 {
        self.at as f64 / self.tasks.len().max(1) as f64
    }
}

const WHEELS: [&str; 2] = ["left", "right"];

/// The steps for a robot.
fn tasks_for(robot: &Robot) -> Vec<Task> {
    let ask = |what: String, listen, look| Task { ask: Some(what), send: None, listen, look };
    let before = || Task { ask: None, send: None, listen: 2, look: Look::Before };
    let middle = "Put the robot in the middle of the room, nothing nearer than a metre, wheels off the floor. \
                  Tape a white card under the cliff sensor, and hold the wheel-drop switches closed.";
    let mut tasks = vec![
        Task { ask: None, send: Some(Command::Stop), listen: 0, look: Look::Before },
        ask(middle.to_owned(), LISTEN, Look::Free),
    ];
    for (index, (sensor, name)) in robot.rig.sensors.iter().zip(&robot.names).enumerate() {
        let bearing_deg = sensor.mount.bearing_rad.to_degrees();
        let what =
            format!("Hold a white board {HELD_M} m in front of sensor {index}, {name}, at {bearing_deg:.0} degrees.");
        tasks.push(ask(what, LISTEN, Look::Sensor(index)));
    }
    for (index, part) in CONTACTS.iter().enumerate() {
        tasks.push(before());
        tasks.push(ask(format!("{} and keep it so.", part.what), LISTEN / 2, Look::Contact(index)));
        tasks.push(ask("Let go.".to_owned(), 0, Look::Before));
    }
    for (wheel, name) in WHEELS.into_iter().enumerate() {
        tasks.push(before());
        tasks.push(ask(format!("Turn the {name} wheel forward by hand, about one turn."), 2, Look::Wheel(wheel)));
        let duty = |on: usize| if on == wheel { TRIED_DUTY } else { 0.0 };
        let spin = Command::Spin { left: duty(0), right: duty(1) };
        tasks.push(Task { ask: None, send: Some(spin), listen: LISTEN / 2, look: Look::Wheel(wheel) });
    }
    tasks.push(before());
    let push = format!("Put the robot on the floor, without the card, and push it straight forward by {PUSHED_M} m.");
    tasks.push(ask(push, 2, Look::Scale));
    tasks
}
