//! What a drive in the loop does to the floor, in truth and by the firmware's own word.

use hal_sim::floor::{FloorRaster, FloorScore, Moment as FloorMoment};
use hal_sim::{Plan, Simulation};
use robot::FloorState;
use wire::Floor;

use super::boot::Moment;

/// The floor while it is swept.
pub struct Sweeping {
    raster: FloorRaster,
    told: Option<Floor>,
}

/// The floor after that.
#[derive(Clone, Debug)]
pub struct Swept {
    /// In truth.
    pub score: FloorScore,
    /// The firmware's last word; none where it said nothing of it.
    pub told: Option<Floor>,
}

impl Sweeping {
    /// Nothing swept yet.
    pub fn new(plan: &Plan, simulation: &Simulation) -> Self {
        let radius_m = simulation.options().body_radius_m;
        Self { raster: FloorRaster::new(plan, radius_m, simulation.pose_in_plan()), told: None }
    }

    /// A period has passed.
    pub fn record(&mut self, moment: &Moment) {
        self.told = moment.floor.or(self.told);
        let contacts = moment.shown.contacts;
        self.raster.record(&FloorMoment {
            t_s: moment.shown.time_us as f64 * 1e-6,
            pose: moment.in_plan,
            doing: self.state().map_or("", FloorState::name),
            is_pressed: contacts.bump_left || contacts.bump_right,
            is_on_floor: !contacts.lifted,
        });
    }

    fn state(&self) -> Option<FloorState> {
        self.told.as_ref().and_then(Floor::state)
    }

    /// Whether the firmware said that it has nothing left to do.
    pub fn is_over(&self) -> bool {
        matches!(self.state(), Some(FloorState::Done | FloorState::Flat | FloorState::Away | FloorState::Unreached))
    }

    /// How it ended.
    pub fn finish(self) -> Swept {
        Swept { score: self.raster.score(), told: self.told }
    }
}
