//! What a reader sees of the floor job: what it is doing, how much is swept, and where time went.

use super::sheet::{QUARTER_M, Sheet};
use super::swept::CELLS;
use crate::pilot::memory::Cell;
use crate::pilot::search::is_passable;

/// What the floor job is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum FloorState {
    /// Along whatever stands on the floor.
    #[default]
    Edge,
    /// Along a lane.
    Lane,
    /// To the next floor that was not swept.
    Transit,
    /// Looking for the next floor, standing.
    Planning,
    /// Backing off from something touched.
    BackingOff,
    /// Once more to where the way was blocked.
    Retry,
    /// Back to where it started.
    Return,
    /// Backwards out of the dock.
    Undocking,
    /// To the place in front of the dock.
    Staging,
    /// In front of the dock, turning towards it and waiting until it knows where it is.
    Aligning,
    /// Slowly straight to the dock.
    Approaching,
    /// On against the dock until the charging contact closes.
    Pressing,
    /// In the dock, with floor left to sweep.
    Charging,
    /// Stopped on request.
    Paused,
    /// Off the floor, or carried and not located yet.
    Lost,
    /// Held: its wheels turn or stall and it does not move.
    Held,
    /// Its battery is nearly empty: back where it started, with floor left to sweep and no dock; or empty, and it stands on the way.
    Flat,
    /// Done, and back.
    Done,
    /// Done, and not back: the way is blocked, or the dock gave no contact.
    Away,
    /// Done and back, but for an area to clean that it did not come to.
    Unreached,
    /// Back, and waiting for what barred the way to floor that is left.
    Waiting,
    /// Standing: its bumper or its cliff sensor tells of something wherever it backs off to.
    Touched,
    /// Standing: none of its range sensors shows anything wherever it goes.
    Blind,
}

impl FloorState {
    /// Every one, in the order of [`FloorProgress::seconds_in`].
    pub const ALL: [Self; 23] = [
        Self::Edge,
        Self::Lane,
        Self::Transit,
        Self::Planning,
        Self::BackingOff,
        Self::Retry,
        Self::Return,
        Self::Undocking,
        Self::Staging,
        Self::Aligning,
        Self::Approaching,
        Self::Pressing,
        Self::Charging,
        Self::Paused,
        Self::Lost,
        Self::Held,
        Self::Flat,
        Self::Done,
        Self::Away,
        Self::Unreached,
        Self::Waiting,
        Self::Touched,
        Self::Blind,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Edge => "edges",
            Self::Lane => "lanes",
            Self::Transit => "transit",
            Self::Planning => "planning",
            Self::BackingOff => "backing off",
            Self::Retry => "retries",
            Self::Return => "return",
            Self::Undocking => "undocking",
            Self::Staging => "staging",
            Self::Aligning => "aligning",
            Self::Approaching => "approaching",
            Self::Pressing => "pressing",
            Self::Charging => "charging",
            Self::Paused => "paused",
            Self::Lost => "lost",
            Self::Held => "held",
            Self::Flat => "flat",
            Self::Done => "done",
            Self::Away => "away",
            Self::Unreached => "area not reached",
            Self::Waiting => "waiting",
            Self::Touched => "touched",
            Self::Blind => "blind",
        }
    }
}

/// How far the floor job is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FloorProgress {
    /// What it is doing.
    pub state: FloorState,
    /// Floor swept so far by the estimated path, m^2.
    pub swept_m2: f32,
    /// Floor that was seen, has room for the body and is not swept, m^2; counted anew every thirteen seconds.
    pub left_m2: f32,
    /// Areas to clean that it did not come to so far, a bit each in their order.
    pub missed: u8,
    /// Seconds spent in each state, in the order of [`FloorState::ALL`].
    pub seconds_in: [u16; FloorState::ALL.len()],
}

impl FloorProgress {
    /// Share of the floor seen so far that is swept.
    pub fn share(&self) -> f32 {
        self.swept_m2 / (self.swept_m2 + self.left_m2).max(QUARTER_M * QUARTER_M)
    }
}

/// Cells of the picture that are counted in one step.
const COUNTED: usize = 20;

/// A room is left where so many squares of two by two cells lie in what is left, not swept at all: a third of a square metre in one piece has as
/// many.
/// What lies about in scraps, beside furniture, has six at most, in sixty random homes.
const ROOM: u8 = 8;

/// Counts floor and time, a little each step.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    /// Quarters swept.
    swept: u32,
    /// Quarters left as of the last whole count, and in this one so far.
    left: u16,
    counted: u16,
    /// Squares of two by two cells in what is left, likewise, and whether a cell and the one below it may be half of one.
    squares: u8,
    counted_squares: u8,
    is_half: bool,
    /// The cell counted next, row by row.
    next: u16,
    /// Time in each state, seconds; microseconds of a second begun; when it was counted last, before the first step the end of all time.
    seconds_in: [u16; FloorState::ALL.len()],
    begun_us: u32,
    last_us: u64,
}

/// A gap between two steps counts as at most this long, microseconds.
const LONGEST_US: u64 = 1_000_000;

impl Tally {
    pub(super) const fn new() -> Self {
        let seconds_in = [0; FloorState::ALL.len()];
        Self {
            swept: 0,
            left: 0,
            counted: 0,
            squares: 0,
            counted_squares: 0,
            is_half: false,
            next: 0,
            seconds_in,
            begun_us: 0,
            last_us: u64::MAX,
        }
    }

    pub(super) fn add(&mut self, new_quarters: u16) {
        self.swept = self.swept.saturating_add(new_quarters.into());
    }

    /// Nothing is swept after all.
    pub(super) fn clear(&mut self) {
        self.swept = 0;
    }

    /// So many quarters were not swept after all.
    pub(super) fn take_back(&mut self, quarters: u16) {
        self.swept = self.swept.saturating_sub(quarters.into());
    }

    /// Quarters swept so far.
    pub(super) fn swept(&self) -> u32 {
        self.swept
    }

    /// So much was known before a reset.
    pub(super) fn take_up(&mut self, swept: u32, seconds_in: [u16; FloorState::ALL.len()]) {
        (self.swept, self.seconds_in) = (swept, seconds_in);
    }

    /// Whether the job has hardly begun: what is swept on the way out of the dock is no more than this.
    pub(super) fn is_new(&self) -> bool {
        self.swept < 60
    }

    /// A step in this state ended now.
    pub(super) fn step(&mut self, sheet: &Sheet, state: FloorState, now_us: u64) {
        for _ in 0..COUNTED {
            let cell = Cell { col: self.next as i16 % CELLS as i16, row: self.next as i16 / CELLS as i16 };
            let left = sheet.swept.left_in(cell) as u16;
            let is_floor = left > 0 && is_passable(&sheet.picture, cell);
            if is_floor {
                self.counted = self.counted.saturating_add(left);
            }
            let is_whole = |cell: Cell| sheet.swept.left_in(cell) == 4 && sheet.picture.is_free(cell);
            let is_half = is_floor && is_whole(cell) && is_whole(cell.offset(0, -1));
            let is_square = core::mem::replace(&mut self.is_half, is_half) && is_half && cell.col > 0;
            self.counted_squares = self.counted_squares.saturating_add(u8::from(is_square));
            self.next += 1;
            if usize::from(self.next) == CELLS * CELLS {
                (self.left, self.squares) = (self.counted, self.counted_squares);
                (self.counted, self.counted_squares, self.next) = (0, 0, 0);
            }
        }
        let passed_us = now_us.saturating_sub(self.last_us).min(LONGEST_US);
        self.last_us = now_us;
        self.begun_us += passed_us as u32;
        while self.begun_us >= 1_000_000 {
            self.begun_us -= 1_000_000;
            if let Some(seconds) = self.seconds_in.get_mut(state as usize) {
                *seconds = seconds.saturating_add(1);
            }
        }
    }

    /// Whether floor is left in one piece, or a few, and not in scraps.
    pub(super) fn is_room_left(&self) -> bool {
        self.squares >= ROOM
    }

    pub(super) fn progress(&self, state: FloorState) -> FloorProgress {
        let area_m2 = |quarters: u32| quarters as f32 * QUARTER_M * QUARTER_M;
        FloorProgress {
            state,
            swept_m2: area_m2(self.swept),
            left_m2: area_m2(self.left.into()),
            missed: 0,
            seconds_in: self.seconds_in,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_is_listed_at_its_place_and_has_a_name_of_its_own() {
        for (index, state) in FloorState::ALL.into_iter().enumerate() {
            assert_eq!(state as usize, index);
            assert!(FloorState::ALL.iter().filter(|other| other.name() == state.name()).count() == 1);
        }
    }

    /// Whether much is left where these cells were seen and not swept.
    fn is_much(cells: impl Iterator<Item = (i16, i16)>) -> bool {
        let (mut tally, mut sheet) = (Tally::new(), Sheet::new());
        cells.for_each(|(col, row)| sheet.picture.see_free(Cell { col, row }));
        let steps = (CELLS * CELLS / COUNTED) as u64;
        (0..steps).for_each(|step| tally.step(&sheet, FloorState::Planning, step));
        tally.is_room_left()
    }

    #[test]
    fn a_piece_of_floor_is_much_and_as_much_of_it_in_scraps_is_not() {
        let block = |cols: i16, rows: i16| (0..cols).flat_map(move |col| (0..rows).map(move |row| (col, row)));
        assert!(is_much(block(4, 4).map(|(col, row)| (30 + col, 50 + row))));
        assert!(is_much(block(9, 2).map(|(col, row)| (30 + col, row))), "at the edge of the picture");
        assert!(!is_much(block(40, 1)), "a strip that the brush is too wide for");
        assert!(!is_much(block(8, 8).map(|(col, row)| (2 * col, 2 * row))), "single cells");
        // One cell at the end of a row and one where the next begins are not beside one another.
        let ends = (0..16).map(|row| (CELLS as i16 - 1, row)).chain((0..16).map(|row| (0, row)));
        assert!(!is_much(ends));
    }

    #[test]
    fn time_goes_to_the_state_of_the_moment_and_a_pause_of_the_clock_to_none() {
        let (mut tally, sheet) = (Tally::new(), Sheet::new());
        (0..=100).for_each(|step| tally.step(&sheet, FloorState::Lane, step * 40_000));
        tally.step(&sheet, FloorState::Edge, 3_600_000_000);
        let progress = tally.progress(FloorState::Edge);
        assert_eq!(progress.seconds_in[FloorState::Lane as usize], 4);
        assert!(progress.seconds_in[FloorState::Edge as usize] <= 1);
    }
}
