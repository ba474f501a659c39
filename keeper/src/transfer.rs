//! The kept map fetched, stored and forgotten by somebody at the line.

use kept_map::{ReceiveError, Receiving, Record, Refused, SaveError, Saved};
use relocate::State;
use slam_core::RobotSlam;
use wire::{MapAnswer, MapRefusal, MapRequest, PIECE_BYTES, Piece};

use crate::{Circumstances, Keeper, MapFlash, slot};

/// A record whose next piece does not come for so many steps is dropped: two seconds.
const PATIENCE_STEPS: u8 = 50;

/// A record on its way into the store.
pub(crate) struct Incoming {
    receiving: Receiving,
    /// Steps since the last piece.
    steps: u8,
}

impl<F: MapFlash> Keeper<F> {
    /// Does what somebody wants with the kept map; none where the motors have to be held off first, or there is more to erase:
    /// the same request is to come with the next step then.
    #[inline(never)]
    pub fn ask(&mut self, slam: &mut RobotSlam, request: &MapRequest, now: Circumstances) -> Option<MapAnswer> {
        if let MapRequest::Get { offset } = request {
            return Some(self.part(*offset).unwrap_or(MapAnswer::Refused(MapRefusal::Nothing)));
        }
        if !now.stands || now.is_lifted {
            self.incoming = None;
            return Some(MapAnswer::Refused(MapRefusal::Driving));
        }
        if !now.is_off {
            return None;
        }
        match request {
            MapRequest::Put { offset, bytes } => Some(self.put(slam, *offset, bytes).unwrap_or_else(|why| {
                self.incoming = None;
                MapAnswer::Refused(why)
            })),
            MapRequest::Forget | MapRequest::Get { .. } => self.forget(slam),
        }
    }

    /// A step has passed; whether a record is on its way in, and the motors are to be held off. It is dropped when the robot is
    /// told to drive.
    pub(crate) fn receives(&mut self, now: Circumstances) -> bool {
        let incoming = self.incoming.as_mut().filter(|incoming| incoming.steps < PATIENCE_STEPS && now.stands);
        let Some(incoming) = incoming else {
            self.incoming = None;
            return false;
        };
        incoming.steps += 1;
        true
    }

    fn part(&mut self, offset: u32) -> Option<MapAnswer> {
        let bytes = slot(self.store.flash(), self.saved?)?;
        let of = 4 * Record::whole(bytes).ok()?.words();
        let from = offset as usize;
        let piece = bytes.get(from..of.min(from.saturating_add(PIECE_BYTES)))?;
        let bytes = Piece::from_slice(piece).ok().filter(|piece| !piece.is_empty())?;
        Some(MapAnswer::Part { offset, of: of as u32, bytes })
    }

    fn put(&mut self, slam: &mut RobotSlam, offset: u32, bytes: &Piece) -> Result<MapAnswer, MapRefusal> {
        if offset == 0 {
            let receiving = self.store.receive(self.rig).map_err(|_| MapRefusal::Flash)?;
            self.incoming = Some(Incoming { receiving, steps: 0 });
        }
        let Some(Incoming { receiving, steps }) = &mut self.incoming else {
            return Ok(MapAnswer::Awaiting { offset: 0 });
        };
        *steps = 0;
        let awaited = |receiving: &Receiving| 4 * receiving.words() as u32;
        if offset != awaited(receiving) || !bytes.len().is_multiple_of(4) {
            return Ok(MapAnswer::Awaiting { offset: awaited(receiving) });
        }
        for word in bytes.chunks_exact(4) {
            let word = <[u8; 4]>::try_from(word).map_or(0, u32::from_le_bytes);
            if receiving.is_unsealed() {
                return self.seal(slam, word);
            }
            self.store.take(receiving, word).map_err(|error| refusal(&error))?;
        }
        Ok(MapAnswer::Awaiting { offset: awaited(receiving) })
    }

    /// Keeps the record whose CRC this is, where the estimator has room for it, and begins to look for the robot in it.
    fn seal(&mut self, slam: &mut RobotSlam, crc: u32) -> Result<MapAnswer, MapRefusal> {
        let Some(Incoming { receiving, .. }) = self.incoming.take() else { return Err(MapRefusal::Damaged) };
        let place = Saved { slot: receiving.slot(), sequence: 0 };
        let record = slot(self.store.flash(), place).and_then(|bytes| Record::whole(bytes).ok());
        slam.suits(&record.ok_or(MapRefusal::Damaged)?).map_err(|_| MapRefusal::Unsuitable)?;
        let saved = self.store.seal(receiving, crc).map_err(|error| refusal(&error))?;
        self.saved = Some(saved);
        self.world = self.world.wrapping_add(1);
        self.lose(slam);
        Ok(MapAnswer::Kept { sequence: saved.sequence })
    }

    /// Erases one record; none where there may be more, each of which stops the processor for up to 0.8 s.
    fn forget(&mut self, slam: &mut RobotSlam) -> Option<MapAnswer> {
        self.incoming = None;
        match self.store.forget_oldest() {
            Err(_) => Some(MapAnswer::Refused(MapRefusal::Flash)),
            Ok(true) => None,
            Ok(false) => {
                self.saved = None;
                self.world = self.world.wrapping_add(1);
                // Where a lost robot's first drive started it does not know.
                if self.locator.state().is_located() {
                    slam.restart_map()
                } else {
                    slam.restart_elsewhere()
                }
                self.locator.restart(State::Tracking);
                self.unsaved_m = 0.0;
                self.restarts = slam.counters().restarts;
                Some(MapAnswer::Forgotten)
            }
        }
    }
}

fn refusal<E>(error: &ReceiveError<E>) -> MapRefusal {
    match error {
        ReceiveError::Refused(Refused::Foreign) => MapRefusal::Foreign,
        ReceiveError::Refused(Refused::Version(_)) => MapRefusal::Version,
        ReceiveError::Refused(Refused::Corrupt) => MapRefusal::Damaged,
        ReceiveError::Refused(Refused::OtherRig) => MapRefusal::OtherRig,
        ReceiveError::Save(SaveError::TooLong) => MapRefusal::Unsuitable,
        ReceiveError::Save(SaveError::Flash(_) | SaveError::Damaged) => MapRefusal::Flash,
    }
}
