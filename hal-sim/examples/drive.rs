//! Prints when each room is first visited, and what the pilot does: `drive PLAN MINUTES SEED DRIFT_RAD SENSORS`.
use hal_sim::{ClosedLoop, Estimate, SimOptions, Simulation, default_rig_with, nominal_ranges, plan_file};
use robot::PilotConfig;
use slam_core::Pose;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let name = args.get(1).map_or("flat", |s| s.as_str());
    let minutes: f64 = args.get(2).map_or(10.0, |s| s.parse().unwrap());
    let seed: u64 = args.get(3).map_or(1, |s| s.parse().unwrap());
    let drift: f32 = args.get(4).map_or(0.0, |s| s.parse().unwrap());
    let sensors: Vec<usize> =
        args.get(5).map_or((0..8).collect(), |s| s.split(',').map(|s| s.parse().unwrap()).collect());
    let svg = args.get(6);
    let plan = plan_file::load(name).unwrap_or_else(|e| panic!("{e}"));
    let rig = default_rig_with(&sensors);
    let begin = std::time::Instant::now();
    let simulation = Simulation::new(&plan, &rig, SimOptions::default(), seed).unwrap();
    let mut drive = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let mut truth = Pose::default();
    let mut path_m = 0.0;
    let mut bumps = 0;
    let mut visited = vec![None; plan.rooms.len()];
    let mut noise = hal_sim::rng::Rng::stream(seed, "test-pose", 0);
    let mut path = String::new();
    for i in 0..(minutes * 60.0 * 25.0) as usize {
        let t = i as f32 * 0.04;
        let mut estimator = |sample: &_| {
            let n = |noise: &mut hal_sim::rng::Rng, s: f64| (s * noise.gaussian()) as f32;
            let jump = if (t as i32 / 20) % 2 == 1 {
                0.1 * drift.signum() * if drift == 0.0 { 0.0 } else { 1.0 }
            } else {
                0.0
            };
            let turned = Pose::new(0.0, 0.0, drift * t / 600.0).compose(&truth);
            let pose = Pose::new(
                turned.x_m + n(&mut noise, 0.005) + jump,
                turned.y_m + n(&mut noise, 0.005),
                turned.theta_rad + n(&mut noise, 0.005),
            );
            Estimate { pose, ranges_m: nominal_ranges(&rig, sample) }
        };
        let frame = drive.step(&mut estimator);
        let before = truth;
        truth = frame.truth.to_pose();
        path_m += f32::hypot(truth.x_m - before.x_m, truth.y_m - before.y_m);
        bumps += usize::from(drive.simulation.contacts().any());
        let place = drive.simulation.pose_in_plan();
        if i % 5 == 0 {
            path += &format!("{:.3},{:.3} ", place.x_m, place.y_m);
        }
        for (room, v) in plan.rooms.iter().zip(&mut visited) {
            if v.is_none() && room.contains(place.x_m, place.y_m) {
                *v = Some(t);
            }
        }
    }
    let took = begin.elapsed();
    let rooms: Vec<_> = plan.rooms.iter().map(|r| r.name.as_str()).zip(visited).collect();
    println!(
        "{name} seed {seed}: {path_m:.0} m, bump steps {bumps}, rounds {}, given up {}, {took:.2?}\n  {rooms:?}",
        drive.pilot.rounds(),
        drive.pilot.given_up()
    );
    let walls = drive.simulation.coverage().walls(1.0, 0.0);
    let seen: f64 = walls.iter().map(|w| w.seen_m).sum();
    let all: f64 = walls.iter().map(|w| w.wall.length_m()).sum();
    println!("  walls seen {seen:.1} of {all:.1} m");
    if let Some(file) = svg {
        let mut out = String::from(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-0.5 -7 9 8' width='1100' height='980'><g transform='scale(1,-1)' fill='none' stroke-width='.02'><rect x='-1' y='-1' width='12' height='9' fill='white'/>",
        );
        for f in &plan.faces {
            out += &format!("<path stroke='black' d='M{} {}L{} {}'/>", f.from_m[0], f.from_m[1], f.to_m[0], f.to_m[1]);
        }
        for r in &plan.rounds {
            out +=
                &format!("<circle stroke='black' cx='{}' cy='{}' r='{}'/>", r.centre_m[0], r.centre_m[1], r.radius_m);
        }
        out += &format!("<polyline stroke='red' stroke-width='.01' points='{path}'/></g></svg>");
        std::fs::write(file, out).unwrap();
    }
}
