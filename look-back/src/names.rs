//! Which walls the filter's identifiers are, and which make room.

use crate::diary::{Diary, FEWEST};
use crate::wall::Wall;
use slam_core::Standing;

/// Identifiers that the diary knows walls by, two for each.
pub(crate) const NAMES: usize = 2 * crate::ROBOT_WALLS;

/// An identifier that the filter gave a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Name {
    pub id: u16,
    pub wall: u8,
}

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// The same for a reading of this sensor, which mostly sees the wall again that it saw last.
    pub(crate) fn wall_seen_by(&mut self, sensor: u8, id: u16) -> Option<usize> {
        let last = self.seen.get(usize::from(sensor)).and_then(|place| self.names.get(usize::from(*place)));
        if let Some(name) = last.filter(|name| name.id == id) {
            return Some(name.wall.into());
        }
        let place = if let Some(place) = self.names.iter().position(|name| name.id == id) {
            place
        } else {
            // Its name is the last one then.
            self.wall_named(id)?;
            self.names.len() - 1
        };
        if let (Some(seen), Ok(place)) = (self.seen.get_mut(usize::from(sensor)), u8::try_from(place)) {
            *seen = place;
        }
        self.names.get(place).map(|name| name.wall.into())
    }

    /// The wall that the filter calls `id`; a new one where there is none yet and there is room.
    pub(crate) fn wall_named(&mut self, id: u16) -> Option<usize> {
        if let Some(name) = self.names.iter().find(|name| name.id == id) {
            return Some(name.wall.into());
        }
        let Some(wall) = self.free_wall() else {
            self.losses.walls = self.losses.walls.saturating_add(1);
            return None;
        };
        if self.names.is_full() {
            self.forget_a_name();
        }
        *self.walls.get_mut(wall)? = Some(Wall::NEW);
        self.names.push(Name { id, wall: u8::try_from(wall).ok()? }).ok()?;
        Some(wall)
    }

    /// The filter has the wall that it calls `id` stand so to the grid. Of two walls that are one, one may stand there exactly and the other
    /// not yet. Of walls that were turned back the filter says what was before.
    pub(crate) fn stand(&mut self, id: u16, standing: Standing) {
        let Some(wall) = self.names.iter().find(|name| name.id == id).map(|name| name.wall) else { return };
        if let Some(wall) = self.walls.get_mut(usize::from(wall)).and_then(Option::as_mut)
            && !matches!(wall.told, Standing::Exact(_))
            && !(self.turned.is_new && wall.told != Standing::Unknown)
        {
            wall.told = standing;
        }
    }

    /// Forgets the oldest name of a wall that has a newer one.
    fn forget_a_name(&mut self) {
        let mut names = self.names.iter().enumerate();
        let is_newer = |i: usize, wall: u8| self.names.iter().skip(i + 1).any(|later| later.wall == wall);
        let Some((gone, _)) = names.find(|(i, name)| is_newer(*i, name.wall)) else { return };
        let mut i = 0;
        self.names.retain(|_| {
            i += 1;
            i != gone + 1
        });
    }

    /// A place for a wall: one that is free, or that of one that makes room.
    fn free_wall(&mut self) -> Option<usize> {
        self.walls.iter().position(Option::is_none).or_else(|| self.drop_least_wall())
    }

    /// Forgets the wall that fewest hits met, where these are too few to matter: the place where it was.
    pub(crate) fn drop_least_wall(&mut self) -> Option<usize> {
        let walls = self.walls.iter().enumerate();
        let hits = walls.filter_map(|(place, wall)| Some((place, wall.as_ref()?.hits)));
        let (place, _) = hits.filter(|(_, hits)| *hits < FEWEST).min_by_key(|(_, hits)| *hits)?;
        self.remove_wall(place);
        Some(place)
    }

    /// Forgets a wall: its groups are on none.
    pub(crate) fn remove_wall(&mut self, place: usize) {
        self.groups.iter_mut().filter(|group| group.wall() == Some(place)).for_each(|group| group.set_wall(None));
        self.names.retain(|name| usize::from(name.wall) != place);
        if let Some(wall) = self.walls.get_mut(place) {
            *wall = None;
        }
        self.revision = self.revision.wrapping_add(1);
    }

    /// Wall `gone` turned out to be wall `kept`.
    pub(crate) fn unite(&mut self, kept: usize, gone: usize) {
        self.groups.iter_mut().filter(|group| group.wall() == Some(gone)).for_each(|group| group.set_wall(Some(kept)));
        let kept_name = u8::try_from(kept).unwrap_or(u8::MAX);
        for name in self.names.iter_mut().filter(|name| usize::from(name.wall) == gone) {
            name.wall = kept_name;
        }
        if let Some(wall) = self.walls.get_mut(gone) {
            *wall = None;
        }
    }

    /// An identifier that the filter gave this wall, the latest.
    pub fn id_of(&self, wall: usize) -> Option<u16> {
        self.names.iter().rev().find(|name| usize::from(name.wall) == wall).map(|name| name.id)
    }
}
