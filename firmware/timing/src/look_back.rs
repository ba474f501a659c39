//! A bare program that looks back over a full diary on the robot's processor, slice by slice, and prints what that cost. It is a
//! program of its own: beside the estimator's cases the memory would not do.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use instruction_count::{Bench, finish};
use look_back::{Hit, Progress, ROBOT_GROUPS, ROBOT_KEYFRAMES, RobotDiary, RobotLookBack};
use slam_core::angle::sin_cos;
use slam_core::{DriveModel, Increment, Pose};
use static_cell::{ConstStaticCell, StaticCell};

static DIARY: StaticCell<RobotDiary> = StaticCell::new();
static LOOK_BACK: ConstStaticCell<RobotLookBack> = ConstStaticCell::new(RobotLookBack::new());

const DRIVE: DriveModel = DriveModel::Odometry {
    scale_sigma: 0.02,
    noise_m2_per_m: 1e-4,
    noise_rad2_per_m: 1e-4,
    noise_rad2_per_rad: 1e-3,
    veer_sigma: 0.0,
};

/// Length of a step of the stairs, metres.
const STEP_M: f32 = 0.75;
/// Half the corridor's width, metres.
const HALF_M: f32 = 0.4;
/// Steps of the stairs: two walls each.
const STEPS: i32 = 32;
/// Metres from one pose to the next.
const MOVE_M: f32 = 0.25;

#[cortex_m_rt::entry]
fn main() -> ! {
    let bench = Bench::start();
    let diary = DIARY.init_with(|| RobotDiary::new(&DRIVE, Pose::ORIGIN));
    fill(diary);
    let look_back = LOOK_BACK.take();
    look_back.begin(diary);
    let (mut all, mut longest) = (0u32, 0u32);
    loop {
        let (progress, cost) = bench.measure(|| back_end::slice(look_back, diary));
        all = all.saturating_add(cost);
        longest = longest.max(cost);
        if progress != Progress::Working {
            assert_eq!(progress, Progress::Done);
            break;
        }
    }
    bench.print("look_back_full", all);
    bench.print("look_back_slice", longest);
    finish()
}

/// Up and down the stairs until keyframes and groups are full; the odometry and the filter are a little off.
fn fill(diary: &mut RobotDiary) {
    let (mut step, mut direction, mut at_m) = (0, 1, 0.0);
    let mut filter = Pose::ORIGIN;
    while diary.losses().thinned == 0 {
        let flat = step % 2 == 0;
        let middle = [(step / 2 + step % 2) as f32 * STEP_M, (step / 2) as f32 * STEP_M];
        let pose = Pose::new(middle[0] + if flat { at_m } else { 0.0 }, middle[1] + if flat { 0.0 } else { at_m }, 0.0);
        for wall in (2 * step - 1)..(2 * step + 3) {
            see(diary, &pose, wall);
        }
        at_m += direction as f32 * MOVE_M;
        let moved = direction as f32 * MOVE_M;
        let [forward_m, left_m] = if flat { [moved, 0.0] } else { [0.0, moved] };
        diary.travel(&Increment { forward_m, left_m: 1.01 * left_m, turn_rad: 0.002 });
        filter = filter.compose(&Pose::new(1.001 * forward_m, left_m, 0.0005));
        diary.begin_keyframe(&filter);
        if !(0.0..STEP_M).contains(&at_m) {
            step += direction;
            at_m = if direction > 0 { 0.0 } else { STEP_M - MOVE_M };
        }
        if step == STEPS || step < 0 {
            direction = -direction;
            step += direction;
        }
    }
    assert!(diary.keyframes().len() == ROBOT_KEYFRAMES && diary.group_count() > ROBOT_GROUPS * 3 / 4);
}

/// Three hits on a wall of the stairs: the two sides of each step.
fn see(diary: &mut RobotDiary, pose: &Pose, wall: i32) {
    if !(0..2 * STEPS).contains(&wall) {
        return;
    }
    let (step, side) = (wall / 2, if wall % 2 == 0 { HALF_M } else { -HALF_M });
    let flat = step % 2 == 0;
    let middle = [(step / 2 + step % 2) as f32 * STEP_M, (step / 2) as f32 * STEP_M];
    let (s, c) = sin_cos(pose.theta_rad);
    for along_m in [0.1, 0.35, 0.6] {
        let at = if flat { [middle[0] + along_m, middle[1] + side] } else { [middle[0] + side, middle[1] + along_m] };
        let [x, y] = [at[0] - pose.x_m, at[1] - pose.y_m];
        let end_m = [c * x + s * y, c * y - s * x];
        let wall = u16::try_from(wall).ok();
        diary.hit(&Hit { from_m: [0.0; 2], end_m, variance_m2: 4e-4, alike: 1.0, sensor: 0, wall });
    }
}
