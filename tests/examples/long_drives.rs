//! Drives of a day and of three, hour by hour: `cargo run --release --package tests --example long_drives -- PLAN HOURS SEED`.

use std::env;

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [plan, hours, seed] = &arguments[..] else { panic!("PLAN HOURS SEED") };
    let home = hal_sim::plan_file::load(plan).expect("a plan");
    let (hours, seed) = (hours.parse().expect("hours"), seed.parse().expect("a seed"));
    println!("plan,seed,hour,rmse_m,nees,path_m,births,walls,least_pivot,flaw");
    tests::long_drive::drive(&home, hours, seed, |h| {
        println!(
            "{plan},{seed},{},{:.4},{:.2},{:.1},{},{},{:.2e},{}",
            h.number,
            h.rmse_m,
            h.nees,
            h.path_m,
            h.births,
            h.walls,
            h.least_pivot,
            h.flaw.as_deref().unwrap_or("")
        );
    });
}
