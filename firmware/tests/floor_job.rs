//! The floor job on the robot's tasks: told to clean, it leaves its dock, tells how far it is, stands where it is stopped and saves
//! its map meanwhile, goes on, and ends in its dock.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{Home, Tasks};
use common::ranges::Ranges;
use hal_sim::floor::{FloorRaster, Moment};
use hal_sim::{Pose2, SimOptions, plan_file};
use robot::FloorState;
use robot::rig::BuiltIn;
use wire::{Command, Floor, Frame, Place};

/// Longest that the room may take, seconds.
const LONGEST_S: u32 = 1200;

/// What was swept in truth, and what the robot said of it.
struct Watch<'h> {
    home: &'h Home,
    raster: FloorRaster,
    told: Vec<Floor>,
    place: Place,
    time_s: f64,
}

impl Watch<'_> {
    /// Lets a time pass that is a multiple of a fifth of a second.
    fn pass(&mut self, tasks: &mut Tasks<'_>, seconds: f64) {
        for _ in 0..(5.0 * seconds).round() as u32 {
            tasks.drive(0.2);
            self.time_s += 0.2;
            let pose = self.home.board.with_simulation(|simulation| simulation.pose_in_plan());
            let doing = self.told.last().and_then(Floor::state).map_or("", FloorState::name);
            self.raster.record(&Moment { t_s: self.time_s, pose, doing, is_pressed: false, is_on_floor: true });
            for frame in self.home.heard() {
                match frame {
                    Frame::Floor(floor) => self.told.push(floor),
                    Frame::Place(place) => self.place = place,
                    _ => {}
                }
            }
        }
    }

    fn last(&self) -> Floor {
        *self.told.last().expect("the floor is told")
    }

    fn state(&self) -> FloorState {
        self.last().state().expect("a state of this program")
    }
}

#[test]
fn it_cleans_a_room_on_command_with_a_pause_and_ends_in_its_dock() {
    let mut plan = plan_file::load("room").expect("a built-in plan");
    // In the dock at the western wall.
    plan.start = Pose2::new(0.185, 1.75, core::f64::consts::PI);
    plan.has_dock = true;
    let home = Home::of(&plan, BuiltIn::Sharp, SimOptions::default());
    let start = home.board.with_simulation(|simulation| simulation.pose_in_plan());
    let raster = FloorRaster::new(&plan, SimOptions::default().body_radius_m, start);
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), |tasks| {
        let mut watch = Watch { home: &home, raster, told: Vec::new(), place: Place::default(), time_s: 0.0 };
        watch.pass(tasks, 2.0);
        assert!(watch.told.is_empty(), "it was not told to clean: {:?}", watch.told);

        home.command(Command::Clean { anew: true });
        watch.pass(tasks, 110.0);
        assert!((108..=111).contains(&watch.told.len()), "one a second: {}", watch.told.len());
        assert!(watch.told.iter().any(|floor| floor.state() == Some(FloorState::Undocking)));
        let before = watch.last();
        assert!(before.swept_m2 > 1.0 && (105..=111).contains(&before.seconds), "{before:?}");

        let driving = watch.place;
        home.command(Command::Stop);
        watch.pass(tasks, 4.0);
        let stood = home.truth();
        watch.pass(tasks, 6.0);
        let moved_m = (home.truth().x_m - stood.x_m).hypot(home.truth().y_m - stood.y_m);
        assert!(moved_m < 1e-6, "it stands: {moved_m} m");
        let saves = watch.place.saves;
        assert!(
            watch.state() == FloorState::Paused && saves == driving.saves + 1,
            "its map is saved meanwhile: {driving:?} {saves}"
        );

        home.command(Command::Clean { anew: false });
        while watch.state() != FloorState::Done && watch.last().seconds < LONGEST_S {
            watch.pass(tasks, 1.0);
        }
        let (last, score) = (watch.last(), watch.raster.score());
        assert_eq!(watch.state(), FloorState::Done, "{last:?}");
        assert!(last.swept_m2 > before.swept_m2, "it went on with what it had: {last:?}");
        assert!(score.swept >= 0.96, "{} of the floor", score.swept);
        assert!(score.home_m <= 0.05, "{} m from the dock", score.home_m);
        watch.pass(tasks, 3.0);
        assert_eq!(watch.place.saves, saves + 1, "back in its dock it saves the map");
        let faults = home.shared.faults.get();
        let lost = [faults.samples_dropped, faults.frames_dropped, faults.late_tasks, faults.dead_man_stops];
        assert_eq!(lost, [0; 4], "{faults:?}");
    });
    assert!(home.kept_map_has_dock(), "the map is kept with its dock");
}
