//! The estimator: ranges and counts in; senses for the pilot and frames for the telemetry out; then the back end's turn.

use crate::SENSORS;
use crate::faults::Task;
use crate::keeper::{Circumstances, Keeper, MapFlash};
use crate::look_backs::LookBacks;
use crate::shared::{Ranges, Shared, Told};
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_futures::yield_now;
use embassy_time::Instant;
use look_back::RobotBackEnd;
use robot::{Condition, LastingMemory, Senses, Whereabouts};
use slam_core::{Config, RobotSlam, StepReport, WallView};
use wire::{Calibration, Estimate, Faults, Frame, Frozen, LookBack, MapRequest, Sample, Wall};

/// Steps between two frames of calibration and faults: once a second.
const SLOW_FRAMES: u32 = 25;

/// Estimates whenever ranges come; starts afresh with this configuration when the map is to be reset. Where the configuration
/// has hand-overs, there is a back end among the look backs, which has its turn between two steps. Where the robot is, is to be known after
/// a reset, and goes into the memory.
pub async fn estimate<F: MapFlash>(
    slam: &mut RobotSlam,
    keeper: &mut Keeper<F>,
    config: Config,
    shared: &Shared,
    look_backs: &LookBacks,
    memory: &mut impl LastingMemory,
) -> ! {
    keeper.recall(memory);
    let mut steps = 0_u32;
    let mut wanted = None;
    let mut found = None;
    loop {
        let ranges = shared.ranges.receive().await;
        let late_us = Instant::now().as_micros().saturating_sub(ranges.time_us);
        if shared.reset_map.try_take().is_some() {
            // The rig was accepted before: it is again.
            let _ = slam.start_with_config(slam.rig().clone(), config);
            keeper.began_anew();
        }
        let sample = raw_sample(&ranges, shared);
        let report = estimator::step(slam, &sample.to_slam());
        let wall = next_wall(slam);
        let whereabouts = whereabouts(slam, keeper);
        shared.told.signal(Told { senses: senses(slam, &sample, &report, shared), whereabouts });
        steps = steps.wrapping_add(1);
        let now = circumstances(&sample, shared);
        tell(slam, sample, wall, late_us, shared);
        let is_slow = steps.is_multiple_of(SLOW_FRAMES);
        if is_slow {
            tell_slow(slam, shared);
            shared.push_frame(Frame::Place(keeper.place()));
        }
        shared.reports.report(Task::Estimate);
        // Telemetry has its frames and goes first; twice, since the executor runs what was woken last before it.
        yield_now().await;
        yield_now().await;
        let mut hands_over = false;
        if config.hand_overs {
            let back_end = match found.take() {
                Some(back_end) => back_end,
                None => look_backs.returned().await,
            };
            estimator::record(back_end, slam, &report);
            hands_over = back_end.is_catching_up();
            if is_slow {
                shared.push_frame(Frame::LookBack(look_back(slam, back_end, look_backs)));
            }
            look_backs.lend(back_end);
        }
        // A hand-over and a slice of a search are too much for one step. A map about to be forgotten does not wait.
        if !hands_over || slam.is_about_to_forget() {
            let keeps = keeper.step(slam, &report, now);
            keeper.note(slam, memory);
            wanted = shared.map_request.try_take().or(wanted);
            wanted = wanted.filter(|request| !answer(slam, keeper, request, now, shared));
            shared.hold.store(keeps || wanted.is_some(), Ordering::Relaxed);
        }
        if hands_over {
            let back_end = look_backs.found().await;
            back_end::hand_over(back_end, slam);
            found = Some(back_end);
        }
    }
}

/// Does what somebody wants with the kept map; whether it is done, or refused.
fn answer<F: MapFlash>(
    slam: &mut RobotSlam,
    keeper: &mut Keeper<F>,
    request: &MapRequest,
    now: Circumstances,
    shared: &Shared,
) -> bool {
    let answer = keeper.ask(slam, request, now);
    let is_done = answer.is_some();
    if let Some(answer) = answer {
        shared.push_frame(Frame::MapAnswer(answer));
    }
    is_done
}

/// What the keeper has to know of this moment.
fn circumstances(sample: &Sample, shared: &Shared) -> Circumstances {
    let is = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
    let wire::Contacts { lifted: is_lifted, docked: is_docked, .. } = sample.contacts;
    Circumstances { is_lifted, is_docked, stands: is(&shared.stands), is_off: is(&shared.is_held) }
}

fn senses(slam: &RobotSlam, sample: &Sample, report: &StepReport<SENSORS>, shared: &Shared) -> Senses<SENSORS> {
    Senses {
        time_us: sample.time_us,
        pose: slam.pose(),
        ranges_m: report.readings.map(|reading| reading.range_m),
        contacts: shared.contacts(),
        condition: Condition::default(),
    }
}

/// A wall of the map: one after the other from step to step, with its place in the map and how many there are.
fn next_wall(slam: &RobotSlam) -> Option<(WallView, [u8; 2])> {
    let count = slam.walls().count();
    let index = (slam.counters().steps as usize).checked_rem(count)?;
    Some((slam.walls().nth(index)?, [index as u8, count as u8]))
}

/// What is known of the map that the pose is in.
fn whereabouts<F: MapFlash>(slam: &RobotSlam, keeper: &mut Keeper<F>) -> Whereabouts {
    Whereabouts {
        kept: keeper.kept(),
        world: keeper.world(),
        redrawn: slam.counters().second_copies,
        fresh: keeper.fresh(),
        is_located: keeper.is_located(),
        grid_rad: slam.alpha().map(|(alpha_rad, _)| alpha_rad),
        start: slam.start_pose(),
        reckoned: slam.dead_reckoning(),
        corner: keeper.corner(slam.counters().steps),
    }
}

/// Hands the sample and what came of it to the telemetry.
fn tell(slam: &RobotSlam, sample: Sample, wall: Option<(WallView, [u8; 2])>, late_us: u64, shared: &Shared) {
    let time_us = sample.time_us;
    shared.push_frame(Frame::Sample(sample));
    let late_us = u32::try_from(late_us).unwrap_or(u32::MAX);
    shared.push_frame(Frame::Estimate(Estimate { late_us, ..Estimate::of(slam, time_us) }));
    if let Some((wall, [index, of])) = wall {
        shared.push_frame(Frame::Wall(Wall::of(&wall, index, of)));
    }
}

/// Hands calibration and faults to the telemetry.
fn tell_slow(slam: &RobotSlam, shared: &Shared) {
    shared.push_frame(Frame::Calibration(Calibration::of(slam)));
    if let Some(frozen) = Frozen::of(slam) {
        shared.push_frame(Frame::Frozen(frozen));
    }
    let slam = slam.counters().into();
    shared.push_frame(Frame::Faults(Faults { slam, board: shared.faults.get() }));
}

/// What the back end did so far.
fn look_back(slam: &RobotSlam, back_end: &RobotBackEnd, look_backs: &LookBacks) -> LookBack {
    let (tally, counters) = (back_end.tally(), slam.counters());
    LookBack {
        keyframes: back_end.diary().keyframes().len() as u16,
        groups: back_end.diary().group_count() as u16,
        is_working: back_end.is_looking_back(),
        done: tally.done,
        fruitless: tally.fruitless,
        outdated: tally.outdated,
        taken_over: counters.taken_over,
        not_taken: counters.not_taken,
        late: look_backs.late(),
    }
}

/// Ranges and encoder counts as they were, without any reduction.
fn raw_sample(ranges: &Ranges, shared: &Shared) -> Sample {
    let ticks = shared.latest_odometry.lock(Cell::get).ticks;
    let robot::Contacts { bump_left, bump_right, cliff, lifted } = shared.contacts();
    let docked = shared.docked.load(Ordering::Relaxed);
    Sample {
        time_us: ranges.time_us,
        left_ticks: ticks.left,
        right_ticks: ticks.right,
        ranges: ranges.ranges.iter().map(|range| (*range).into()).collect(),
        contacts: wire::Contacts { bump_left, bump_right, cliff, lifted, docked },
    }
}
