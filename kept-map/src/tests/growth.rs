use super::Map;
use crate::{WORTH_M, is_outgrown};
use slam_core::kept::{Kept, KeptFrame};

#[test]
fn a_map_is_worth_a_stop_where_it_has_twice_as_many_walls() {
    let of = |walls: u16| KeptFrame { walls, ..Map(4).frame() };
    let is_worth = |kept: Option<u16>, walls: u16| is_outgrown(kept.map(of), &of(walls), WORTH_M);
    assert_eq!([3, 4].map(|walls| is_worth(None, walls)), [false, true], "a room");
    assert_eq!([3, 4].map(|walls| is_worth(Some(1), walls)), [false, true]);
    assert_eq!([37, 38].map(|walls| is_worth(Some(19), walls)), [false, true]);
    assert!(!is_outgrown(None, &of(9), 0.9 * WORTH_M), "it was found or saved just now");
    assert!(!is_outgrown(None, &KeptFrame { has_grid: false, ..of(9) }, WORTH_M), "nobody finds it again");
}
