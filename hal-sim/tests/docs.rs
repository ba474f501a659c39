//! What the documents say is so.
use hal_sim::{SimOptions, plan_file};

#[test]
fn the_example_in_the_plan_format_is_a_plan() {
    let text = include_str!("../../docs/reference/plans.md");
    let example = text.split("```toml").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let plan = plan_file::parse("docs/reference/plans.md", "example", example).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(plan.name, "my flat");
    let counts = [plan.faces.len(), plan.rounds.len(), plan.rooms.len(), plan.doors.len(), plan.people.len()];
    assert_eq!(counts, [9, 1, 1, 1, 1]);
    assert_eq!(plan.cliffs.len(), 1);
    let mishaps = &plan.mishaps;
    let counts = [mishaps.kidnaps.len(), mishaps.kicks.len(), mishaps.rugs.len(), mishaps.holds.len()];
    assert_eq!(counts, [1; 4]);
    let bare = example.lines().filter(|line| !line.contains("optional")).collect::<Vec<_>>().join("\n");
    let defaults = plan_file::parse("bare", "bare", &bare).unwrap_or_else(|e| panic!("{e}")).mishaps;
    assert_eq!((&defaults.kicks, &defaults.rugs), (&mishaps.kicks, &mishaps.rugs), "the example shows the defaults");
    assert!(defaults.kidnaps[0].to.is_none() && defaults.kidnaps[0].carried_s == mishaps.kidnaps[0].carried_s);
    for (name, _) in plan_file::BUILT_IN {
        assert!(text.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn the_defaults_in_the_simulator_s_tables_are_the_defaults() {
    let text = include_str!("../../docs/explanation/simulator.md");
    let SimOptions { rate_hz, body_radius_m, drive, sharp, .. } = SimOptions::default();
    let expected = [
        format!("`rate_hz` ({rate_hz})"),
        format!("radius {body_radius_m} m"),
        format!("{:.0} ms, {} m/s, {:.0} %", drive.lag_s * 1e3, drive.full_speed_mps, drive.dead_duty * 100.0),
        format!(
            "{:.1} ms ± {:.1} ms, jitter {:.0} ms",
            sharp.period_s * 1e3,
            sharp.period_spread_s * 1e3,
            sharp.jitter_s * 1e3
        ),
        format!("up to {} V too high", sharp.spike_v),
        format!("1 in {:.0}", 1.0 / sharp.spike_probability),
    ];
    for expected in expected {
        assert!(text.contains(&expected), "docs/explanation/simulator.md should say: {expected}");
    }
}
