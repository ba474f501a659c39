//! What a simulated robot is to do.

/// What the robot is to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Job {
    /// Map the home.
    #[default]
    Explore,
    /// Sweep its floor and come back.
    Clean,
}

impl Job {
    /// Every one, with its name.
    pub const ALL: [(&'static str, Self); 2] = [("explore", Self::Explore), ("clean", Self::Clean)];

    /// What it is called on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, job)| *job == self).map_or("", |(name, _)| name)
    }
}
