//! What is done with a robot over its line beside watching it: its kept map fetched, stored and forgotten, and an examination part
//! by part, with the person who stands beside it.

use lab::input::rig_file::Robot;
use robot_tools::doctor::{Examination, Found};
use robot_tools::kept_map::errand::{AGAIN_MS, Done, Errand, MapErrand};
use serde_json::{Value, json};
use wire::{Frame, MapAnswer, Sample, encode};

/// Samples that are passed over after the person said that it is done: what was on its way is from before.
const SETTLING: u32 = 8;

/// Errands at a robot.
pub struct Errands {
    map: Option<MapErrand>,
    /// When the map's request was sent, by the page's clock, milliseconds; none where the next one is due.
    asked_ms: Option<f64>,
    /// What came of the last one, in words.
    said: Result<String, String>,
    fetched: Vec<u8>,
    examination: Option<Examination>,
    settling: u32,
}

impl Default for Errands {
    fn default() -> Self {
        let (said, fetched) = (Ok(String::new()), Vec::new());
        Self { map: None, asked_ms: None, said, fetched, examination: None, settling: 0 }
    }
}

impl Errands {
    /// Begins an errand about the robot's kept map: `get`, `put` with the bytes of a `map.bin`, or `forget`.
    ///
    /// # Errors
    /// What is wrong with the map.
    pub fn begin_map(&mut self, name: &str, map: Vec<u8>) -> Result<(), String> {
        let errand = match name {
            "get" => Errand::Get,
            "put" => Errand::Put(map),
            "forget" => Errand::Forget,
            _ => return Err(format!("{name}: is no errand; there are get, put and forget")),
        };
        self.map = Some(MapErrand::new(errand)?);
        self.asked_ms = None;
        self.said = Ok(String::new());
        Ok(())
    }

    /// Begins to examine a robot.
    pub fn examine(&mut self, robot: &Robot) {
        self.examination = Some(Examination::new(robot));
        self.settling = SETTLING;
    }

    /// The person has done what was asked for.
    pub fn answer(&mut self) {
        if let Some(examination) = &mut self.examination {
            examination.answer();
            self.settling = SETTLING;
        }
    }

    /// Ends the examination.
    pub fn end_examination(&mut self) {
        self.examination = None;
    }

    /// Takes in a sample.
    pub fn sample(&mut self, sample: &Sample) {
        let Some(examination) = &mut self.examination else { return };
        if self.settling > 0 {
            self.settling -= 1;
        } else {
            examination.take(sample.clone());
        }
    }

    /// Takes in what the robot says of its kept map.
    pub fn map_answer(&mut self, answer: &MapAnswer) {
        let Some(map) = &mut self.map else { return };
        self.asked_ms = None;
        let done = match map.take(answer) {
            Ok(None) => return,
            Ok(Some(done)) => done,
            Err(why) => return self.end_map(Err(why)),
        };
        let said = match done {
            Done::Got(bytes) => {
                let said = format!("The robot's map is fetched: {} bytes.", bytes.len());
                self.fetched = bytes;
                said
            }
            Done::Kept(sequence) => {
                format!("The robot keeps the map, as its number {sequence}, and looks for itself in it: start it.")
            }
            Done::Forgotten => "The robot keeps no map; where it stands is its new origin.".to_owned(),
        };
        self.end_map(Ok(said));
    }

    fn end_map(&mut self, said: Result<String, String>) {
        self.map = None;
        self.said = said;
    }

    /// What is to be sent now, at this time of the page's clock, milliseconds.
    pub fn due(&mut self, now_ms: f64) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut send = |frame| bytes.extend(encode(&frame).unwrap_or_default());
        if let Some(command) = self.examination.as_mut().and_then(Examination::send) {
            send(Frame::Command(command));
        }
        let is_due = self.asked_ms.is_none_or(|asked_ms| now_ms - asked_ms > f64::from(AGAIN_MS));
        if let Some(map) = self.map.as_mut().filter(|_| is_due) {
            match map.request() {
                Ok(request) => {
                    send(Frame::MapRequest(request));
                    self.asked_ms = Some(now_ms);
                }
                Err(why) => self.end_map(Err(why)),
            }
        }
        bytes
    }

    /// The fetched map, once.
    pub fn fetched(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.fetched)
    }

    /// How far the errands are, in words and numbers.
    pub fn state(&self) -> Value {
        let (said, failed) = match &self.said {
            Ok(said) => (said, None),
            Err(why) => (why, Some(why)),
        };
        json!({
            "map": { "under_way": self.map.as_ref().map(MapErrand::share), "said": said, "failed": failed.is_some() },
            "doctor": self.examination.as_ref().map(|examination| json!({
                "ask": examination.ask(),
                "share": examination.share(),
                "over": examination.is_over(),
                "found": examination.found().iter().map(found).collect::<Vec<_>>(),
            })),
        })
    }
}

fn found(Found { part, finding }: &Found) -> Value {
    let (Ok(said) | Err(said)) = finding;
    json!({ "part": part, "said": said, "wrong": finding.is_err() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::{Command, Decoder, MapRefusal, MapRequest};

    fn sent(bytes: &[u8]) -> Vec<Frame> {
        let mut decoder = Decoder::new();
        bytes.iter().filter_map(|byte| decoder.push(*byte)).map(|frame| frame.expect("undamaged")).collect()
    }

    #[test]
    fn a_request_is_repeated_until_it_is_answered_or_given_up() {
        let mut errands = Errands::default();
        assert!(errands.begin_map("put", vec![0; 40]).is_err());
        errands.begin_map("get", Vec::new()).unwrap();
        let get = [Frame::MapRequest(MapRequest::Get { offset: 0 })];
        assert_eq!((sent(&errands.due(0.0)), sent(&errands.due(100.0))), (get.to_vec(), vec![]));
        assert_eq!(sent(&errands.due(3200.0)), get);
        errands.map_answer(&MapAnswer::Refused(MapRefusal::Nothing));
        assert!(errands.state()["map"]["said"].as_str().unwrap().contains("keeps no map"));
        assert_eq!(errands.state()["map"]["failed"], true);
        errands.begin_map("forget", Vec::new()).unwrap();
        let times = (0..10).filter(|i| !errands.due(f64::from(*i) * 4000.0).is_empty()).count();
        assert_eq!((times, &errands.state()["map"]["failed"]), (3, &json!(true)));
    }

    #[test]
    fn an_examination_stops_the_robot_asks_and_listens() {
        let (robot, _) = lab::input::built_in_robot().unwrap();
        let mut errands = Errands::default();
        errands.examine(&robot);
        assert_eq!(sent(&errands.due(0.0)), [Frame::Command(Command::Stop)]);
        assert!(errands.state()["doctor"]["ask"].as_str().unwrap().contains("middle of the room"));
        errands.answer();
        assert_eq!(errands.state()["doctor"]["ask"], Value::Null);
        (0..SETTLING + 50).for_each(|_| errands.sample(&Sample::default()));
        assert!(errands.state()["doctor"]["ask"].as_str().unwrap().contains("in front of sensor 0"));
        errands.answer();
        (0..SETTLING + 50).for_each(|_| errands.sample(&Sample::default()));
        let state = errands.state();
        assert_eq!(state["doctor"]["found"][0]["wrong"], true, "{state}");
    }
}
