//! Records that come from outside.

use std::vec::Vec;

use super::nor::{Nor, PAGE};
use super::{Map, same};
use crate::{ReceiveError, Receiving, Record, Refused, SaveError, Saved, Store, Writer};

const SLOT: u32 = PAGE as u32;
const RIG: u32 = 7;

/// The words of a map's record as another robot's store wrote it.
fn words_of(map: &Map) -> Vec<u32> {
    let mut bytes = Vec::new();
    Writer::new(map, 900, RIG).bytes(|piece| bytes.extend_from_slice(piece));
    bytes.chunks(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes"))).collect()
}

fn receive(store: &mut Store<&mut Nor>, words: &[u32]) -> Result<Saved, ReceiveError<super::nor::Fault>> {
    let mut receiving: Receiving = store.receive(RIG).map_err(ReceiveError::Save)?;
    let (crc, words) = words.split_last().expect("a record");
    for word in words {
        store.take(&mut receiving, *word)?;
    }
    store.seal(receiving, *crc)
}

fn newest(flash: &mut Nor) -> (u32, bool, bool) {
    let mut bytes = [0; PAGE];
    let mut store = Store::new(flash, SLOT);
    let bytes = store.read(&mut bytes).expect("it can be read").expect("a map");
    let record = Record::parse(bytes).and_then(|record| record.of_rig(RIG)).expect("a record of this rig");
    (record.sequence(), same(&record, &Map(1)), same(&record, &Map(2)))
}

#[test]
fn a_record_from_outside_is_the_newest_one_whatever_its_number_was() {
    let mut flash = Nor::new(3);
    let mut store = Store::new(&mut flash, SLOT);
    store.save(&Map(1), RIG).expect("a save");
    assert_eq!(receive(&mut store, &words_of(&Map(2))), Ok(Saved { slot: 1, sequence: 2 }));
    assert_eq!(newest(&mut flash), (2, false, true));
}

#[test]
fn what_is_no_record_of_this_robot_leaves_the_old_map() {
    let good = words_of(&Map(2));
    let spoilt = |place: usize, word: u32| {
        let mut words = good.clone();
        words[place] = word;
        words
    };
    let last = good.len() - 1;
    let cases = [
        (spoilt(0, 1), ReceiveError::Refused(Refused::Foreign)),
        (spoilt(2, 9), ReceiveError::Refused(Refused::Version(9))),
        (spoilt(3, 4), ReceiveError::Refused(Refused::Corrupt)),
        (spoilt(5, RIG + 1), ReceiveError::Refused(Refused::OtherRig)),
        (spoilt(30, 0), ReceiveError::Refused(Refused::Corrupt)),
        (spoilt(last, 0), ReceiveError::Refused(Refused::Corrupt)),
        (good[..last - 3].to_vec(), ReceiveError::Refused(Refused::Corrupt)),
    ];
    for (words, why) in cases {
        let mut flash = Nor::new(2);
        let mut store = Store::new(&mut flash, SLOT);
        store.save(&Map(1), RIG).expect("a save");
        assert_eq!(receive(&mut store, &words), Err(why));
        assert_eq!(newest(&mut flash), (1, true, false));
    }
    // 40 states of which 3 are the pose's: 22 words, 8 a wall, 37 means, their covariances, the CRC.
    let mut large = good.clone();
    (large[6], large[3]) = (40, 22 + 16 + 37 + 37 * 38 / 2 + 1);
    let mut flash = Nor::new(2);
    let too_long = Err(ReceiveError::Save(SaveError::TooLong));
    assert_eq!(receive(&mut Store::new(&mut flash, SLOT), &large), too_long);
}

#[test]
fn a_power_cut_after_each_word_leaves_the_old_map_or_the_new_one() {
    let good = words_of(&Map(2));
    let mut flash = Nor::new(2);
    Store::new(&mut flash, SLOT).save(&Map(1), RIG).expect("a save");
    for power in 0.. {
        let mut cut = Nor { power, noise: 5, ..flash.clone() };
        let is_taken = receive(&mut Store::new(&mut cut, SLOT), &good).is_ok();
        let (_, old, new) = newest(&mut Nor { power: usize::MAX, ..cut });
        assert!(if is_taken { new } else { old }, "cut {power}");
        if is_taken {
            assert_eq!(power, good.len() + 1, "the erase and each word");
            return;
        }
    }
}

#[test]
fn records_are_forgotten_the_oldest_first() {
    let mut flash = Nor::new(3);
    let mut store = Store::new(&mut flash, SLOT);
    for number in 1..=5 {
        store.save(&Map(number), RIG).expect("a save");
    }
    let newest = Some(Saved { slot: 1, sequence: 5 });
    assert_eq!((store.newest(), store.forget_oldest()), (newest, Ok(true)));
    assert_eq!((store.newest(), store.forget_oldest()), (newest, Ok(true)));
    assert_eq!((store.newest(), store.forget_oldest()), (newest, Ok(true)));
    assert_eq!((store.newest(), store.forget_oldest()), (None, Ok(false)));
}
