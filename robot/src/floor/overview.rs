//! What is known of the home beyond the picture, in blocks of 78 cm: where there is floor, and where some of it is left to sweep.

use super::swept::CELLS;

/// Cells of the picture along an edge of a block.
pub(super) const BLOCK: i16 = 5;

/// Blocks along an edge of what is known: 25 m.
const BLOCKS: usize = 32;

/// Blocks along an edge of the picture.
const PICTURE: i16 = CELLS as i16 / BLOCK;
const _: () = assert!(CELLS as i16 % BLOCK == 0);

/// Bytes of a row.
const ROW: usize = BLOCKS / 4;

/// Bytes of all that is known.
pub(super) const OVERVIEW_BYTES: usize = ROW * BLOCKS + 4;

/// A block by its column and row, counted from where the job's frame begins. Beyond 99 m from there all are one.
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

/// What is known of the blocks that fell off the picture: a plane that is rolled up both ways.
#[derive(Clone, Debug)]
pub(super) struct Overview {
    /// Row by row two bits a block, and then the first column, the first row, the last column and the last row that are remembered; those of
    /// the picture are among them.
    bytes: [u8; OVERVIEW_BYTES],
}

/// Where a block is stored: its byte, and how far its bits are shifted there.
fn place([col, row]: Block) -> (usize, u32) {
    let [col, row] = [col, row].map(|index| index.rem_euclid(BLOCKS as i16) as usize);
    (ROW * row + col / 4, 2 * (col as u32 % 4))
}

impl Overview {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; OVERVIEW_BYTES] }
    }

    /// All of it, for a memory that lasts.
    pub(super) fn bytes(&mut self) -> &mut [u8; OVERVIEW_BYTES] {
        &mut self.bytes
    }

    /// First and last block of those that are remembered.
    fn ends(&self) -> [Block; 2] {
        let mut ends = [[0; 2]; 2];
        let bytes = self.bytes.iter().skip(ROW * BLOCKS);
        ends.as_flattened_mut().iter_mut().zip(bytes).for_each(|(end, byte)| *end = i16::from(*byte as i8));
        // Whatever a damaged memory says: no more than there are.
        let [from, to] = ends;
        [from, [0, 1].map(|axis| to[axis].min(from[axis] + BLOCKS as i16 - 1))]
    }

    pub(super) fn of(&self, block: Block) -> Known {
        let [from, to] = self.ends();
        let is_within = (0..2).all(|axis| (from[axis]..=to[axis]).contains(&block[axis]));
        if is_within { self.within(block) } else { Known::Nothing }
    }

    /// Of one that is remembered.
    fn within(&self, block: Block) -> Known {
        let (byte, shift) = place(block);
        match self.bytes.get(byte).map_or(0, |byte| byte >> shift & 3) {
            1 => Known::Swept,
            2 => Known::Left,
            _ => Known::Nothing,
        }
    }

    pub(super) fn put(&mut self, block: Block, known: Known) {
        self.include(block);
        self.set(block, known);
    }

    fn set(&mut self, block: Block, known: Known) {
        let (byte, shift) = place(block);
        if let Some(byte) = self.bytes.get_mut(byte) {
            *byte = *byte & !(3 << shift) | (known as u8) << shift;
        }
    }

    /// Remembers this block from now on, and none that is 25 m from there.
    pub(super) fn include(&mut self, block: Block) {
        let before = self.ends();
        let [mut from, mut to] = before;
        for axis in 0..2 {
            let index = block[axis].clamp(i8::MIN.into(), i8::MAX.into());
            if index < from[axis] {
                from[axis] = index;
                to[axis] = to[axis].min(index + BLOCKS as i16 - 1);
            } else if index > to[axis] {
                to[axis] = index;
                from[axis] = from[axis].max(index - BLOCKS as i16 + 1);
            }
        }
        if [from, to] == before {
            return;
        }
        for row in before[0][1]..=before[1][1] {
            for col in before[0][0]..=before[1][0] {
                if !((from[0]..=to[0]).contains(&col) && (from[1]..=to[1]).contains(&row)) {
                    self.set([col, row], Known::Nothing);
                }
            }
        }
        let ends = [from, to];
        let bytes = self.bytes.iter_mut().skip(ROW * BLOCKS);
        bytes.zip(ends.as_flattened()).for_each(|(byte, end)| *byte = *end as u8);
    }

    /// The block of the picture that is next on a shortest way to a goal, over what is known beyond it: to this block, or to any where floor is
    /// left. `picture` is its first block; in some of its blocks the robot was and has room, others count as they are known.
    pub(super) fn exit(&self, picture: Block, goal: Option<Block>, has_room: impl Fn(Block) -> bool) -> Option<Block> {
        let [from, to] = self.ends();
        let [cols, rows] = [0, 1].map(|axis| 0..=(to[axis] - from[axis]));
        let block = |col: i16, row: i16| [from[0] + col, from[1] + row];
        let is_exit =
            |block: Block| (0..2).all(|axis| (0..PICTURE).contains(&(block[axis] - picture[axis]))) && has_room(block);
        // A line of bits for each row: where the wave is, and where it may go.
        let [mut reached, mut ways] = [[0_u32; BLOCKS]; 2];
        for (row, (reached, ways)) in rows.clone().zip(reached.iter_mut().zip(&mut ways)) {
            for col in cols.clone() {
                let block = block(col, row);
                let known = self.within(block);
                let is_goal = goal.map_or(known == Known::Left, |goal| block == goal);
                if (is_goal || known != Known::Nothing) && !is_exit(block) {
                    *ways |= 1 << col;
                    *reached |= u32::from(is_goal) << col;
                }
            }
        }
        let mut is_spreading = true;
        while core::mem::take(&mut is_spreading) {
            let (mut above, mut rest) = (0, &mut reached[..]);
            for (row, ways) in rows.clone().zip(&ways) {
                let Some((here, after)) = rest.split_first_mut() else { break };
                let before = *here;
                let around = before | before << 1 | before >> 1 | above | after.first().copied().unwrap_or(0);
                let touched = around & !ways;
                if touched != 0
                    && let Some(exit) = cols
                        .clone()
                        .filter(|col| touched >> col & 1 != 0)
                        .map(|col| block(col, row))
                        .find(|block| is_exit(*block))
                {
                    return Some(exit);
                }
                *here |= around & ways;
                is_spreading |= *here != before;
                (above, rest) = (before, after);
            }
        }
        None
    }

    /// What is left nearest to a block is given up.
    pub(super) fn give_up_near(&mut self, near: Block) {
        let [from, to] = self.ends();
        let mut nearest = (i16::MAX, near);
        for row in from[1]..=to[1] {
            for col in from[0]..=to[0] {
                let moves = (col - near[0]).abs().max((row - near[1]).abs());
                if moves < nearest.0 && self.of([col, row]) == Known::Left {
                    nearest = (moves, [col, row]);
                }
            }
        }
        self.set(nearest.1, Known::Swept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The picture's first block.
    const PICTURE_AT: Block = [0, 0];

    fn towards_left(overview: &Overview, has_room: impl Fn(Block) -> bool) -> Option<Block> {
        overview.exit(PICTURE_AT, None, has_room)
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
    fn bytes_bring_all_of_it_back() {
        let overview = corridor(-9, -11..3);
        let mut again = Overview::new();
        *again.bytes() = *overview.clone().bytes();
        assert!((-20..20).all(|col| again.of([col, -9]) == overview.of([col, -9])));
    }
}
