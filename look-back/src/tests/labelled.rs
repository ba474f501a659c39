use slam_core::Pose;

use super::drive::DRIVE;
use crate::diary::Diary;
use crate::group::Group;
use crate::labels::Labels;
use crate::wall::Wall;

/// The wall that the look back gives a hit to, which was on this one before. The hit lies so far along the wall x = 1, whose extent is -1 to
/// 1 m.
fn label(along_m: f32, before: Option<usize>) -> Option<usize> {
    label_group(Group::of([0.0, along_m], [1.0, along_m], 1e4, 1.0, 0), before)
}

/// The same of a group.
fn label_group(mut group: Group, before: Option<usize>) -> Option<usize> {
    let mut diary = Diary::<4, 4, 4>::new(&DRIVE, Pose::ORIGIN);
    diary.walls[0] = Some(Wall { rho_m: 1.0, lo_m: -1.0, hi_m: 1.0, hits: 20, is_placed: true, ..Wall::NEW });
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

/// Twenty hits of this 1-sigma, so far before the wall, metres.
fn before_the_wall(sigma_m: f32, before_m: f32) -> Group {
    let hit = |_| Group::of([0.0, 0.0], [1.0 - before_m, 0.0], 1.0 / (sigma_m * sigma_m), 1.0, 0);
    let mut hits = (0..20).map(hit);
    let first = hits.next().unwrap();
    hits.fold(first, |mut all, hit| {
        all.add(&hit);
        all
    })
}

/// A chair before a wall is not the wall, however wide the hits on it are.
#[test]
fn hits_on_none_come_onto_a_wall_where_all_of_them_together_lie_on_it() {
    for (sigma_m, before_m, of_the_walls, of_none) in [
        (0.08, 0.0, Some(0), Some(0)),
        (0.08, 0.06, Some(0), Some(0)),
        (0.08, 0.12, Some(0), None),
        (0.08, 0.2, Some(0), None),
        (0.02, 0.04, Some(0), Some(0)),
        (0.02, 0.055, Some(0), None),
        (1.0, 0.0, Some(0), None),
    ] {
        let group = before_the_wall(sigma_m, before_m);
        let found = (label_group(group, Some(0)), label_group(group, None));
        assert_eq!(found, (of_the_walls, of_none), "{before_m} m before it, hits of {sigma_m} m");
    }
}
