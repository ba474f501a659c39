//! What is said of each system: what it is, what it is good at and where it falls short. Figures are not written here but
//! [found](crate::verdict) among what was measured.

/// A system of the page, or a family of them.
pub struct System {
    /// Who.
    pub title: &'static str,
    /// Its names in the experiments, the one that is judged first.
    pub variants: &'static [&'static str],
    /// Its names on logs.
    pub kinds: &'static [&'static str],
    /// What it is.
    pub what: &'static str,
    /// What it is good at.
    pub good: &'static str,
    /// What it cannot do, and why.
    pub short: &'static str,
}

/// The systems.
pub const SYSTEMS: [System; 12] = [
    System {
        title: "After Abrate, Bona and Indri",
        variants: &["after Abrate"],
        kinds: &["abrate"],
        what: "Lines through a metre of readings by end-point fits, in a plain Kalman filter.",
        good: "A few microseconds, and no assumption of right angles: good where walls are straight and often seen again.",
        short: "A line over a corner, or a heading that drifted within the window, goes into the map as it is. Nothing ties walls \
                to each other, and readings that share their odometry count as independent, so that it is far too sure.",
    },
    System {
        title: "After Choi, Lee and Oh 2008",
        variants: &["after Choi 2008", "after Choi 2008, free"],
        kinds: &["choi-2008", "choi-2008-free"],
        what: "Hough lines from the readings of all beams together, held to the map's right angles; the variant \"free\" is without them.",
        good: "What right angles are worth is the difference between the two. It sees a wall by several beams at once, where \
               others need a long stretch of one.",
        short: "Its covariance comes from the scatter of the points alone; what all points of a window share is not in it. A wall \
                that stands askew is turned onto the grid.",
    },
    System {
        title: "After OrthoSLAM",
        variants: &["after OrthoSLAM"],
        kinds: &["ortho-slam"],
        what: "Only lines parallel or at right angles; one filter for the heading, and one for each distance between parallel walls.",
        good: "The cheapest of all, and a heading that hardly drifts.",
        short: "Two parallel walls are rarely within the range of these sensors at the same time, so links are few and \
                positions drift. Three separate variances say nothing of what the axes' own direction is off by.",
    },
    System {
        title: "Sparse-gslam, and with SoMaSLAM's soft right angles",
        variants: &["sparse-gslam", "with soft right angles"],
        kinds: &["sparse-gslam", "soma-slam"],
        what: "A graph of poses and lines, loops closed by matching submaps; made for a drone with four beams of 2 m.",
        good: "It corrects the past, needs no right angles and closes loops without any wall that was seen twice.",
        short: "With the noise of 8 cm that its settings state it weighs walls little. In hallways without features a match slides along \
                the wall, and one wrong shift bends a round. On its authors' own log late matches agree with each other on a turn that the \
                odometry's stated noise all but excludes, so that their weights stay small; surer matches, less sure ones, other limits \
                of the weight and of the score made it no sharper.",
    },
    System {
        title: "After Beevers and Huang",
        variants: &["after Beevers, 100", "after Beevers, 600", "after Beevers, 40, square"],
        kinds: &["beevers-100", "beevers-600", "beevers-40-square"],
        what: "Particles, each with its own lines, over multiscans of a metre; with 40 particles walls stand at right angles.",
        good: "Cheap per particle, and several places of a wall are kept in mind until a loop decides.",
        short: "Hardly any particle is left of the first loop when it closes, and those that are left are sure of themselves \
                beyond measure. Right angles are worth more than particles.",
    },
    System {
        title: "Sonar: after Zunino and Christensen, after Choi, Ahn and Chung 2005",
        variants: &["after Zunino, sonar", "after Choi 2005, sonar"],
        kinds: &["zunino-2001", "choi-2005"],
        what: "Edges where the arcs of several wide cones meet, in a Kalman filter; the second with walls as tangents of arcs.",
        good: "Edges tell a place in both directions, where doors and corners are passed.",
        short: "Along bare walls there are few edges, and a pair of echoes of one wall passes for one. A wide cone sees no thin thing and \
                no slanting wall.",
    },
    System {
        title: "After Diosi and Kleeman: polar scan matching",
        variants: &["after Diosi, laser"],
        kinds: &["psm"],
        what: "Whole scans matched with stored ones, in a Kalman filter over their poses.",
        good: "It needs no walls, no right angles and no map: furniture serves as well.",
        short: "It needs whole scans, of some sixty rays and more, and far more time and memory. Nothing holds it along a bare \
                corridor. With the source's own rule, that a surface faces its beam, matches along corridors err by decimetres.",
    },
    System {
        title: "After Jensfelt and Christensen: given walls",
        variants: &["after Jensfelt, given walls"],
        kinds: &["jensfelt-1999"],
        what: "Pose tracking by a range-weighted Hough transform around each wall of a map that was measured by hand to a centimetre.",
        good: "Nothing drifts while a mapped wall is in range.",
        short: "It does not calibrate: an error of gain goes straight into its pose. It is given the map, so it stands beside \"floor\".",
    },
    System {
        title: "After Grossmann and Poli: relocalisation",
        variants: &[],
        kinds: &[],
        what: "A grid of probabilities over every pose of a home whose walls are given, weighed by Hough lines.",
        good: "It keeps every place in mind from the first line on, needs no map of its own, and so is sure after less way than the search of the \
               kept map.",
        short: "Megabytes, and ten and more milliseconds of a desk's processor at each update, growing with the home; the search of the kept map \
                runs in a robot's memory, and its claim is the stricter one. Rooms that look alike stay alike.",
    },
    System {
        title: "After Wijk: triangulation alone",
        variants: &[],
        kinds: &[],
        what: "Edges where the arcs of several sonar cones meet, without a filter.",
        good: "Nearly every edge that the robot passes is reported.",
        short: "Many reports are of no edge: two echoes of one wall meet in a point as well. A filter on top must find out which.",
    },
    System {
        title: "Stephens and Ester as line extractors",
        variants: &[],
        kinds: &[],
        what: "Lines by the likelihood of all points of a window, and lines through clusters of near points.",
        good: "The likelihood uses each reading's own noise and gives the best directions among those that look at a window alone.",
        short: "It costs twice a plain Hough transform and invents more lines. A cluster goes round a corner, and is no line then.",
    },
    System {
        title: "The estimator without its parts",
        variants: &["report 3.1, free", "report 3.2, snapped", "grid, uncalibrated"],
        kinds: &[],
        what: "Its own variants: walls in any direction; walls snapped to right angles; the wall grid without calibration.",
        good: "They say what right angles and calibration are worth on the same readings.",
        short: "They are no systems of others.",
    },
];

/// What would be tried next where the estimator is behind, by log or plan.
pub const NEXT: [(&str, &str); 6] = [
    (
        "smcl-S12",
        "the distance scale is learned late, and what was drawn until then stays; next: hand the looking-back map to the filter where it \
         is likelier",
    ),
    ("smcl-S8", "looking back trusts early walls too much; next: keep the likelier of both paths"),
    ("intel-loops", "a row a second leaves most turns unseen; next: keep the likelier of both paths"),
    (
        "fr079-first-realodo",
        "one unseen slip in a room without a mapped wall turns everything after it; next: slips found by the jolt detector",
    ),
    (
        "olsson-demo",
        "hallways with two parallel walls leave the way along them to the wheels; next: end walls as loop closures",
    ),
    ("wean-1", "people are taken for walls for a while; next: forget what moves"),
];
