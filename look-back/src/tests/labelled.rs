use slam_core::Pose;

use super::drive::DRIVE;
use crate::diary::Diary;
use crate::group::Group;
use crate::labels::Labels;
use crate::wall::Wall;

/// The wall that the look back gives a hit to, which was on this one before. The hit lies so far along the wall x = 1, whose extent is -1 to
/// 1 m.
fn label(along_m: f32, before: Option<usize>) -> Option<usize> {
    let mut diary = Diary::<4, 4, 4>::new(&DRIVE, Pose::ORIGIN);
    diary.walls[0] = Some(Wall { rho_m: 1.0, lo_m: -1.0, hi_m: 1.0, hits: 20, is_placed: true, ..Wall::NEW });
    let mut group = Group::of([0.0, along_m], [1.0, along_m], 1e4, 1.0, 0);
    group.set_wall(before);
    assert!(diary.groups.push(group).is_ok());
    diary.keyframes[0].groups = 1;
    let mut labels = Labels::NEW;
    assert!(labels.take(&mut diary).is_some() && labels.take(&mut diary).is_none(), "one group");
    labels.finish(&mut diary);
    diary.groups[0].wall()
}

/// A wall that was mapped later is given what was seen of it before, but not what may be the other face of its corner.
#[test]
fn near_a_walls_end_a_hit_stays_what_the_filter_took_it_for() {
    for (along_m, of_the_walls, of_none) in [
        (0.0, Some(0), Some(0)),
        (0.8, Some(0), Some(0)),
        (0.95, Some(0), None),
        (-1.05, Some(0), None),
        (1.2, None, None),
    ] {
        assert_eq!((label(along_m, Some(0)), label(along_m, None)), (of_the_walls, of_none), "{along_m} m along it");
    }
}
