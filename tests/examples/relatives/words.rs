//! What the page says beside its figures.

/// The page's beginning.
pub const HEAD: &str = "\
# Relatives: other systems on the same drives

Written by `cargo run --release --package tests --example relatives`, which may be stopped and goes on where it was; `--seeds N` and
`--replays N` do a part, and this page says which part was done. [What the systems are](../reference/relatives.md); a name that begins
with \"after\" is our reading of a paper whose full text was not at hand.

- Every drive is simulated once, steered by the estimator, and every system gets its samples; what has another sensor (laser, sonar)
  looks along the same true path. Errors are those of the pose at the time, after the best alignment of the whole path; \"looking back\" is the
  path as the system knows it in the end.
- Seeds 51 to 100 chose nothing of the estimator's. Parameters of the sources are kept where they are known; the scan matcher's weight was
  chosen on seeds 1001 to 1003, everything else that is ours was set once and not tuned.
- A run is lost where its path is more than half a metre off. End points: RMS distance from the nearest true wall, at most 0.3 m each. \"report\" and
  \"grid\" are variants of the estimator, \"floor\" is given the map and the calibration.
- Microseconds are of the machine that made this page while it was busy with other things: within a factor of three.

";

/// Systems shown over calibration and drift.
pub const SHOWN: [&str; 8] = [
    "dead reckoning",
    "grid, calibrated",
    "after Abrate",
    "after Choi 2008",
    "after OrthoSLAM",
    "with soft right angles",
    "after Beevers, 40, square",
    "after Diosi, laser",
];

/// Systems shown over the number of rays.
pub const BY_RAYS: [&str; 5] = ["ours", "after Choi 2008", "OrthoSLAM", "sparse-gslam", "scan matching"];

/// What a case is.
pub fn case(name: &str) -> &'static str {
    match name {
        "nominal" => {
            "1 % gain and 0.5 % wheel errors, drawn anew by each seed; only the estimator calibrates itself, the others take the rig file\n\
             for exact, as their authors took their own calibration."
        }
        _ => {
            "The robot's gains, wheels and track are exactly what its rig file says: as a careful calibration by hand would have it."
        }
    }
}

/// What a figure is about.
pub fn about(name: &str) -> &'static str {
    match name {
        "calibration" => {
            "The flat; gain and wheel errors as stated (1), none (0), and twice and four times what every system is told."
        }
        "drift" => "The flat; wheels of unequal size turn the robot by so much a metre, and no system is told.",
        _ => {
            "The flat, seen by a laser thinned to so many rays over the half circle ahead, up to 8 m, five scans a second. The estimator\n\
             takes 16 readings at most. A scan matcher needs a whole scan: under 60 rays it loses its way."
        }
    }
}

/// The label of an axis.
pub fn axis(key: &str) -> &'static str {
    if key == "error_ratio" { "calibration errors over those stated" } else { "drift, degrees per metre" }
}

/// Before the table of logs.
pub const REAL: &str = "\
Replays a log: REPLAYS, which differ in the range noise that the rig file states, by up to 4 %; the median, in brackets the worst. Sharper:
how much less the mean map entropy of the rig's end points is than by odometry. [The logs](../notes/real-logs.md) are not part of this
project.";

/// The paragraphs.
pub const SYSTEMS: &str = "";
