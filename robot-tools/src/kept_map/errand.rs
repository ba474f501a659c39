//! What is done with a robot's kept map over its line: which request is due, and what the answers come to. Who has the line sends
//! and listens.

use kept_map::Record;
use lab::run::newest_map;
use wire::{MapAnswer, MapRequest, PIECE_BYTES};

/// Milliseconds after which a request that was not answered is made again: erasing a sector takes up to 0.8 s, and a robot that rolls
/// out holds its motors off first.
pub const AGAIN_MS: u32 = 3000;

/// A request that is not answered is made so often.
const TIMES: u32 = 3;

/// So often the robot may drop what it had got of a map, or save another one while the old one is fetched.
const RESTARTS: u32 = 3;

/// No robot has room for a longer record, bytes.
const MOST_BYTES: usize = 64 * 1024;

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Errand {
    /// Fetch the record.
    Get,
    /// Give the robot this record.
    Put(Vec<u8>),
    /// Have the robot forget it.
    Forget,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Done {
    /// The record, whole.
    Got(Vec<u8>),
    /// The robot keeps the record, as the save of this number.
    Kept(u32),
    /// The robot keeps no map.
    Forgotten,
}

/// An errand under way.
#[derive(Clone, Debug)]
pub struct MapErrand {
    errand: Errand,
    got: Vec<u8>,
    /// Bytes of the whole record, once that is known.
    of: usize,
    /// Bytes of a record that is put which the robot has.
    put: usize,
    /// How often the present request was made.
    asked: u32,
    restarts: u32,
}

impl MapErrand {
    /// About to begin.
    ///
    /// # Errors
    /// What is to be put is no record.
    pub fn new(mut errand: Errand) -> Result<Self, String> {
        let mut of = 0;
        if let Errand::Put(bytes) = &mut errand {
            *bytes = newest_map(bytes).to_vec();
            let words = Record::parse(bytes).map_err(|refused| refused.to_string())?.words();
            of = 4 * words;
        }
        Ok(Self { errand, got: Vec::new(), of, put: 0, asked: 0, restarts: 0 })
    }

    /// The request to send now: at first, after each answer, and when there was none for [`AGAIN_MS`].
    ///
    /// # Errors
    /// It was made often enough without an answer.
    pub fn request(&mut self) -> Result<MapRequest, String> {
        self.asked += 1;
        if self.asked > TIMES {
            return Err("the robot does not answer when it is asked about its kept map; it must run the firmware of \
                        this version"
                .to_owned());
        }
        Ok(match &self.errand {
            Errand::Get => MapRequest::Get { offset: self.got.len() as u32 },
            Errand::Put(bytes) => {
                let piece = bytes.iter().take(self.of).skip(self.put).take(PIECE_BYTES);
                MapRequest::Put { offset: self.put as u32, bytes: piece.copied().collect() }
            }
            Errand::Forget => MapRequest::Forget,
        })
    }

    /// Takes in an answer: what came of the errand, once it is over.
    ///
    /// # Errors
    /// The robot refused, or what arrived is no record.
    pub fn take(&mut self, answer: &MapAnswer) -> Result<Option<Done>, String> {
        match (&self.errand, answer) {
            (_, MapAnswer::Refused(why)) => return Err(why.text().to_owned()),
            (Errand::Get, MapAnswer::Part { offset, of, bytes }) => {
                return self.got(*offset as usize, *of as usize, bytes);
            }
            (Errand::Put(_), MapAnswer::Awaiting { offset }) => {
                let next = (*offset as usize).min(self.of);
                if next < self.put {
                    self.restart("the robot dropped what it had got of the map")?;
                }
                self.put = next;
                self.asked = 0;
            }
            (Errand::Put(_), MapAnswer::Kept { sequence }) => return Ok(Some(Done::Kept(*sequence))),
            (Errand::Forget, MapAnswer::Forgotten) => return Ok(Some(Done::Forgotten)),
            // An answer to somebody else's request.
            _ => {}
        }
        Ok(None)
    }

    fn got(&mut self, offset: usize, of: usize, bytes: &[u8]) -> Result<Option<Done>, String> {
        if offset != self.got.len() {
            return Ok(None);
        }
        if bytes.is_empty() || of > MOST_BYTES {
            return Err("the robot's answer makes no sense; it must run the firmware of this version".to_owned());
        }
        self.got.extend_from_slice(bytes);
        self.of = of;
        self.asked = 0;
        if self.got.len() < of {
            return Ok(None);
        }
        if Record::parse(&self.got).is_err() {
            self.restart("the map arrived damaged")?;
            self.got.clear();
            return Ok(None);
        }
        Ok(Some(Done::Got(std::mem::take(&mut self.got))))
    }

    fn restart(&mut self, why: &str) -> Result<(), String> {
        self.restarts += 1;
        if self.restarts > RESTARTS { Err(format!("{why}, {} times", self.restarts)) } else { Ok(()) }
    }

    /// Share that is done, 0 to 1.
    pub fn share(&self) -> f64 {
        (self.got.len() + self.put) as f64 / self.of.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::MapRefusal;

    /// A record as a simulated drive makes it.
    fn record() -> Vec<u8> {
        record_of(&hal_sim::plan_file::load("room").unwrap())
    }

    fn record_of(plan: &hal_sim::Plan) -> Vec<u8> {
        let (robot, _) = lab::input::built_in_robot().unwrap();
        let config = slam_core::Config::for_rig(&robot.rig);
        let mut drive = lab::run::Drive::new(plan, &robot, hal_sim::SimOptions::default(), 1).unwrap();
        let mut session = lab::run::Session::new(&robot, config, "room").unwrap();
        for _ in 0..500 {
            drive.step(&mut session);
        }
        session.map().expect("a map")
    }

    /// A robot's side: keeps a record, and drops one answer in so many.
    struct Robot {
        kept: Vec<u8>,
        coming: Vec<u8>,
    }

    impl Robot {
        fn answer(&mut self, request: &MapRequest) -> MapAnswer {
            match request {
                MapRequest::Get { .. } if self.kept.is_empty() => MapAnswer::Refused(MapRefusal::Nothing),
                MapRequest::Get { offset } => {
                    let bytes = self.kept.iter().skip(*offset as usize).take(PIECE_BYTES).copied().collect();
                    MapAnswer::Part { offset: *offset, of: self.kept.len() as u32, bytes }
                }
                MapRequest::Put { offset, bytes } => {
                    if *offset == 0 {
                        self.coming.clear();
                    }
                    if *offset as usize == self.coming.len() {
                        self.coming.extend(bytes);
                    }
                    if Record::parse(&self.coming).is_ok() {
                        self.kept = std::mem::take(&mut self.coming);
                        return MapAnswer::Kept { sequence: 7 };
                    }
                    MapAnswer::Awaiting { offset: self.coming.len() as u32 }
                }
                MapRequest::Forget => {
                    self.kept.clear();
                    MapAnswer::Forgotten
                }
            }
        }
    }

    /// Runs an errand over a line that loses every `lost`th answer.
    fn run(errand: Errand, robot: &mut Robot, lost: usize) -> Result<Done, String> {
        let mut errand = MapErrand::new(errand)?;
        for i in 1.. {
            let answer = robot.answer(&errand.request()?);
            if i % lost != 0
                && let Some(done) = errand.take(&answer)?
            {
                return Ok(done);
            }
        }
        unreachable!("the loop returns")
    }

    #[test]
    fn a_map_goes_to_the_robot_and_comes_back_over_a_line_that_loses_answers() {
        let map = record();
        let mut robot = Robot { kept: Vec::new(), coming: Vec::new() };
        assert_eq!(run(Errand::Get, &mut robot, 100), Err(MapRefusal::Nothing.text().to_owned()));
        assert_eq!(run(Errand::Put(map.clone()), &mut robot, 3), Ok(Done::Kept(7)));
        assert_eq!(run(Errand::Get, &mut robot, 3), Ok(Done::Got(map)));
        assert_eq!(run(Errand::Forget, &mut robot, 100), Ok(Done::Forgotten));
        assert!(robot.kept.is_empty());
    }

    #[test]
    fn the_map_of_a_home_has_its_areas_where_they_are_in_the_map() {
        let mut plan = hal_sim::plan_file::load("room").unwrap();
        let corners = [[3.0, 1.0], [4.0, 1.0], [4.0, 2.0]];
        plan.bounds.add(robot::AreaKind::KeepOut, &corners).unwrap();
        let map = record_of(&plan);
        let kept: Vec<kept_map::Corner> = Record::parse(&map).unwrap().corners().collect();
        assert_eq!(kept.len(), corners.len());
        let from_start = plan.start.to_pose().inverse();
        for (kept, corner) in kept.iter().zip(corners) {
            let [x_m, y_m] = from_start.transform(corner);
            assert_eq!(robot::AreaKind::ALL.get(usize::from(kept.kind)), Some(&robot::AreaKind::KeepOut));
            assert!((kept.at_m[0] - x_m).hypot(kept.at_m[1] - y_m) < 0.05, "{kept:?}, not {x_m} {y_m}");
        }
    }

    #[test]
    fn who_does_not_answer_or_answers_nonsense_is_given_up() {
        let map = record();
        assert!(MapErrand::new(Errand::Put(map[..100].to_vec())).unwrap_err().contains("damaged"));
        let mut robot = Robot { kept: map.clone(), coming: Vec::new() };
        assert!(run(Errand::Get, &mut robot, 1).unwrap_err().contains("does not answer"));
        let mut get = MapErrand::new(Errand::Get).unwrap();
        let endless = MapAnswer::Part { offset: 0, of: u32::MAX, bytes: [0; 4].into_iter().collect() };
        assert!(get.take(&endless).is_err());
        robot.kept[200] ^= 1;
        assert!(run(Errand::Get, &mut robot, 100).unwrap_err().contains("arrived damaged"));
        let mut put = MapErrand::new(Errand::Put(map)).unwrap();
        let answers =
            |_| (put.take(&MapAnswer::Awaiting { offset: 96 }), put.take(&MapAnswer::Awaiting { offset: 0 })).1;
        assert!((0..RESTARTS + 1).map(answers).last().unwrap().is_err(), "it begins anew only so often");
    }
}
