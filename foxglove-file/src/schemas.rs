//! The topics of the file, and the JSON schemas of their messages by Foxglove's names: what of each is written here.

/// What a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// The estimated pose.
    Pose,
    /// The true pose.
    Truth,
    /// The pose by the motion sensors alone.
    DeadReckoning,
    /// The estimated path so far.
    Path,
    /// The map.
    Walls,
    /// The true plan.
    Plan,
    /// Where beams ended since the last message.
    Hits,
    /// Numbers to plot.
    Figures,
}

impl Topic {
    /// Every one.
    pub const ALL: [Self; 8] =
        [Self::Pose, Self::Truth, Self::DeadReckoning, Self::Path, Self::Walls, Self::Plan, Self::Hits, Self::Figures];

    /// What it is called in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "/pose",
            Self::Truth => "/truth",
            Self::DeadReckoning => "/dead_reckoning",
            Self::Path => "/path",
            Self::Walls => "/walls",
            Self::Plan => "/plan",
            Self::Hits => "/hits",
            Self::Figures => "/figures",
        }
    }

    /// Name and text of its schema.
    pub fn schema(self) -> (&'static str, &'static str) {
        SCHEMAS[match self {
            Self::Pose | Self::Truth | Self::DeadReckoning => 0,
            Self::Path => 1,
            Self::Walls | Self::Plan => 2,
            Self::Hits => 3,
            Self::Figures => 4,
        }]
    }
}

/// Names and texts of all schemas.
pub const SCHEMAS: [(&str, &str); 5] = [
    ("foxglove.PoseInFrame", include_str!("schemas/pose_in_frame.json")),
    ("foxglove.PosesInFrame", include_str!("schemas/poses_in_frame.json")),
    ("foxglove.SceneUpdate", include_str!("schemas/scene_update.json")),
    ("foxglove.PointCloud", include_str!("schemas/point_cloud.json")),
    ("wall_slam.Figures", include_str!("schemas/figures.json")),
];
