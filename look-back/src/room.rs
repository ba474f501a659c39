//! Room in a full diary.

use crate::diary::Diary;
use crate::thin;

/// Of so many groups one may be on no wall where there is no room for more.
const MOST_LOOSE: usize = 4;

/// One in so many is forgotten at once, so that a full diary need not look through all of them at every step; those of fewer
/// hits than this.
const AT_ONCE: usize = 32;
const MOST_COUNTED: usize = 32;

/// Multiply-adds that making room takes for each keyframe and group.
const LOOK_COST: u32 = 4;

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// Makes two keyframes one, forgets the smallest groups on no wall, or a wall that too few hits met, where there is no room for
    /// so many more: the multiply-adds that takes; none where there is room.
    pub(crate) fn make_some_room(&mut self, keyframes: usize, groups: usize, walls: usize) -> Option<u32> {
        let cost = LOOK_COST * (self.keyframes.len() + self.groups.len()) as u32;
        let is_made = (self.keyframes.len() + keyframes > K && self.thin())
            || (self.groups.len() + groups > G && (self.drop_fewest() || self.thin()))
            || (self.walls.iter().filter(|wall| wall.is_none()).count() < walls && self.drop_least_wall().is_some());
        is_made.then_some(cost)
    }

    /// Forgets the groups on no wall that have the fewest hits, some at once; false where those on no wall are few.
    pub(crate) fn drop_fewest(&mut self) -> bool {
        let mut of_hits = [0_usize; MOST_COUNTED];
        for group in self.groups.iter().filter(|group| group.wall().is_none()) {
            if let Some(count) = of_hits.get_mut(usize::from(group.hits).min(MOST_COUNTED - 1)) {
                *count += 1;
            }
        }
        if of_hits.iter().sum::<usize>() <= G / MOST_LOOSE {
            return false;
        }
        let mut few = 0;
        let enough = of_hits.iter().position(|count| {
            few += count;
            few >= G / AT_ONCE
        });
        let (most, before) = (enough.unwrap_or(MOST_COUNTED), self.groups.len());
        for group in self.groups.iter_mut().filter(|group| group.wall().is_none() && usize::from(group.hits) <= most) {
            group.hits = 0;
        }
        self.drop_empty();
        self.revision = self.revision.wrapping_add(1);
        self.groups.len() < before
    }

    /// Forgets groups of no hits.
    fn drop_empty(&mut self) {
        let mut groups = self.groups.iter();
        for key in &mut self.keyframes {
            let own = groups.by_ref().take(key.groups.into());
            key.groups = own.filter(|group| group.hits > 0).count() as u16;
        }
        self.ahead = groups.filter(|group| group.hits > 0).count() as u16;
        self.groups.retain(|group| group.hits > 0);
    }

    /// Makes two keyframes one; false where there are not enough.
    pub(crate) fn thin(&mut self) -> bool {
        let is_done = thin::thin(
            &mut self.keyframes,
            &mut self.groups,
            &self.gains,
            (&self.calibration, &self.odometry),
            &self.walls,
            self.placed,
        );
        if is_done {
            self.revision = self.revision.wrapping_add(1);
            self.losses.thinned = self.losses.thinned.saturating_add(1);
        }
        is_done
    }
}
