use std::vec::Vec;

use super::{Map, same};
use crate::{Record, Refused, VERSION, Writer, rig_hash};
use slam_core::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig};

fn bytes_of(map: &Map) -> Vec<u8> {
    let mut bytes = Vec::new();
    Writer::new(map, 3, 7).bytes(|piece| bytes.extend_from_slice(piece));
    bytes
}

#[test]
fn a_record_reads_back_to_the_last_bit() {
    for map in [Map(4), Map(5)] {
        let bytes = bytes_of(&map);
        let record = Record::parse(&bytes).expect("a record");
        assert!(same(&record, &map));
        assert_eq!((record.sequence(), record.of_rig(7).is_ok()), (3, true));
        // 22 words, 8 a wall, 6 means, 21 covariances, the CRC.
        assert_eq!(bytes.len(), 4 * (22 + 16 + 6 + 21 + 1));
    }
}

#[test]
fn its_check_sum_tells_a_record_from_every_other_one_wherever_it_lies() {
    let [first, second] = [Map(4), Map(5)].map(|map| bytes_of(&map));
    let ends = |bytes: &[u8]| u32::from_le_bytes(*bytes.last_chunk().expect("a check sum"));
    let in_a_slot = [first.clone(), std::vec![0xFF; 100]].concat();
    assert_eq!(Record::check_sum(&in_a_slot), Some(ends(&first)));
    assert_ne!(Record::check_sum(&first), Record::check_sum(&second));
    assert_eq!(Record::check_sum(&first[..first.len() - 1]), None);
}

#[test]
fn what_is_no_record_is_refused_with_the_reason() {
    let good = bytes_of(&Map(4));
    let refused = |bytes: &[u8]| Record::parse(bytes).expect_err("no record");
    assert_eq!(refused(b""), Refused::Foreign);
    assert_eq!(refused(b"kind,rho_m,beta_rad\n"), Refused::Foreign);
    for cut in 8..good.len() {
        assert_eq!(refused(&good[..cut]), Refused::Corrupt, "{cut}");
    }
    for place in 12..good.len() {
        let mut bytes = good.clone();
        bytes[place] ^= 0x10;
        assert_eq!(refused(&bytes), Refused::Corrupt, "{place}");
    }
    let mut older = good.clone();
    older[8] = 0;
    assert_eq!(refused(&older), Refused::Version(0));
    assert!(std::format!("{}", refused(&older)).contains(&std::format!("reads versions 1 to {VERSION}")));
    assert_eq!(Record::parse(&good).and_then(|record| record.of_rig(8)).err(), Some(Refused::OtherRig));
}

#[test]
fn every_number_of_a_rig_is_in_its_hash() {
    let rig = |value: f32, which: usize| {
        let v = |i: usize, nominal: f32| if i == which { value } else { nominal };
        let drive = DriveModel::Wheels {
            track_m: v(0, 0.2),
            track_sigma: v(1, 0.01),
            metres_per_tick: v(2, 0.001),
            scale_sigma: v(3, 0.005),
            noise_m2_per_m: v(4, 1e-5),
        };
        let sensor = |metric: bool, from: usize| RangeSensor {
            mount: Mount { x_m: v(from, 0.1), y_m: v(from + 1, 0.0), bearing_rad: v(from + 2, 0.0) },
            min_m: v(from + 3, 0.1),
            max_m: v(from + 4, 2.0),
            max_incidence_rad: v(from + 5, 1.0),
            gain_sigma: v(from + 6, 0.02),
            model: if metric {
                RangeModel::Metric { noise_m: v(from + 7, 0.01), noise_rel: v(from + 8, 0.01) }
            } else {
                RangeModel::Sharp { scale_m: v(from + 7, 0.6), exponent: v(from + 8, -1.1), noise_v: v(from + 9, 0.01) }
            },
        };
        let adc = Some(Adc { bits: v(5, 12.0) as u8, vref_v: v(6, 3.3) });
        rig_hash(&Rig::<4> { drive, adc, sensors: [sensor(false, 10), sensor(true, 20)].into_iter().collect() })
    };
    let nominal = rig(0.0, usize::MAX);
    for which in (0..7).chain(10..20).chain(20..29) {
        assert_ne!(rig(0.3, which), nominal, "{which}");
    }
}
