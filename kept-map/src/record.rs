//! The record: little-endian words of 32 bits.
//!
//! Walls, means and covariance are in the filter's frame, which `start` and `anchor` put into the map frame ([`KeptFrame`]); areas are
//! in the map frame. States have their numbers in the filter: the mean of state i is the (i - 3)th.
//!
//! | words | what they are |
//! |---|---|
//! | 2 | magic |
//! | 1 | version |
//! | 1 | length of the record in words, with the CRC |
//! | 1 | sequence number of the save |
//! | 1 | hash of the rig |
//! | 2 | states, states that no wall has; walls, next identifier (16 bits each) |
//! | 1 | grid founded, log odds in quarters that walls stand exactly on the grid or -128 where they stand as built ones do, the first drive started in the dock, anchor known (8 bits each) |
//! | 1 | nothing |
//! | 3 | where the first drive started: x, y, theta |
//! | 9 | the anchor: x, y, theta; covariance xx, xy, xt, yy, yt, tt |
//! | 8 a wall | identifier and state of rho; kind (0 free, 1 snapped, 2 on the grid, 3 near it, 4 as built), quarter and state of the direction; lo; hi; updates; score, nothing, drawn; line as it was drawn: rho, beta |
//! | 1 a state but for the pose's | means: grid, motion, gains, age, stamp (those that are estimated), walls |
//! | n (n + 1) / 2 | covariance of those n, upper triangle by rows |
//! | 1 an area and 2 a corner of it | [areas](crate::Areas), in version 2 alone: without any, a record is one of version 1 |
//! | 1 | CRC-32 (ISO-HDLC) of all words before |

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use slam_core::Pose;
use slam_core::kept::{Direction, Kept, KeptFrame, KeptWall, POSE_STATES};

use crate::areas::{self, Areas, Corner};
use crate::refused::Refused;

/// Number of the format; another number is another format. A record without areas is one of the version before.
pub const VERSION: u32 = 2;
pub(crate) const WITHOUT_AREAS: u32 = 1;

const MAGIC: [u32; 2] = [u32::from_le_bytes(*b"wall"), u32::from_le_bytes(*b"map\0")];

/// Words before the walls.
const HEAD: usize = 22;
const WALL: usize = 8;

pub(crate) const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Most states and walls of a record: those of any estimator are fewer.
const MOST: usize = 4096;

/// Sizes of a record.
#[derive(Clone, Copy, Debug)]
struct Layout {
    walls: usize,
    /// States but for the pose's.
    states: usize,
    /// Words of the areas.
    areas: usize,
}

impl Layout {
    fn means(self) -> usize {
        HEAD + WALL * self.walls
    }

    fn covariance(self) -> usize {
        self.means() + self.states
    }

    /// Place of the areas, and end of what every record has.
    fn areas(self) -> usize {
        self.covariance() + self.states * (self.states + 1) / 2
    }

    /// Words of the record, with the CRC.
    fn len(self) -> usize {
        self.areas() + self.areas + 1
    }

    /// Place of an entry of the covariance, i <= j, both without the pose.
    fn entry(self, i: usize, j: usize) -> usize {
        self.covariance() + i * self.states - i * i.saturating_sub(1) / 2 + j - i
    }
}

/// A record to be written, word by word.
pub struct Writer<'k, K> {
    kept: &'k K,
    frame: KeptFrame,
    layout: Layout,
    areas: &'k [u32],
    sequence: u32,
    rig: u32,
}

impl<'k, K: Kept> Writer<'k, K> {
    /// The record of a map as the save of this number, made by the robot with this [`rig_hash`](crate::rig_hash).
    pub fn new(kept: &'k K, sequence: u32, rig: u32) -> Self {
        let frame = kept.frame();
        let states = usize::from(frame.states).saturating_sub(POSE_STATES);
        let layout = Layout { walls: usize::from(frame.walls), states, areas: 0 };
        Self { kept, frame, layout, areas: &[], sequence, rig }
    }

    /// The same with these areas in the map.
    pub fn with_areas(self, areas: &'k Areas) -> Self {
        let words = areas.words();
        Self { layout: Layout { areas: words.len(), ..self.layout }, areas: words, ..self }
    }

    /// Words of the record without the CRC that ends it.
    pub fn len(&self) -> usize {
        self.layout.len() - 1
    }

    /// Never: a record has a head.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The word at a place before the CRC.
    pub fn word(&self, place: usize) -> u32 {
        let Layout { states, .. } = self.layout;
        if place < HEAD {
            return self.head()[place];
        }
        if place < self.layout.means() {
            let (wall, part) = ((place - HEAD) / WALL, (place - HEAD) % WALL);
            return self.kept.wall(wall).map_or(0, |wall| words_of(&wall)[part]);
        }
        if place < self.layout.covariance() {
            return self.kept.mean(POSE_STATES + place - self.layout.means()).to_bits();
        }
        if let Some(area) = place.checked_sub(self.layout.areas()) {
            return self.areas.get(area).copied().unwrap_or_default();
        }
        let (mut row, mut left) = (0, place - self.layout.covariance());
        while left >= states - row {
            left -= states - row;
            row += 1;
        }
        self.kept.covariance(POSE_STATES + row, POSE_STATES + row + left).to_bits()
    }

    fn head(&self) -> [u32; HEAD] {
        let f = &self.frame;
        let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        let (anchor, p) = f.anchor.unwrap_or_default();
        let flags = [f.has_grid as u8, f.exactness as u8, f.has_dock as u8, f.anchor.is_some() as u8];
        let [sx, sy, st] = bits(&f.start);
        let [ax, ay, at] = bits(&anchor);
        [
            MAGIC[0],
            MAGIC[1],
            if self.areas.is_empty() { WITHOUT_AREAS } else { VERSION },
            self.layout.len() as u32,
            self.sequence,
            self.rig,
            pair(f.states, f.common),
            pair(f.walls, f.next_id),
            u32::from_le_bytes(flags),
            0,
            sx,
            sy,
            st,
            ax,
            ay,
            at,
            p[0][0].to_bits(),
            p[0][1].to_bits(),
            p[0][2].to_bits(),
            p[1][1].to_bits(),
            p[1][2].to_bits(),
            p[2][2].to_bits(),
        ]
    }

    /// Every byte of the record, in order, in pieces.
    pub fn bytes(&self, mut each: impl FnMut(&[u8])) {
        let mut digest = CRC.digest();
        for place in 0..self.len() {
            let word = self.word(place).to_le_bytes();
            digest.update(&word);
            each(&word);
        }
        each(&digest.finalize().to_le_bytes());
    }
}

fn bits(pose: &Pose) -> [u32; 3] {
    [pose.x_m, pose.y_m, pose.theta_rad].map(f32::to_bits)
}

fn words_of(wall: &KeptWall) -> [u32; WALL] {
    let (kind, quarter, theta) = match wall.direction {
        Direction::Free(theta) => (0, 0, theta),
        Direction::Snapped(theta) => (1, 0, theta),
        Direction::Grid(quarter) => (2, quarter, 0),
        Direction::NearGrid(theta, quarter) => (3, quarter, theta),
        Direction::Built(theta, quarter) => (4, quarter, theta),
    };
    let [t0, t1] = theta.to_le_bytes();
    let drawn = wall.drawn.unwrap_or_default();
    [
        u32::from(wall.id) | u32::from(wall.rho) << 16,
        u32::from_le_bytes([kind, quarter, t0, t1]),
        wall.lo_m.to_bits(),
        wall.hi_m.to_bits(),
        wall.updates,
        u32::from_le_bytes([wall.score as u8, 0, wall.drawn.is_some() as u8, 0]),
        drawn[0].to_bits(),
        drawn[1].to_bits(),
    ]
}

/// A record that is whole.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    bytes: &'a [u8],
    layout: Layout,
}

impl<'a> Record<'a> {
    /// The record that bytes begin with; what follows it is passed over.
    ///
    /// # Errors
    /// They are not a whole record of this version.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, Refused> {
        let layout = layout_of(|place| word(bytes, place))?;
        let end = 4 * (layout.len() - 1);
        let content = bytes.get(..end).ok_or(Refused::Corrupt)?;
        if word(bytes, layout.len() - 1) != Some(CRC.checksum(content)) {
            return Err(Refused::Corrupt);
        }
        Ok(Self { bytes: content, layout })
    }

    /// The record that bytes begin with, where they were checked before.
    ///
    /// # Errors
    /// They do not begin as a record of this version does.
    pub fn whole(bytes: &'a [u8]) -> Result<Self, Refused> {
        let layout = layout_of(|place| word(bytes, place))?;
        let bytes = bytes.get(..4 * (layout.len() - 1)).ok_or(Refused::Corrupt)?;
        Ok(Self { bytes, layout })
    }

    /// The check sum of the record that bytes begin with, which tells it from every other one; none where it is not all there.
    pub fn check_sum(bytes: &[u8]) -> Option<u32> {
        let layout = layout_of(|place| word(bytes, place)).ok()?;
        word(bytes, layout.len() - 1)
    }

    /// This record where it was made by a robot with this [`rig_hash`](crate::rig_hash).
    ///
    /// # Errors
    /// It was made by another one.
    pub fn of_rig(self, rig: u32) -> Result<Self, Refused> {
        if self.word(5) == rig { Ok(self) } else { Err(Refused::OtherRig) }
    }

    /// The number of the save.
    pub fn sequence(&self) -> u32 {
        self.word(4)
    }

    /// Words of the record, with the CRC.
    pub fn words(&self) -> usize {
        self.layout.len()
    }

    /// The areas in the map.
    pub fn areas(&self) -> Areas {
        Areas::of_words((0..self.layout.areas).map(|place| self.word(self.layout.areas() + place)))
    }

    /// The corners of its areas, of one after those of the other.
    pub fn corners(self) -> impl Iterator<Item = Corner> {
        let Layout { areas: count, .. } = self.layout;
        areas::corners(move |place| (place < count).then(|| self.word(self.layout.areas() + place)))
    }

    fn word(&self, place: usize) -> u32 {
        word(self.bytes, place).unwrap_or_default()
    }

    fn float(&self, place: usize) -> f32 {
        f32::from_bits(self.word(place))
    }
}

fn word(bytes: &[u8], place: usize) -> Option<u32> {
    bytes.get(4 * place..4 * place + 4)?.try_into().ok().map(u32::from_le_bytes)
}

/// The sizes that a record's head tells; `word` reads one of its words.
fn layout_of(word: impl Fn(usize) -> Option<u32>) -> Result<Layout, Refused> {
    if (word(0), word(1)) != (Some(MAGIC[0]), Some(MAGIC[1])) {
        return Err(Refused::Foreign);
    }
    let head = |place| word(place).ok_or(Refused::Corrupt);
    let most_areas = match head(2)? {
        WITHOUT_AREAS => 0,
        VERSION => areas::MOST,
        other => return Err(Refused::Version(other)),
    };
    let (states, walls) = ((head(6)? & 0xFFFF) as usize, (head(7)? & 0xFFFF) as usize);
    if !(POSE_STATES + 1..=MOST).contains(&states) || walls > MOST {
        return Err(Refused::Corrupt);
    }
    let layout = Layout { walls, states: states - POSE_STATES, areas: 0 };
    let areas = (head(3)? as usize).checked_sub(layout.len()).filter(|areas| *areas <= most_areas);
    Ok(Layout { areas: areas.ok_or(Refused::Corrupt)?, ..layout })
}

/// Words of the head that tell the record's sizes.
pub(crate) const HEAD_SIZES: usize = 8;

/// Words of the record that begins with these, with the CRC.
pub(crate) fn len_of_head(head: &[u32; HEAD_SIZES]) -> Result<usize, Refused> {
    layout_of(|place| head.get(place).copied()).map(Layout::len)
}

/// Place and number of words of the areas in the record that begins with these.
pub(crate) fn areas_of_head(head: &[u32; HEAD_SIZES]) -> Result<(usize, usize), Refused> {
    layout_of(|place| head.get(place).copied()).map(|layout| (layout.areas(), layout.areas))
}

/// Checks a record that is read word by word; its sequence number where it is whole.
pub(crate) fn check(mut word: impl FnMut(usize) -> Option<u32>) -> Option<u32> {
    let mut head = [0; HEAD_SIZES];
    for (place, entry) in head.iter_mut().enumerate() {
        *entry = word(place)?;
    }
    let last = len_of_head(&head).ok()? - 1;
    let mut digest = CRC.digest();
    for place in 0..last {
        digest.update(&word(place)?.to_le_bytes());
    }
    (word(last)? == digest.finalize()).then_some(head[4])
}

impl Kept for Record<'_> {
    fn frame(&self) -> KeptFrame {
        let halves = |word: u32| (word as u16, (word >> 16) as u16);
        let ((states, common), (walls, next_id)) = (halves(self.word(6)), halves(self.word(7)));
        let [has_grid, exactness, has_dock, is_anchored] = self.word(8).to_le_bytes();
        let pose =
            |place| Pose { x_m: self.float(place), y_m: self.float(place + 1), theta_rad: self.float(place + 2) };
        let [xx, xy, xt, yy, yt, tt] = [16, 17, 18, 19, 20, 21].map(|place| self.float(place));
        KeptFrame {
            states,
            common,
            walls,
            next_id,
            has_grid: has_grid != 0,
            has_dock: has_dock != 0,
            exactness: exactness as i8,
            start: pose(10),
            anchor: (is_anchored != 0).then(|| (pose(13), [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])),
            number: 0,
        }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        if index >= self.layout.walls {
            return None;
        }
        let place = HEAD + WALL * index;
        let [kind, quarter, t0, t1] = self.word(place + 1).to_le_bytes();
        let theta = u16::from_le_bytes([t0, t1]);
        let [score, _, is_drawn, _] = self.word(place + 5).to_le_bytes();
        Some(KeptWall {
            id: self.word(place) as u16,
            rho: (self.word(place) >> 16) as u16,
            direction: match kind {
                0 => Direction::Free(theta),
                1 => Direction::Snapped(theta),
                2 => Direction::Grid(quarter & 3),
                3 => Direction::NearGrid(theta, quarter & 3),
                _ => Direction::Built(theta, quarter & 3),
            },
            lo_m: self.float(place + 2),
            hi_m: self.float(place + 3),
            updates: self.word(place + 4),
            score: score as i8,
            drawn: (is_drawn != 0).then(|| [self.float(place + 6), self.float(place + 7)]),
        })
    }

    fn mean(&self, i: usize) -> f32 {
        i.checked_sub(POSE_STATES)
            .filter(|i| *i < self.layout.states)
            .map_or(0.0, |i| self.float(self.layout.means() + i))
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        let (i, j) = (i.min(j), i.max(j));
        if i < POSE_STATES || j - POSE_STATES >= self.layout.states {
            return 0.0;
        }
        self.float(self.layout.entry(i - POSE_STATES, j - POSE_STATES))
    }
}
