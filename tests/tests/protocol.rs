//! The page about the serial protocol has the bytes that the crate `wire` sends.

use std::fmt::Write as _;
use std::path::Path;

use wire::{Command, Contacts, Frame, MapAnswer, MapRefusal, MapRequest, Motors, Range, Sample, encode};

/// A frame of which the page shows the bytes, and how it names it.
fn examples() -> Vec<(&'static str, Frame)> {
    let ranges = [Range::Missing, Range::Counts(1000), Range::Metres(0.5)].into_iter().collect();
    let contacts = Contacts { cliff: true, ..Contacts::default() };
    let sample = Sample { time_us: 1_000_000, left_ticks: 300, right_ticks: -300, ranges, contacts };
    let motors = Motors { time_us: 1_000_000, left: 0.25, right: -0.25 };
    let bytes = [1, 2, 3, 4].into_iter().collect();
    vec![
        ("`Start`", Frame::Command(Command::Start)),
        ("`Stop`", Frame::Command(Command::Stop)),
        ("`ResetMap`", Frame::Command(Command::ResetMap)),
        ("`Spin`, left 0.5, right -0.5", Frame::Command(Command::Spin { left: 0.5, right: -0.5 })),
        ("`Clean`, not anew", Frame::Command(Command::Clean { anew: false })),
        ("`Motors` at 1 s, left 0.25, right -0.25", Frame::Motors(motors)),
        (
            "`Sample` at 1 s, 300 and -300 ticks, ranges missing, 1000 counts, 0.5 m; no floor under the front",
            Frame::Sample(sample),
        ),
        ("`MapRequest`, `Get` from place 96", Frame::MapRequest(MapRequest::Get { offset: 96 })),
        (
            "`MapRequest`, `Put` of the bytes 1, 2, 3, 4 at place 0",
            Frame::MapRequest(MapRequest::Put { offset: 0, bytes }),
        ),
        ("`MapAnswer`, `Refused`, since it drives", Frame::MapAnswer(MapAnswer::Refused(MapRefusal::Driving))),
    ]
}

#[test]
fn the_page_has_the_bytes_of_its_examples() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/protocol.md");
    let page = std::fs::read_to_string(&path).expect("the page");
    for (name, frame) in examples() {
        let bytes = encode(&frame).expect("every known frame fits");
        let hex = bytes.iter().fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x} ");
            hex
        });
        let row = format!("| {name} | `{}` |", hex.trim_end());
        assert!(page.contains(&row), "{} should have the row\n{row}", path.display());
    }
    assert!(page.contains(&format!("No frame is longer than {} bytes", wire::FRAME_CAPACITY)));
}
