//! Ray casting against an independent derivation, and what moves.
use hal_sim::plan::Plan;
use hal_sim::rng::Rng;
use hal_sim::world::World;
use hal_sim::{Pose2, SimOptions, Simulation, default_rig, plan_file};
use robot::WheelSpeeds;

/// Marches along the beam in small steps until the distance to the nearest thing vanishes (sphere tracing).
fn march(plan: &Plan, origin_m: [f64; 2], beam: [f64; 2]) -> f64 {
    let mut range_m = 0.0;
    for _ in 0..20_000 {
        let point_m = [origin_m[0] + range_m * beam[0], origin_m[1] + range_m * beam[1]];
        let to_faces = plan.faces.iter().map(|face| {
            let (ax, ay) = (face.to_m[0] - face.from_m[0], face.to_m[1] - face.from_m[1]);
            let (px, py) = (point_m[0] - face.from_m[0], point_m[1] - face.from_m[1]);
            let share = ((px * ax + py * ay) / (ax * ax + ay * ay)).clamp(0.0, 1.0);
            f64::hypot(px - share * ax, py - share * ay)
        });
        let to_rounds = plan
            .rounds
            .iter()
            .map(|round| f64::hypot(point_m[0] - round.centre_m[0], point_m[1] - round.centre_m[1]) - round.radius_m);
        let distance_m = to_faces.chain(to_rounds).fold(f64::INFINITY, f64::min);
        if distance_m < 1e-7 {
            break;
        }
        range_m += distance_m;
    }
    range_m
}

#[test]
fn casting_agrees_with_marching_along_the_beam() {
    let mut rng = Rng::stream(1, "test", 0);
    for (name, _) in plan_file::BUILT_IN {
        let plan = plan_file::load(name).unwrap();
        let world = World::new(&plan);
        for _ in 0..300 {
            let room = &plan.rooms[(rng.next_u64() % plan.rooms.len() as u64) as usize];
            let origin_m = [0, 1].map(|axis| rng.uniform(room.min_m[axis] + 0.01, room.max_m[axis] - 0.01));
            let angle_rad = rng.uniform(-4.0, 4.0);
            let beam = [angle_rad.cos(), angle_rad.sin()];
            let marched_m = march(&plan, origin_m, beam);
            let Some(hit) = world.cast(origin_m, beam) else {
                assert!(marched_m > 100.0, "{name}: {origin_m:?} {beam:?} {marched_m}");
                continue;
            };
            // A march that grazes a surface stops early.
            let grazes = hit.cos_incidence < 0.02 || marched_m < hit.range_m - 1e-4;
            assert!((hit.range_m - marched_m).abs() < 1e-4 || grazes, "{name}: {hit:?} {marched_m}");
            if marched_m < hit.range_m - 1e-4 {
                let end_m = [origin_m[0] + marched_m * beam[0], origin_m[1] + marched_m * beam[1]];
                assert!(world.clearance_m(end_m) < 1e-6, "{name}: {hit:?} {marched_m}");
            }
        }
    }
}

#[test]
fn incidence_and_face_are_those_of_what_is_hit() {
    let text = "[start]\nx_m = 0.0\ny_m = 0.0\n[[wall]]\nfrom_m = [1.0, -2.0]\nto_m = [1.0, 2.0]\n\
                [[round]]\ncentre_m = [-1.0, 0.05]\nradius_m = 0.1\n";
    let world = World::new(&plan_file::parse("test", "test", text).unwrap());
    let (s, c) = 0.5_f64.sin_cos();
    let wall = world.cast([0.0, 0.0], [c, s]).unwrap();
    assert_eq!(wall.face, Some(0));
    assert!((wall.cos_incidence - c).abs() < 1e-12 && (wall.range_m - 1.0 / c).abs() < 1e-12);
    let round = world.cast([0.0, 0.0], [-1.0, 0.0]).unwrap();
    assert_eq!(round.face, None);
    assert!((round.cos_incidence - 0.75_f64.sqrt()).abs() < 1e-12);
    assert_eq!(world.cast([0.0, 0.0], [0.0, 1.0]), None);
}

#[test]
fn doors_close_and_open_and_people_walk_to_and_fro() {
    let text = "[start]\nx_m = 0.0\ny_m = 0.0\n[[wall]]\nfrom_m = [3.0, -2.0]\nto_m = [3.0, 2.0]\n\
                [[door]]\nfrom_m = [2.0, -1.0]\nto_m = [2.0, 1.0]\ncloses_at_s = 5.0\nopens_at_s = 10.0\n\
                [[person]]\nspeed_mps = 1.0\nradius_m = 0.2\npath_m = [[1.0, 2.0], [1.0, 0.0]]\n";
    let mut world = World::new(&plan_file::parse("test", "test", text).unwrap());
    let mut range_m = |time_s| {
        world.set_time(time_s);
        world.cast([0.0, 0.0], [1.0, 0.0]).unwrap().range_m
    };
    assert_eq!(range_m(0.0), 3.0);
    assert_eq!(range_m(6.0), 0.8);
    assert_eq!(range_m(8.0), 2.0);
    assert_eq!(range_m(12.0), 3.0);
    assert!((range_m(2.0) - 0.8).abs() < 1e-12);
}

/// The robot stands in somebody's way for ten seconds, at this distance from a wall behind it: where it is then, metres, whether
/// its bumper was pressed.
fn stands_in_the_way(behind_m: f64, gives_way: bool) -> (f64, bool) {
    let text = format!(
        "[start]\nx_m = 1.5\ny_m = 0.0\nheading_deg = 180.0\n[[wall]]\nfrom_m = [{0}, -2.0]\nto_m = [{0}, 2.0]\n\
         [[person]]\ngives_way = {gives_way}\npath_m = [[0.0, 0.0], [4.0, 0.0]]\n",
        1.5 + behind_m,
    );
    let plan = plan_file::parse("test", "test", &text).unwrap();
    let mut simulation = Simulation::new(&plan, &default_rig(), SimOptions::default(), 1).unwrap();
    let mut is_pressed = false;
    for _ in 0..250 {
        simulation.step(WheelSpeeds::STOP);
        is_pressed |= simulation.contacts().bump_left || simulation.contacts().bump_right;
    }
    (simulation.pose_in_plan().x_m, is_pressed)
}

#[test]
fn who_gives_way_turns_round_before_the_robot_and_others_push_it() {
    let (x_m, is_pressed) = stands_in_the_way(1.0, true);
    assert!(x_m == 1.5 && !is_pressed, "{x_m} {is_pressed}");
    let (x_m, is_pressed) = stands_in_the_way(1.0, false);
    assert!(x_m > 2.0 && is_pressed, "{x_m} {is_pressed}");
}

#[test]
fn nobody_walks_the_robot_through_a_wall() {
    let radius_m = SimOptions::default().body_radius_m;
    for behind_m in [0.2, 0.3, 0.45, 0.6] {
        let (x_m, is_pressed) = stands_in_the_way(behind_m, false);
        assert!(is_pressed && x_m <= 1.5 + behind_m - radius_m + 0.003, "{behind_m}: {x_m}");
    }
}

#[test]
fn poses_relative_to_the_start_undo_it() {
    let start = Pose2::new(1.0, 2.0, 3.0);
    let pose = Pose2::new(-0.5, 0.25, -2.0);
    let inside = start.relative(&pose);
    let [x_m, y_m] = start.transform([inside.x_m, inside.y_m]);
    assert!((x_m - pose.x_m).abs() < 1e-12 && (y_m - pose.y_m).abs() < 1e-12);
    let halfway = Pose2::new(0.0, 0.0, 3.1).interpolate(&Pose2::new(1.0, 0.0, -3.1), 0.5);
    assert!(halfway.theta_rad.cos() < -0.999_999 && halfway.x_m == 0.5);
}
