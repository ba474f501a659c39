//! What is known of the home beyond the picture, in blocks of 78 cm: where there is floor, and where some of it is left to sweep.

use super::swept::CELLS;

/// Cells of the picture along an edge of a block.
pub(super) const BLOCK: i16 = 5;

/// Blocks along an edge of what is known: 25 m.
const BLOCKS: usize = 32;

/// Blocks along an edge of the picture.
const PICTURE: i16 = CELLS as i16 / BLOCK;
const _: () = assert!(CELLS as i16 % BLOCK == 0);

/// Bytes of all that is known.
pub(super) const OVERVIEW_BYTES: usize = 8 * BLOCKS + 8;

/// A block by its column and row, counted from where the job's frame begins.
pub(super) type Block = [i16; 2];

/// What is known of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Known {
    Nothing = 0,
    /// There is floor, and what was seen of it is swept.
    Swept = 1,
    /// There is floor left to sweep.
    Left = 2,
}

/// The first block and the last one along an axis.
#[derive(Clone, Copy, Debug)]
struct Span {
    from: i16,
    to: i16,
}

/// What is known of the blocks that fell off the picture: a plane that is rolled up both ways.
#[derive(Clone, Debug)]
pub(super) struct Overview {
    /// Two bits a block.
    rows: [u64; BLOCKS],
    /// Columns and rows that are remembered; those of the picture are among them.
    spans: [Span; 2],
}

/// Where a column or row is stored.
fn stored(index: i16) -> usize {
    index.rem_euclid(BLOCKS as i16) as usize
}

impl Overview {
    pub(super) const fn new() -> Self {
        Self { rows: [0; BLOCKS], spans: [Span { from: 0, to: 0 }, Span { from: 0, to: 0 }] }
    }

    pub(super) fn of(&self, block: Block) -> Known {
        let is_within = block.iter().zip(&self.spans).all(|(index, span)| (span.from..=span.to).contains(index));
        let [col, row] = block.map(stored);
        match self.rows.get(row).map_or(0, |row| row >> (2 * col) & 3) {
            1 if is_within => Known::Swept,
            2 if is_within => Known::Left,
            _ => Known::Nothing,
        }
    }

    pub(super) fn put(&mut self, block: Block, known: Known) {
        self.include(block);
        let [col, row] = block.map(stored);
        if let Some(row) = self.rows.get_mut(row) {
            *row = *row & !(3 << (2 * col)) | (known as u64) << (2 * col);
        }
    }

    /// What is known in bytes: eight of each row, and the first and last column and row, two bytes each, lowest first.
    pub(super) fn byte(&self, place: usize) -> u8 {
        let word = self.rows.get(place / 8).copied().unwrap_or_else(|| {
            let [cols, rows] = self.spans;
            let ends = [cols.from, cols.to, rows.from, rows.to].map(|end| u64::from(end as u16));
            ends.iter().rev().fold(0, |word, end| word << 16 | end)
        });
        (word >> (8 * (place % 8))) as u8
    }

    /// Puts such a byte there.
    pub(super) fn put_byte(&mut self, place: usize, byte: u8) {
        let shift = 8 * (place % 8);
        if let Some(row) = self.rows.get_mut(place / 8) {
            *row = *row & !(0xFF << shift) | u64::from(byte) << shift;
            return;
        }
        let [cols, rows] = &mut self.spans;
        let ends = [&mut cols.from, &mut cols.to, &mut rows.from, &mut rows.to];
        if let Some(end) = ends.into_iter().nth(place % 8 / 2) {
            let shift = 8 * (place % 2);
            *end = (*end as u16 & !(0xFF << shift) | u16::from(byte) << shift) as i16;
        }
    }

    /// Forgets all where it cannot be: more columns or rows than are stored.
    pub(super) fn check(&mut self) {
        let is_whole = |span: &Span| (0..BLOCKS as i32).contains(&(i32::from(span.to) - i32::from(span.from)));
        if !self.spans.iter().all(is_whole) {
            *self = Self::new();
        }
    }

    /// Remembers this block from now on, and none that is 25 m from there.
    pub(super) fn include(&mut self, block: Block) {
        for (axis, (index, span)) in block.into_iter().zip(&mut self.spans).enumerate() {
            let most = BLOCKS as i16 - 1;
            let before = *span;
            if index < span.from {
                *span = Span { from: index, to: span.to.min(index.saturating_add(most)) };
            } else if index > span.to {
                *span = Span { from: span.from.max(index.saturating_sub(most)), to: index };
            }
            for line in (before.from..span.from).chain(span.to.saturating_add(1)..=before.to) {
                if axis == 0 {
                    self.rows.iter_mut().for_each(|row| *row &= !(3 << (2 * stored(line))));
                } else if let Some(row) = self.rows.get_mut(stored(line)) {
                    *row = 0;
                }
            }
        }
    }

    /// The block of the picture that is next on a shortest way to one of these goals, over what is known beyond it. `picture` is its first
    /// block; in some of its blocks the robot was and has room, others count as they are known.
    pub(super) fn exit(
        &self,
        picture: Block,
        is_goal: impl Fn(Block) -> bool,
        has_room: impl Fn(Block) -> bool,
    ) -> Option<Block> {
        let [cols, rows] = self.spans;
        let is_inside =
            |block: Block| block.iter().zip(picture).all(|(index, first)| (first..first + PICTURE).contains(index));
        // A line of bits for each row: where the wave is, and where it may go.
        let [mut reached, mut ways] = [[0_u32; BLOCKS]; 2];
        for (row, (reached, ways)) in (rows.from..=rows.to).zip(reached.iter_mut().zip(&mut ways)) {
            for col in cols.from..=cols.to {
                let block = [col, row];
                let (is_way, is_goal) = (self.of(block) != Known::Nothing, is_goal(block));
                if (is_way || is_goal) && !(is_inside(block) && has_room(block)) {
                    let bit = 1 << (col - cols.from);
                    *ways |= bit;
                    *reached |= if is_goal { bit } else { 0 };
                }
            }
        }
        loop {
            let before = reached;
            let at = |line: usize| before.get(line).copied().unwrap_or(0);
            for (line, (row, (reached, ways))) in (rows.from..=rows.to).zip(reached.iter_mut().zip(&ways)).enumerate() {
                let here = *reached;
                let around = here | here << 1 | here >> 1 | at(line.wrapping_sub(1)) | at(line + 1);
                *reached |= around & ways;
                let exits = (cols.from..=cols.to).filter(|col| (around & !ways) >> (col - cols.from) & 1 != 0);
                let mut exits = exits.map(|col| [col, row]);
                if let Some(exit) = exits.find(|block| is_inside(*block) && has_room(*block)) {
                    return Some(exit);
                }
            }
            if reached == before {
                return None;
            }
        }
    }

    /// What is left nearest to a block is given up.
    pub(super) fn give_up_near(&mut self, [col, row]: Block) {
        let [cols, rows] = self.spans.map(|span| span.from..=span.to);
        let blocks = rows.flat_map(|row| cols.clone().map(move |col| [col, row]));
        let left = blocks.filter(|block| self.of(*block) == Known::Left);
        if let Some(nearest) = left.min_by_key(|left| (left[0] - col).abs().max((left[1] - row).abs())) {
            self.put(nearest, Known::Swept);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The picture's first block.
    const PICTURE_AT: Block = [0, 0];

    fn towards_left(overview: &Overview, has_room: impl Fn(Block) -> bool) -> Option<Block> {
        overview.exit(PICTURE_AT, |block| overview.of(block) == Known::Left, has_room)
    }

    /// Swept floor all along this row, up to floor that is left.
    fn corridor(row: i16, cols: core::ops::Range<i16>) -> Overview {
        let mut overview = Overview::new();
        [PICTURE_AT, [PICTURE - 1; 2]].into_iter().for_each(|block| overview.include(block));
        overview.put([cols.end, row], Known::Left);
        cols.for_each(|col| overview.put([col, row], Known::Swept));
        overview
    }

    #[test]
    fn a_block_is_remembered_until_one_comes_that_is_25_m_from_it() {
        let mut overview = Overview::new();
        overview.put([-5, 7], Known::Left);
        overview.put([4, -12], Known::Swept);
        overview.include([26, 0]);
        assert_eq!((overview.of([-5, 7]), overview.of([4, -12])), (Known::Left, Known::Swept));
        assert_eq!(overview.of([27, 7]), Known::Nothing, "it is stored where the first one is");
        overview.include([27, 0]);
        assert_eq!((overview.of([-5, 7]), overview.of([27, 7])), (Known::Nothing, Known::Nothing));
        assert_eq!(overview.of([4, -12]), Known::Swept);
        overview.include([4, 20]);
        assert_eq!(overview.of([4, -12]), Known::Nothing);
    }

    #[test]
    fn the_way_to_what_is_left_leads_out_of_the_picture_where_what_is_known_begins() {
        let mut overview = corridor(5, PICTURE..PICTURE + 6);
        assert_eq!(towards_left(&overview, |_| true), Some([PICTURE - 1, 5]));
        assert_eq!(towards_left(&overview, |[_, row]| row != 5), None, "the robot cannot stand there");
        overview.put([PICTURE + 2, 5], Known::Nothing);
        assert_eq!(towards_left(&overview, |_| true), None, "there is a gap");
    }

    #[test]
    fn blocks_of_the_picture_that_were_not_seen_again_are_on_the_way_or_are_what_is_left() {
        // It came into the picture by half.
        let overview = corridor(5, PICTURE - 8..PICTURE - 3);
        let was_seen = |[col, _]: Block| col < PICTURE - 8;
        assert_eq!(towards_left(&overview, was_seen), Some([PICTURE - 9, 5]));
        assert_eq!(towards_left(&overview, |_| true), None, "all of it was seen: the picture knows");
    }

    #[test]
    fn what_is_given_up_is_the_nearest_that_is_left() {
        let mut overview = corridor(5, PICTURE..PICTURE + 6);
        overview.put([PICTURE + 9, 0], Known::Left);
        overview.give_up_near([PICTURE - 1, 5]);
        assert_eq!((overview.of([PICTURE + 6, 5]), overview.of([PICTURE + 9, 0])), (Known::Swept, Known::Left));
        overview.give_up_near([PICTURE - 1, 5]);
        assert_eq!(towards_left(&overview, |_| true), None);
    }

    #[test]
    fn bytes_bring_all_of_it_back_and_those_that_cannot_be_bring_nothing() {
        let overview = corridor(-9, -11..3);
        let mut again = Overview::new();
        (0..OVERVIEW_BYTES).for_each(|place| again.put_byte(place, overview.byte(place)));
        again.check();
        assert!((-20..20).all(|col| again.of([col, -9]) == overview.of([col, -9])));
        again.put_byte(OVERVIEW_BYTES - 1, 0x70);
        again.check();
        assert_eq!(again.of([3, -9]), Known::Nothing);
    }
}
