//! Bytes on the line: COBS(version, postcard, CRC-32), zero.

use crate::frames::{Command, Frame};
use crate::map::MapRequest;
use core::marker::PhantomData;
use crc::{Crc, NoTable};
use heapless::Vec;

/// First byte of every frame. Another number is another format.
pub const VERSION: u8 = 5;
/// Longest frame on the line, bytes, the closing zero included.
pub const FRAME_CAPACITY: usize = 192;

/// A bit-by-bit CRC: frames are short, and a table would take a kilobyte of flash.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&crc::CRC_32_ISO_HDLC);
const CRC_BYTES: usize = 4;
/// What COBS adds, and the closing zero.
const FRAMING_BYTES: usize = 2;
const BODY_CAPACITY: usize = FRAME_CAPACITY - FRAMING_BYTES;

/// Why a frame cannot be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// It does not fit [`FRAME_CAPACITY`].
    TooLong,
}

/// Why bytes are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// More bytes than any frame has before a zero byte.
    TooLong,
    /// Not COBS, or too short for a frame.
    Framing,
    /// The check sum does not fit.
    Checksum,
    /// The other side speaks this version of the format.
    Version(u8),
    /// The check sum fits, but the content is not a known frame.
    Content,
}

/// The bytes of a frame, with the closing zero.
///
/// # Errors
/// The frame is too long; none of the known ones is.
pub fn encode(frame: &Frame) -> Result<Vec<u8, FRAME_CAPACITY>, EncodeError> {
    let mut body = [0; BODY_CAPACITY];
    body[0] = VERSION;
    let content = &mut body[1..BODY_CAPACITY - CRC_BYTES];
    let end = 1 + postcard::to_slice(frame, content).map_err(|_| EncodeError::TooLong)?.len();
    let checksum = CRC.checksum(&body[..end]);
    body[end..end + CRC_BYTES].copy_from_slice(&checksum.to_le_bytes());
    let mut bytes = Vec::new();
    bytes.resize_default(FRAME_CAPACITY).map_err(|_| EncodeError::TooLong)?;
    let written = cobs::try_encode(&body[..end + CRC_BYTES], &mut bytes[..FRAME_CAPACITY - 1])
        .map_err(|_| EncodeError::TooLong)?;
    bytes.truncate(written + 1);
    bytes[written] = 0;
    Ok(bytes)
}

/// What is said to a robot: of all frames these two. To read the others, which it says itself, costs it thirteen kilobytes of flash.
#[derive(Clone, Debug, PartialEq)]
pub enum ToRobot {
    /// [`Frame::Command`].
    Command(Command),
    /// [`Frame::MapRequest`].
    MapRequest(MapRequest),
}

/// What bytes between version and check sum say.
trait Content: Sized {
    /// Reads it; none where it is not whole, or something else.
    fn read(bytes: &[u8]) -> Option<Self>;
}

impl Content for Frame {
    fn read(bytes: &[u8]) -> Option<Self> {
        whole(bytes)
    }
}

impl Content for ToRobot {
    fn read(bytes: &[u8]) -> Option<Self> {
        // A frame's number is its place among the variants of `Frame`.
        match bytes {
            [6, command @ ..] => whole(command).map(Self::Command),
            [9, request @ ..] => whole(request).map(Self::MapRequest),
            _ => None,
        }
    }
}

/// A value that takes all of these bytes.
fn whole<'b, T: serde::Deserialize<'b>>(bytes: &'b [u8]) -> Option<T> {
    postcard::take_from_bytes(bytes).ok().filter(|(_, rest)| rest.is_empty()).map(|(value, _)| value)
}

/// Finds frames in a stream of bytes.
#[derive(Clone, Debug)]
pub struct Decoder<T = Frame> {
    bytes: Vec<u8, FRAME_CAPACITY>,
    overflowed: bool,
    frames: PhantomData<T>,
}

impl<T> Default for Decoder<T> {
    fn default() -> Self {
        Self { bytes: Vec::new(), overflowed: false, frames: PhantomData }
    }
}

impl Decoder {
    /// A decoder at the start of a stream.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Decoder<ToRobot> {
    /// A robot's: any other frame is an error.
    pub fn of_robot() -> Self {
        Self::default()
    }
}

#[expect(private_bounds, reason = "nobody reads anything else from these bytes")]
impl<T: Content> Decoder<T> {
    /// Takes one byte; the closing zero gives a frame or an error. Zeros between frames are nothing.
    pub fn push(&mut self, byte: u8) -> Option<Result<T, DecodeError>> {
        if byte != 0 {
            self.overflowed |= self.bytes.push(byte).is_err();
            return None;
        }
        let result = match (self.overflowed, self.bytes.is_empty()) {
            (true, _) => Some(Err(DecodeError::TooLong)),
            (false, true) => None,
            (false, false) => Some(decode(&mut self.bytes)),
        };
        self.bytes.clear();
        self.overflowed = false;
        result
    }
}

/// A frame from the bytes before its closing zero, which are overwritten.
// Inlined into a task it costs the stack a kilobyte.
#[inline(never)]
fn decode<T: Content>(bytes: &mut [u8]) -> Result<T, DecodeError> {
    let length = cobs::decode_in_place(bytes).map_err(|_| DecodeError::Framing)?;
    let body = bytes.get(..length).ok_or(DecodeError::Framing)?;
    let (content, checksum) = body.split_last_chunk::<CRC_BYTES>().ok_or(DecodeError::Framing)?;
    if CRC.checksum(content) != u32::from_le_bytes(*checksum) {
        return Err(DecodeError::Checksum);
    }
    match content {
        [VERSION, content @ ..] => T::read(content).ok_or(DecodeError::Content),
        [other, ..] => Err(DecodeError::Version(*other)),
        [] => Err(DecodeError::Framing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Command;

    fn decode_all(bytes: &[u8]) -> Vec<Result<Frame, DecodeError>, 8> {
        let mut decoder = Decoder::new();
        bytes.iter().filter_map(|byte| decoder.push(*byte)).collect()
    }

    #[test]
    fn the_format_is_pinned() {
        // version 5, Command = 6, Stop = 1, CRC-32, in COBS.
        let bytes = encode(&Frame::Command(Command::Stop)).unwrap();
        let checksum = CRC.checksum(&[5, 6, 1]).to_le_bytes();
        assert_eq!(bytes.as_slice(), [8, 5, 6, 1, checksum[0], checksum[1], checksum[2], checksum[3], 0]);
        assert_eq!(CRC.checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn a_robot_hears_what_is_said_to_it_and_nothing_else() {
        let (mut robot, mut any) = (Decoder::of_robot(), Decoder::new());
        let mut both = |frame: &Frame| {
            let bytes = encode(frame).unwrap();
            let heard = bytes.iter().find_map(|byte| robot.push(*byte)).expect("a frame ends");
            assert_eq!(bytes.iter().find_map(|byte| any.push(*byte)), Some(Ok(frame.clone())));
            heard
        };
        for command in [Command::Stop, Command::Clean { anew: true }, Command::Spin { left: 0.5, right: -0.5 }] {
            assert_eq!(both(&Frame::Command(command)), Ok(ToRobot::Command(command)));
        }
        let request = MapRequest::Forget;
        assert_eq!(both(&Frame::MapRequest(request.clone())), Ok(ToRobot::MapRequest(request)));
        assert_eq!(both(&Frame::Place(Default::default())), Err(DecodeError::Content));
    }

    #[test]
    fn another_version_is_named() {
        let mut body = [2, 6, 1, 0, 0, 0, 0];
        let checksum = CRC.checksum(&body[..3]).to_le_bytes();
        body[3..].copy_from_slice(&checksum);
        let mut bytes = [0; 16];
        let length = cobs::encode(&body, &mut bytes);
        assert_eq!(decode_all(&bytes[..=length]).as_slice(), [Err(DecodeError::Version(2))]);
    }

    #[test]
    fn a_stream_without_zeros_is_one_error_and_then_over() {
        let mut decoder = Decoder::new();
        assert!((0..10_000).all(|_| decoder.push(7).is_none()));
        assert_eq!(decoder.push(0), Some(Err(DecodeError::TooLong)));
        let bytes = encode(&Frame::Command(Command::Start)).unwrap();
        let last = bytes.iter().filter_map(|byte| decoder.push(*byte)).last();
        assert_eq!(last, Some(Ok(Frame::Command(Command::Start))));
    }

    #[test]
    fn unknown_content_with_a_right_checksum_is_refused() {
        for content in [&[VERSION, 200][..], &[VERSION, 6, 1, 0], &[VERSION]] {
            let mut body = Vec::<u8, 16>::from_slice(content).unwrap();
            body.extend(CRC.checksum(content).to_le_bytes());
            let mut bytes = [0; 24];
            let length = cobs::encode(&body, &mut bytes);
            assert_eq!(decode_all(&bytes[..=length]).as_slice(), [Err(DecodeError::Content)]);
        }
    }
}
