//! Areas in a record: read back, taken along by every save, and refused where they are damaged.

use std::vec::Vec;

use super::nor::{Nor, PAGE};
use super::{Map, same};
use crate::{Areas, BadArea, Corner, Record, Refused, Store, Writer};

const SQUARE: [[f32; 2]; 4] = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
const RIG: u32 = 7;

fn two() -> Areas {
    let mut areas = Areas::NONE;
    areas.add(0, &SQUARE).expect("there is room");
    areas.add(1, &SQUARE[..3]).expect("there is room");
    areas
}

fn bytes_of(map: &Map, areas: &Areas) -> Vec<u8> {
    let mut bytes = Vec::new();
    Writer::new(map, 3, RIG).with_areas(areas).bytes(|piece| bytes.extend_from_slice(piece));
    bytes
}

#[test]
fn a_record_with_areas_reads_back_and_one_without_is_as_before() {
    let bytes = bytes_of(&Map(4), &two());
    let record = Record::parse(&bytes).expect("a record");
    assert!(same(&record, &Map(4)) && record.areas() == two());
    let corners: Vec<Corner> = record.corners().collect();
    assert_eq!(corners, two().corners().collect::<Vec<_>>());
    let heads: Vec<(u8, bool)> = corners.iter().map(|corner| (corner.kind, corner.is_first)).collect();
    let rest = |kind, count| (1..count).map(move |_| (kind, false));
    let expected: Vec<_> = [(0, true)].into_iter().chain(rest(0, 4)).chain([(1, true)]).chain(rest(1, 3)).collect();
    assert_eq!(heads, expected);
    assert_eq!(corners[1].at_m, SQUARE[1]);
    assert_eq!(bytes[8], 2);
    let without = bytes_of(&Map(4), &Areas::NONE);
    assert_eq!((without[8], without.len() + 4 * (2 + 14)), (1, bytes.len()));
    assert_eq!(Record::parse(&without).expect("a record").corners().count(), 0);
}

#[test]
fn every_save_takes_the_areas_along_and_another_rig_does_not() {
    let bytes = bytes_of(&Map(1), &two());
    let mut flash = Nor::new(3);
    let mut store = Store::new(&mut flash, PAGE as u32);
    let mut receiving = store.receive(RIG).expect("an erased slot");
    let words: Vec<u32> =
        bytes.chunks(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes"))).collect();
    let (crc, words) = words.split_last().expect("a record");
    words.iter().for_each(|word| store.take(&mut receiving, *word).expect("a word of a record"));
    store.seal(receiving, *crc).expect("a whole record");
    for save in 2..6 {
        store.save(&Map(save), RIG).expect("a save");
        let mut bytes = [0; PAGE];
        let record = Record::parse(store.read(&mut bytes).expect("it can be read").expect("a map")).expect("a record");
        assert!(same(&record, &Map(save)) && record.areas() == two(), "{save}");
    }
    store.save(&Map(1), RIG + 1).expect("a save");
    let mut bytes = [0; PAGE];
    let record = Record::parse(store.read(&mut bytes).expect("it can be read").expect("a map")).expect("a record");
    assert_eq!(record.areas(), Areas::NONE);
}

#[test]
fn what_is_too_much_or_damaged_is_refused() {
    let mut areas = Areas::NONE;
    assert_eq!(areas.add(0, &SQUARE[..2]), Err(BadArea));
    assert_eq!(areas.add(0, &[[0.0; 2]; 60]), Err(BadArea));
    assert_eq!(areas, Areas::NONE);
    (0..8).for_each(|_| areas.add(0, &SQUARE[..3]).expect("there is room"));
    assert_eq!(areas.add(0, &SQUARE[..3]), Err(BadArea), "a robot remembers eight");
    assert_eq!(areas.corners().count(), 24);
    let good = bytes_of(&Map(4), &two());
    for place in 12..good.len() {
        let mut bytes = good.clone();
        bytes[place] ^= 0x10;
        assert_eq!(Record::parse(&bytes).expect_err("no record"), Refused::Corrupt, "{place}");
    }
    let mut longer = good.clone();
    longer[12..16].copy_from_slice(&(good.len() as u32 / 4 + 200).to_le_bytes());
    assert_eq!(Record::parse(&longer).expect_err("no record"), Refused::Corrupt);
}

#[test]
fn corners_of_more_areas_than_a_robot_remembers_are_not_told() {
    let triangle = || [0x0300].into_iter().chain(SQUARE[..3].iter().flatten().map(|m| m.to_bits()));
    let words: Vec<u32> = (0..9).flat_map(|_| triangle()).collect();
    assert_eq!(crate::areas::corners(|place| words.get(place).copied()).count(), 24);
}
