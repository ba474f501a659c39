//! Two neighbouring keyframes made one.

use heapless::VecView;
use slam_core::Calibration;

use crate::frame::{Frame, relative};
use crate::gains::Gains;
use crate::group::Group;
use crate::keyframe::Keyframe;
use crate::redundancy::lessen;
use crate::rows::Odometry;
use crate::wall::Wall;

/// So much turning makes the odometry as unsure as a metre of path, radians.
const RAD_PER_M: f32 = 0.8;

/// Makes those two neighbours one that are nearest to each other along the path, of those that a look back has placed: of the
/// others only where there are no two such. The last keyframe stays as it is: the robot is about it. So does the first: its frame is the
/// map's, and what is seen from elsewhere later on does not tell where the start was. False where there are not enough.
#[inline(never)]
pub fn thin(
    keyframes: &mut VecView<Keyframe>,
    groups: &mut VecView<Group>,
    gains: &Gains,
    (calibration, odometry): (&Calibration, &Odometry),
    walls: &[Option<Wall>],
    placed: u32,
) -> bool {
    let span = |key: &Keyframe| key.path_m + key.turning_rad / RAD_PER_M;
    let first = 1 + keyframes.iter().take_while(|key| key.holds_map()).count();
    let inner = keyframes.len().saturating_sub(1);
    let settled = keyframes.iter().take(inner).take_while(|key| key.serial <= placed).count();
    let pairs_of = if settled >= 3 { settled } else { inner };
    let pairs = keyframes.iter().zip(keyframes.iter().skip(1)).take(pairs_of.saturating_sub(1)).enumerate().skip(first);
    let shortest = pairs.min_by(|(_, a), (_, b)| (span(a.0) + span(a.1)).total_cmp(&(span(b.0) + span(b.1))));
    let Some((at, (first, second))) = shortest else { return false };
    let (first, second) = (*first, *second);
    let before: usize = keyframes.iter().take(at).map(|key| usize::from(key.groups)).sum();
    let apart = relative(&first.pose, &second.pose);
    let both = usize::from(first.groups) + usize::from(second.groups);
    let seen = groups.get_mut(before..before + both).unwrap_or_default();
    let [position_m2, heading_rad2] = odometry.variances(&first);
    if let Some((own, others)) = seen.split_at_mut_checked(first.groups.into()) {
        lessen(own, others, (&first.pose, &second.pose), walls, [position_m2, position_m2, heading_rad2]);
    }
    let gone = join(seen, first.groups.into(), gains, &Frame::of(&apart));
    groups.retain(|group| group.hits > 0);
    let groups = first.groups + second.groups - gone;
    let one = Keyframe { groups, ..first.over(&second, calibration, heading_rad2) };
    if let Some(key) = keyframes.get_mut(at) {
        *key = one;
    }
    let mut i = 0;
    keyframes.retain(|_| {
        i += 1;
        i != at + 2
    });
    true
}

/// Brings the groups past the first `own` into the frame of those, and adds those that are on one wall, so that two of it are left at most.
/// Groups that were added to others are left without hits; how many these are.
fn join(groups: &mut [Group], own: usize, gains: &Gains, apart: &Frame) -> u16 {
    let mut gone = 0;
    for i in 0..groups.len() {
        let Some((before, [group, ..])) = groups.split_at_mut_checked(i) else { break };
        if i >= own {
            *group = group.moved(apart);
        }
        if let Some(other) = fellow(before, group) {
            other.take_in(*group, gains);
            group.hits = 0;
            gone += 1;
        }
    }
    gone
}

/// Which of those before it a group is added to: the one that it is one stretch of its wall with, else the one of several stretches, else
/// the last where there are two on its wall.
fn fellow<'a>(before: &'a mut [Group], group: &Group) -> Option<&'a mut Group> {
    group.wall()?;
    let (mut several, mut last, mut others) = (None, None, 0);
    for (at, other) in before.iter().enumerate().rev() {
        if other.hits == 0 || !other.is_on_wall_of(group) {
            continue;
        }
        if other.is_one_stretch_with(group) {
            return before.get_mut(at);
        }
        if !other.is_stretch() {
            several.get_or_insert(at);
        }
        last.get_or_insert(at);
        others += 1;
    }
    before.get_mut(several.or(last.filter(|_| others > 1))?)
}
