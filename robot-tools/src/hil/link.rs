//! Lock step with the firmware: one sample goes out, everything up to the motors' frame comes back.

use std::io::ErrorKind;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use wire::{
    Calibration, Command, Decoder, Estimate, Faults, Floor, Frame, LookBack, Motors, Place, Sample, Wall, encode,
};

use super::target::{Opener, Running};

/// A firmware that says nothing for this long is taken to be gone.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often it is looked whether the emulator still runs.
const LOOK: Duration = Duration::from_millis(200);

/// What the firmware said to one sample.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// What the motors are given.
    pub motors: Motors,
    /// The sample that the estimator took.
    pub sample: Option<Sample>,
    /// The estimate after it.
    pub estimate: Option<Estimate>,
    /// One wall of the map.
    pub wall: Option<Wall>,
    /// The calibration, once a second.
    pub calibration: Option<Calibration>,
    /// The faults, once a second.
    pub faults: Option<Faults>,
    /// What the back end did, once a second.
    pub look_back: Option<LookBack>,
    /// What it knows of its place, once a second.
    pub place: Option<Place>,
    /// What becomes of the floor, once a second while it cleans.
    pub floor: Option<Floor>,
    /// What its flash for maps has after it; none of a board's.
    pub flash: Option<Vec<u8>>,
    /// Frames that arrived damaged.
    pub damaged: u32,
}

/// The link to a running target.
pub struct Link {
    target: Running,
    frames: Receiver<Result<Frame, String>>,
}

impl Link {
    /// Waits for the firmware's first word.
    ///
    /// # Errors
    /// It says nothing.
    pub fn new(mut target: Running) -> Result<Self, String> {
        let open = target.from.take().ok_or("the target is read already")?;
        let (send, frames) = channel();
        std::thread::spawn(move || receive(open, &send));
        let mut link = Self { target, frames };
        link.answer()?;
        Ok(link)
    }

    /// Tells the firmware what to do; it obeys with the next sample.
    ///
    /// # Errors
    /// The link is broken.
    pub fn send_command(&mut self, command: Command) -> Result<(), String> {
        self.send(&Frame::Command(command))
    }

    /// Shows the firmware a sample and waits for its answer.
    ///
    /// # Errors
    /// The link is broken, or the firmware says nothing more.
    pub fn exchange(&mut self, sample: Sample) -> Result<Answer, String> {
        let time_us = sample.time_us;
        self.send(&Frame::Sample(sample))?;
        let answer = self.answer()?;
        if answer.motors.time_us != time_us {
            let theirs = answer.motors.time_us;
            return Err(format!("the firmware is at {theirs} us, the home at {time_us} us: reset the board"));
        }
        Ok(answer)
    }

    /// Cuts the firmware's power; gives what its flash for maps has.
    pub fn cut(self) -> Vec<u8> {
        self.target.flash().unwrap_or_default()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), String> {
        let bytes = encode(frame).map_err(|error| format!("a frame cannot be sent: {error:?}"))?;
        let to = self.target.to.as_mut().ok_or("the link is closed")?;
        to.write_all(&bytes).and_then(|()| to.flush()).map_err(|error| format!("the link to the firmware: {error}"))
    }

    fn answer(&mut self) -> Result<Answer, String> {
        let mut answer = Answer::default();
        loop {
            match self.next()? {
                Ok(Frame::Motors(motors)) => return Ok(Answer { motors, flash: self.target.flash(), ..answer }),
                Ok(Frame::Sample(sample)) => answer.sample = Some(sample),
                Ok(Frame::Estimate(estimate)) => answer.estimate = Some(estimate),
                Ok(Frame::Wall(wall)) => answer.wall = Some(wall),
                Ok(Frame::Calibration(calibration)) => answer.calibration = Some(calibration),
                Ok(Frame::Faults(faults)) => answer.faults = Some(faults),
                Ok(Frame::LookBack(look_back)) => answer.look_back = Some(look_back),
                Ok(Frame::Place(place)) => answer.place = Some(place),
                Ok(Frame::Floor(floor)) => answer.floor = Some(floor),
                Ok(Frame::MapAnswer(_) | Frame::Frozen(_)) => {}
                Ok(Frame::Command(_) | Frame::MapRequest(_)) | Err(_) => answer.damaged += 1,
            }
        }
    }

    fn next(&mut self) -> Result<Result<Frame, String>, String> {
        let start = Instant::now();
        loop {
            match self.frames.recv_timeout(LOOK) {
                Ok(frame) => return Ok(frame),
                Err(RecvTimeoutError::Timeout) if start.elapsed() < PATIENCE => {
                    if let Some(why) = self.target.ended() {
                        return Err(why);
                    }
                }
                Err(RecvTimeoutError::Timeout) => return Err("the firmware does not answer".into()),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.target.ended().unwrap_or_else(|| "the firmware closed the link".into()));
                }
            }
        }
    }
}

/// Reads until the link ends.
fn receive(open: Opener, send: &Sender<Result<Frame, String>>) {
    let Ok(mut from) = open() else { return };
    let mut decoder = Decoder::new();
    let mut bytes = [0; 4096];
    loop {
        let count = match from.read(&mut bytes) {
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::TimedOut => continue,
            Err(_) => return,
        };
        if count == 0 {
            return;
        }
        for frame in bytes[..count].iter().filter_map(|byte| decoder.push(*byte)) {
            if send.send(frame.map_err(|error| format!("{error:?}"))).is_err() {
                return;
            }
        }
    }
}
