use super::nor::{Fault, Nor, PAGE};
use super::{Map, same};
use crate::{Record, SaveError, Saved, Store};

const SLOT: u32 = PAGE as u32;
const RIG: u32 = 7;

/// Which of two maps a flash holds; an error for none or another one.
fn holds(flash: &Nor, old: &Map, new: &Map) -> Result<bool, &'static str> {
    let mut bytes = [0; PAGE];
    let mut store = Store::new(flash.clone(), SLOT);
    let bytes = store.read(&mut bytes).expect("it can be read").ok_or("no map")?;
    let record = Record::parse(bytes).and_then(|record| record.of_rig(RIG)).map_err(|_| "no record")?;
    match (same(&record, old), same(&record, new)) {
        (_, true) => Ok(true),
        (true, false) => Ok(false),
        (false, false) => Err("another map"),
    }
}

/// A power cut after each written word and in each erase of a thousand saves leaves the old map or the new one.
#[test]
fn a_power_cut_leaves_the_old_map_or_the_new_one() {
    let mut flash = Nor::new(3);
    Store::new(&mut flash, SLOT).save(&Map(0), RIG).expect("the first save");
    let (mut cuts, mut kept) = (0, 0);
    for save in 1..=1000 {
        let (old, new) = (Map(save - 1), Map(save));
        for power in 0.. {
            let mut cut = Nor { power, noise: u32::from(save) << 8 | 1, ..flash.clone() };
            let saved = Store::new(&mut cut, SLOT).save(&new, RIG);
            let is_new = holds(&cut, &old, &new).unwrap_or_else(|what| panic!("save {save}, cut {power}: {what}"));
            if saved.is_ok() {
                assert!(is_new);
                break;
            }
            assert_eq!(saved, Err(SaveError::Flash(Fault::PowerCut)));
            cuts += 1;
            kept += usize::from(!is_new);
            // And the next save works.
            if power % 16 == usize::from(save) % 16 {
                let mut again = Nor { power: usize::MAX, ..cut };
                Store::new(&mut again, SLOT).save(&new, RIG).expect("the save after the cut");
                assert_eq!(holds(&again, &old, &new), Ok(true));
            }
        }
        let mut after = Nor { power: usize::MAX, ..flash };
        Store::new(&mut after, SLOT).save(&new, RIG).expect("a save");
        flash = after;
    }
    assert_eq!((cuts, kept), (67_000, 67_000), "66 words and an erased slot a save; what is not whole is the old map");
    let most = flash.erased.iter().max().zip(flash.erased.iter().min()).expect("pages");
    assert!(most.0 - most.1 <= 1, "all slots wear alike: {:?}", flash.erased);
}

#[test]
fn a_save_in_slices_is_the_save_in_one_go() {
    let [mut whole, mut sliced] = [Nor::new(2), Nor::new(2)];
    let saved = Store::new(&mut whole, SLOT).save(&Map(5), RIG).expect("a save");
    let mut store = Store::new(&mut sliced, SLOT);
    let mut saving = store.begin(RIG).expect("a beginning");
    let mut slices = 1;
    while !store.go_on(&mut saving, &Map(5), 7).expect("a slice") {
        slices += 1;
        assert_eq!(store.newest(), None, "a record exists whole or not at all");
    }
    assert_eq!(store.newest(), Some(saved));
    assert!(slices > 5);
    assert_eq!(whole.bytes, sliced.bytes);
}

#[test]
fn numbers_that_run_over_are_newer() {
    let mut flash = Nor::new(2);
    let first = [0xFFFF_FFFF_u32, 0xFFFF_FFFE].map(|sequence| {
        let mut bytes = std::vec::Vec::new();
        crate::Writer::new(&Map(1), sequence, RIG).bytes(|piece| bytes.extend_from_slice(piece));
        bytes
    });
    for (slot, bytes) in first.iter().enumerate() {
        flash.bytes[slot * PAGE..slot * PAGE + bytes.len()].copy_from_slice(bytes);
    }
    let mut store = Store::new(flash, SLOT);
    assert_eq!(store.newest(), Some(Saved { slot: 0, sequence: 0xFFFF_FFFF }));
    assert_eq!(store.save(&Map(2), RIG), Ok(Saved { slot: 1, sequence: 0 }));
    assert_eq!(store.newest(), Some(Saved { slot: 1, sequence: 0 }));
}

#[test]
fn a_map_that_is_too_long_is_refused_and_a_forgotten_one_gone() {
    let mut store = Store::new(Nor::new(2), SLOT);
    store.save(&Map(1), RIG).expect("a save");
    store.forget().expect("it can be erased");
    assert_eq!(store.newest(), None);
    let mut small = Store::new(Nor::new(1), 128);
    assert_eq!(small.save(&Map(1), RIG), Err(SaveError::Flash(Fault::Misuse)), "a slot of whole pages only");
}

/// A slot that does not hold what is written is said to, and the next save goes to another one.
#[test]
fn a_slot_that_wears_out_costs_one_save() {
    for dead in [0, PAGE, 2 * PAGE + 1] {
        let mut store = Store::new(Nor { dead: Some(dead), ..Nor::new(3) }, SLOT);
        let mut kept = None;
        let mut failed = 0;
        for save in 1..=30 {
            let map = Map(save);
            match store.save(&map, RIG) {
                Ok(_) => kept = Some(map),
                Err(error) => {
                    assert_eq!(error, SaveError::Damaged);
                    failed += 1;
                }
            }
            let flash = store.flash().clone();
            if let Some(kept) = kept {
                assert_eq!(holds(&flash, &kept, &kept), Ok(true), "byte {dead}, save {save}");
            }
        }
        assert!((1..=15).contains(&failed) && kept.is_some(), "byte {dead}: {failed} saves of 30 failed");
        assert!(failed == 0 || store.save(&Map(31), RIG).or_else(|_| store.save(&Map(31), RIG)).is_ok());
    }
}
