//! Which route: searches one after the other, each in parts, so that no step is late.

use core::ops::ControlFlow;

use slam_core::Pose;

use super::search::{Route, Squeeze};
use super::{Activity, Pilot, Senses, TRAIL};

/// A route is looked for this often, microseconds.
const ROUTE_US: u64 = 250_000;
/// Cells that a search for a route may look at in one step, so that none takes more than 150,000 instructions: what is a metre away is
/// found in one or two, and in three seconds the search has been everywhere in a home of fifty square metres, twice.
const CELLS_A_STEP: u16 = 80;

/// What a search for a route is at. Each begins where the one before found nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wave {
    /// Clear of obstacles.
    Clear,
    /// Between them.
    Squeezing,
    /// Clear of obstacles, to places where it has been in the round that is over.
    Anew,
}

impl<const S: usize, const N: usize> Pilot<S, N> {
    /// A route is looked for from the beginning, and at once.
    pub(super) fn look_anew(&mut self) {
        (self.wave, self.next_route_us) = (None, 0);
    }

    fn begin_wave(&mut self, wave: Wave, pose: &Pose) {
        let start = self.memory.cell_at(pose.x_m, pose.y_m);
        let eighths = libm::roundf(pose.theta_rad * (4.0 / core::f32::consts::PI)) as i32;
        let squeeze = if wave == Wave::Squeezing { Squeeze::Through } else { Squeeze::Leave };
        self.search.begin(&mut self.memory, start, (eighths & 7) as u8, squeeze);
        self.wave = Some(wave);
    }

    /// Begins a search when it is time, and goes on with the one that is under way. Until it has ended the route before stands.
    pub(super) fn look_for_route(&mut self, senses: &Senses<S>) {
        if self.wave.is_none() && senses.time_us >= self.next_route_us {
            self.next_route_us = senses.time_us.saturating_add(ROUTE_US);
            self.begin_wave(Wave::Clear, &senses.pose);
        }
        let Some(wave) = self.wave else { return };
        let ControlFlow::Break(route) = self.search.go_on(&mut self.memory, CELLS_A_STEP) else { return };
        match wave {
            _ if route.is_some() => self.take(route, senses),
            Wave::Clear => self.begin_wave(Wave::Squeezing, &senses.pose),
            Wave::Squeezing => self.begin_round(senses),
            Wave::Anew => self.take(None, senses),
        }
    }

    /// Nothing is left to visit.
    fn begin_round(&mut self, senses: &Senses<S>) {
        let pose = &senses.pose;
        (self.wave, self.route) = (None, None);
        if self.confinement.attempt(pose, self.config.radius_m) {
            self.begin(Activity::Stuck, senses);
            return;
        }
        self.rounds = self.rounds.saturating_add(1);
        self.memory.forget_visits();
        self.memory.visit(self.memory.cell_at(pose.x_m, pose.y_m), TRAIL);
        self.patience.renew(senses.time_us);
        self.begin_wave(Wave::Anew, pose);
    }

    /// A search has ended with this.
    fn take(&mut self, route: Option<Route>, senses: &Senses<S>) {
        let before = core::mem::replace(&mut self.route, route);
        self.wave = None;
        let activity = match route {
            None => Activity::Wandering,
            Some(Route { wall: true, .. }) => Activity::FollowingWalls,
            Some(_) => Activity::Exploring,
        };
        if activity != self.activity {
            self.begin(activity, senses);
        }
        if let Some(route) = route
            && self.patience.note(before.as_ref(), &route, senses.time_us)
            && let Some(before) = before
        {
            self.memory.visit(before.target, 1);
        }
    }
}
