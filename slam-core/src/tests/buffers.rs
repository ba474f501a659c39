//! The ring buffer of outliers.

use std::vec::Vec;

use super::outliers::OUTLIER;
use crate::births::buffer::{Outlier, OutlierBuffer};

/// A point that is told apart by its x.
fn outlier(sensor: u8, x: f32) -> Outlier {
    Outlier { sensor, hit_m: [x, 0.0], ..OUTLIER }
}

fn filled<const B: usize>(points: usize) -> OutlierBuffer<B> {
    let mut buffer = OutlierBuffer::default();
    for i in 0..points {
        assert_eq!(buffer.push(outlier((i % 3) as u8, i as f32)), i >= B, "point {i}");
    }
    buffer
}

fn order<const B: usize>(buffer: &OutlierBuffer<B>) -> Vec<usize> {
    let by_iter: Vec<usize> = buffer.iter().map(|p| p.hit_m[0] as usize).collect();
    let by_position: Vec<usize> =
        (0..buffer.len()).filter_map(|i| buffer.get(i)).map(|p| p.hit_m[0] as usize).collect();
    assert_eq!(by_iter, by_position);
    assert_eq!(by_iter.len(), buffer.len());
    by_iter
}

#[test]
fn the_oldest_go_and_the_order_stays() {
    for points in 0..30 {
        let buffer = filled::<8>(points);
        let expected: Vec<usize> = (points.saturating_sub(8)..points).collect();
        assert_eq!(order(&buffer), expected);
        assert!(buffer.get(buffer.len()).is_none());
    }
}

#[test]
fn retaining_keeps_the_order_and_tells_the_position() {
    for points in [0, 1, 5, 8, 11, 19] {
        let mut buffer = filled::<8>(points);
        let before = order(&buffer);
        let mut position = 0;
        buffer.retain(|i, point| {
            assert_eq!(i, position);
            assert_eq!(point.hit_m[0] as usize, before[i]);
            position += 1;
            point.sensor != 1
        });
        assert_eq!(position, before.len());
        let expected: Vec<usize> = before.into_iter().filter(|p| p % 3 != 1).collect();
        assert_eq!(order(&buffer), expected);
        // And there is room again for what went.
        let room = 8 - expected.len();
        for i in 0..room {
            assert!(!buffer.push(outlier(0, (100 + i) as f32)));
        }
        assert!(buffer.push(outlier(0, 200.0)));
    }
}

#[test]
fn the_newest_of_a_sensor_is_its_last() {
    let buffer = filled::<8>(19);
    for sensor in 0..3u8 {
        let (position, point) = buffer.newest_of(sensor).unwrap();
        assert_eq!(point.sensor, sensor);
        assert_eq!(buffer.get(position).unwrap().hit_m, point.hit_m);
        assert!(buffer.iter().skip(position + 1).all(|p| p.sensor != sensor));
    }
    assert!(buffer.newest_of(9).is_none());
    assert!(filled::<8>(0).newest_of(0).is_none());
}

#[test]
fn a_buffer_of_one_holds_the_newest() {
    let mut buffer = OutlierBuffer::<1>::default();
    assert!(!buffer.push(outlier(0, 1.0)));
    assert!(buffer.push(outlier(0, 2.0)));
    assert_eq!(order(&buffer), [2]);
}
