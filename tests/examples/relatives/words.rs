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
- Microseconds are by the clock, and the machine had several times the work that it has processors for: only the smallest figures of a system
  over the plans tell anything, others are up to hundreds of times too long.

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
pub const SYSTEMS: &str = "\
## System by system

One seed and one replay are no sweep: what follows says what the tables above show, and no more. The command goes on from there.

**After Abrate, Bona and Indri.** Lines of a metre of readings by end-point fits, and a plain Kalman filter: a few microseconds. Good where
walls are straight and often seen again (fr079-first: 22 cm where odometry has 78). A line over a corner, or a heading that drifted within
the window, goes into the map as it is; nothing ties walls to each other, and it is far too sure.

**After Choi, Lee and Oh 2008.** The best of the systems on single beams in the simulated flat, and on wean-1 the sharpest of them: lines are taken
from all beams together and held to the map's right angles. Without the constraint its error in the flat is six times as large: that is
what right angles are worth. Its covariance comes from the scatter alone, and it is too sure by far, as Rousse and Qiu say of
it.

**After OrthoSLAM.** Microseconds and 20 kB, and a heading that hardly drifts. Positions do: two parallel walls are rarely within 1.5 m at
the same time, so links are few. Three separate variances say nothing of what the axes' own direction is off by, and NEES is in the
hundreds. On smcl-S12 it is ahead of the estimator at the time.

**Sparse-gslam, and with soft right angles.** Made for a drone with ranges of 2 m; with the noise of 8 cm that its settings state, it weighs walls
little. Looking back it is better than it was at the time, on fr079-first by half. Soft right angles halve its error in the flat (nominal).
**Short:** on its authors' own log, olsson-demo, ours looks back far sharper (0.75 against 0.22 nats), not within 0.2 nats. Loops are closed
there, but in hallways without features a match slides along the wall, and one wrong shift of two metres bends a round; a match
that says how far it can slide was tried and made fr079-first worse. Ours is one graph and theirs are two.

**After Beevers and Huang.** Cheap per particle, and poor: of 100 particles, and of 600, hardly any is left by the first loop, and those are sure of
themselves beyond measure. With walls at right angles 40 are better in the flat than 600 without.

**Sonar: after Zunino and Christensen, after Choi, Ahn and Chung 2005.** Edges help where doors and corners are passed (the flat) and not along
bare walls (the room), where they can be worse than the motion alone: there are few, and a pair of echoes of one wall passes for one.
Wide cones see no thin thing and no slanting wall; nothing here is near what beams give.

**After Diosi and Kleeman: polar scan matching.** With 181 rays it is about as good as the estimator with eight beams of 1.5 m, and needs no walls. The
source's covariance (20 cm, 4 degrees) weighs matches so little that odometry wins; a tenth of it was chosen on other seeds.
**Short:** on wean-1 it is *less* sharp than odometry by 0.08 nats, where 0.4 sharper was asked for: passes come nearer to each other
(23 cm instead of 74), but each match's error is drawn into the map, and along a corridor nothing holds it. Its weight, a limit of the
residual, fewer and more stored scans were tried on it without a setting that serves wean-5, too; why is not known.

**After Jensfelt and Christensen: given walls.** With the walls measured to a centimetre it is about as good as the estimator, which has to find
them. It does not calibrate, so that gains go straight into its pose. The \"floor\" is what is possible with everything given.

**Where the estimator loses.** On smcl-S12, at the time, to odometry and to all of these: the distance scale is learned late, and what was drawn
until then stays; looking back it is ahead of all. On smcl-S8 looking back is worse than it was at the time, and no better than
sparse-gslam's. On intel-loops, a row a second, it is ahead of all at the time, but looking back makes it worse. Next: keep the
likelier of both.

**Not measured.** Grossmann and Poli's relocalisation, the line extractors of Ester and of Stephens, Wijk's precision and recall. Kilobytes of
the estimator are those of the workbench's size (the robot's is 32 kB).
";
