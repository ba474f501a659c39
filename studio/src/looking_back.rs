//! The look back beside a run that grows: path and walls of all that was driven so far, placed once more as the robot's own back
//! end does it, a little at a time.

use lab::evaluate::robot_look_back::RobotLooksBack;
use lab::evaluate::smoother;
use lab::input::rig_file::MAX_SENSORS;
use lab::recording::Recording;
use lab::show::report;
use lab::show::report::growing::Growing;
use serde_json::Value;
use slam_core::Rig;

/// A look back that follows a run.
#[derive(Default)]
pub struct LookingBack {
    back: Option<RobotLooksBack>,
    /// Steps that the round under way is to place.
    end: usize,
    is_working: bool,
}

impl LookingBack {
    /// Goes on by so many small pieces of work with placing what the record has, or had when the round began; whether there is more
    /// of this round.
    ///
    /// # Errors
    /// Why there is nothing to look back on.
    pub fn work(&mut self, recording: &Recording, rig: &Rig<MAX_SENSORS>, pieces: usize) -> Result<bool, &'static str> {
        if !recording.is_one_frame() {
            return Err("the robot lost its place on this drive: a look back needs a drive in one frame");
        }
        let back = match &mut self.back {
            Some(back) => back,
            none => none.insert(RobotLooksBack::new(recording, rig).ok_or("nothing was driven yet")?),
        };
        if !self.is_working {
            self.end = recording.steps.len();
        }
        self.is_working = (0..pieces).all(|_| back.work(recording, rig, self.end));
        Ok(self.is_working)
    }

    /// How many steps are placed, and the walls, when no round is under way.
    pub fn walls(&self) -> Option<Value> {
        self.done().map(|back| Growing::looked_back(back.steps(), &back.walls()))
    }

    /// The path that was found: x and y of each step, metres, in the map frame.
    pub fn path(&self, recording: &Recording) -> Vec<f64> {
        let path = self.done().map(|back| back.path(recording)).unwrap_or_default();
        path.into_iter().flat_map(|pose| [pose.x_m, pose.y_m]).collect()
    }

    /// The page that the workbench writes of a run, of what was found; none where that is not of the whole record.
    pub fn page(&self, mut recording: Recording) -> Option<String> {
        let back = self.done().filter(|back| back.steps() == recording.steps.len())?.moved(&recording);
        Some(report::html(&smoother::scored(&mut recording, back)))
    }

    fn done(&self) -> Option<&RobotLooksBack> {
        self.back.as_ref().filter(|_| !self.is_working)
    }
}
