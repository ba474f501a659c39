//! Where the robot was of late: floor that is not sure to be swept where its pose turns out to have been wrong.

use super::sheet::Sheet;

/// Points of the trail, and how far apart they are, metres: the last five metres.
const POINTS: usize = 25;
pub(super) const APART_M: f32 = 0.2;
/// What a metre is in the unit of the points.
const CM: f32 = 100.0;

/// The last metres of the path, in centimetres of the job's frame.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    points: heapless::Deque<[i16; 2], POINTS>,
    since_m: f32,
}

impl Trail {
    pub(super) const fn new() -> Self {
        Self { points: heapless::Deque::new(), since_m: f32::INFINITY }
    }

    /// The robot moved by so much (metres) and is here.
    pub(super) fn step(&mut self, at_m: [f32; 2], moved_m: f32) {
        self.since_m += moved_m;
        if self.since_m < APART_M {
            return;
        }
        self.since_m = 0.0;
        if self.points.is_full() {
            let _ = self.points.pop_front();
        }
        let _ = self.points.push_back(at_m.map(|value_m| (value_m * CM) as i16));
    }

    /// The last point, metres.
    pub(super) fn last_m(&self) -> Option<[f32; 2]> {
        self.points.back().map(|point| point.map(|value| f32::from(value) / CM))
    }

    /// Forgets the last point.
    pub(super) fn drop_last(&mut self) {
        let _ = self.points.pop_back();
    }

    /// What was swept there counts no more; how many quarters.
    pub(super) fn undo(&mut self, sheet: &mut Sheet) -> u16 {
        let mut count = 0_u16;
        while let Some(point) = self.points.pop_back() {
            count = count.saturating_add(sheet.unsweep(point.map(|value| f32::from(value) / CM)));
        }
        self.since_m = f32::INFINITY;
        count
    }
}
