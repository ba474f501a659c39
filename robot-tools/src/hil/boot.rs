//! One run of the firmware, from its start until its power is off, in a simulated home that goes on.

use hal_sim::Simulation;
use lab::recording::Pose2;
use robot::Duty;
use wire::{Command, Contacts, Estimate, Floor, Place, Range, Sample};

use super::Hil;
use super::link::Link;
use super::shadow::Shadow;
use super::target::{Beginning, Target};

/// Period of the exchange, microseconds: that of the firmware's wheel-speed control.
pub const PERIOD_US: u64 = 20_000;

/// A firmware at work, with the host's estimator beside it.
pub struct Boot<'h> {
    simulation: &'h mut Simulation,
    link: Link,
    shadow: Shadow,
    duty: Duty,
    period: u64,
}

/// What one exchange brought.
pub struct Moment {
    /// What the sensors showed.
    pub shown: Sample,
    /// The firmware's estimate, where it made one.
    pub estimate: Option<Estimate>,
    /// The firmware's word on its place, where it said one.
    pub place: Option<Place>,
    /// The firmware's word on the floor, where it said one.
    pub floor: Option<Floor>,
    /// The true pose in the frame of the simulation's start.
    pub truth: Pose2,
    /// The true pose in the plan's frame.
    pub in_plan: Pose2,
}

impl<'h> Boot<'h> {
    /// Starts the firmware with this in its flash for maps.
    ///
    /// # Errors
    /// What keeps it from starting, for people.
    pub fn start(
        hil: &Hil,
        simulation: &'h mut Simulation,
        flash: Vec<u8>,
        power_words: Option<u32>,
    ) -> Result<Self, String> {
        let hand_overs = hil.hand_overs;
        let is_timed = matches!(hil.target, Target::EmulatorTimed { .. });
        let shadow = Shadow::new(hil.robot, hand_overs, is_timed, flash.clone())?;
        let link = Link::new(hil.target.start(&Beginning { hand_overs, flash, power_words })?)?;
        Ok(Self { simulation, link, shadow, duty: Duty::default(), period: 0 })
    }

    /// Tells the firmware what to do; it obeys with the next sample.
    ///
    /// # Errors
    /// The link is broken.
    pub fn command(&mut self, command: Command) -> Result<(), String> {
        self.link.send_command(command)
    }

    /// Lets one period pass.
    ///
    /// # Errors
    /// The link is broken, or the firmware says nothing more.
    pub fn pass(&mut self) -> Result<Moment, String> {
        self.period += 1;
        self.simulation.set_duty(self.duty);
        self.simulation.advance(PERIOD_US as f64 * 1e-6);
        let shown = sense(self.simulation, self.period * PERIOD_US);
        let answer = self.link.exchange(shown.clone())?;
        self.duty = Duty { left: answer.motors.left, right: answer.motors.right };
        let truth = self.simulation.pose();
        let estimate = self.shadow.check(&shown, &answer, truth);
        let in_plan = self.simulation.pose_in_plan();
        Ok(Moment { shown, estimate, place: answer.place, floor: answer.floor, truth, in_plan })
    }

    /// Cuts the power; gives what was compared and what the flash for maps has.
    pub fn cut(self) -> (Shadow, Vec<u8>) {
        (self.shadow, self.link.cut())
    }
}

/// What the robot's sensors show now.
fn sense(simulation: &mut Simulation, time_us: u64) -> Sample {
    let ticks = simulation.ticks();
    let ranges = simulation.read_ranges();
    let robot::Contacts { bump_left, bump_right, cliff, lifted } = simulation.contacts();
    let docked = simulation.condition().is_charging;
    Sample {
        time_us,
        left_ticks: ticks.left,
        right_ticks: ticks.right,
        ranges: ranges.into_iter().take(wire::SENSORS).map(Range::from).collect(),
        contacts: Contacts { bump_left, bump_right, cliff, lifted, docked },
    }
}
