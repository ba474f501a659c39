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
- Seeds 51 to 100 chose nothing of the estimator's. Parameters of the sources are kept where they are known; what is ours was set once and not
  tuned. Which stored scans the scan matcher looks at was found on wean-1 and wean-5, so those two are no test of it.
- A run is lost where its path is more than half a metre off. End points: RMS distance from the nearest true wall, at most 0.3 m each. \"report\" and
  \"grid\" are variants of the estimator, \"floor\" is given the map and the calibration.
- Microseconds are processor time a step, with the front end that all share; on logs by the clock, the least of the replays. Kilobytes are
  those of the state in the end; the estimator's are of the workbench's size (the robot's is 32 kB).

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
pub const BY_RAYS: [&str; 5] = ["OrthoSLAM", "ours", "sparse-gslam", "after Choi 2008", "scan matching"];

/// A system's name in a legend.
pub fn legend(name: &str) -> String {
    if name == "grid, calibrated" { "the estimator".to_owned() } else { name.to_owned() }
}

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
             takes 16 readings at most; the scan matcher was not run below 31 rays, since it needs the slope of surfaces from ray to ray."
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

/// Before the table of carried robots.
pub const CARRIED: &str = "\
## Finding oneself, and tracking, in a kept map

A robot with eight sensors is put down at a random free place of a home of which it has the map that a ten-minute drive left. *After Grossmann
and Poli*: Hough lines in a grid of probabilities over all poses (10 cm, 5 degrees), given the map's walls; it claims a place where that has 90 % twice
in a row. Ours searches the same map with the map that it begins anew, and claims at odds of 1000 to 1, twice. Right is within 0.3 m and 10
degrees. Tracking: RMSE in the minute after our claim, from the same pose, in the same map (so each with the map's own error): ours, which goes on mapping
and calibrates, beside after Jensfelt and Christensen, which takes the map's walls as given.

| home | carries | ours: claims | path to the claim, m | wrong | after Grossmann: claims | path, m | wrong | tracking: ours cm | after Jensfelt cm | grid, ms an update |
|---|---|---|---|---|---|---|---|---|---|---|
";

/// Before the table of edges.
pub const CORNERS: &str = "\
## Edges by triangulation alone (after Wijk)

The sonar's reports of edges, placed by the true pose at the time. Precision: how many lie within 10 cm of an edge of the home. Recall: how many of the edges
that the robot passed in sight within 2 m were reported within 10 cm.

| home | drives | reports a drive | precision % | edges passed a drive | recall % |
|---|---|---|---|---|---|
";

/// Before the table of extractors.
pub const EXTRACTORS: &str = "\
## Line extractors

The same 1.5 m of readings, once a metre of the flat, at three drifts of the odometry. A wall counts as seen with ten readings over 0.4 m. Found: within 5
degrees and 8 cm. Ours is no extractor: the estimator is begun afresh at the start of each stretch, and its walls are taken at the end.

| drift °/m | extractor | seen walls found % | invented, 100 windows | angle RMS ° | offset RMS cm | µs a window |
|---|---|---|---|---|---|---|
";
