//! One exchange with the host for every moment of the clock.

use crate::transport::Transport;
use crate::{SHARED, devices};
use wire::{Decoder, Frame, Motors, encode};

/// The link to the host.
pub struct Link {
    transport: Transport,
    decoder: Decoder,
    /// The moment of the last sample, microseconds.
    at_us: u64,
}

impl Link {
    /// A link that nothing has been said on.
    pub fn new(transport: Transport) -> Self {
        Self { transport, decoder: Decoder::new(), at_us: 0 }
    }

    /// Says what the tasks said and what the motors are given, then waits for the next moment: microseconds since the start.
    pub fn exchange(&mut self) -> u64 {
        devices::hand_on_said(|said| self.transport.write(said));
        let duty = devices::duty();
        self.send(&Frame::Motors(Motors { time_us: self.at_us, left: duty.left, right: duty.right }));
        loop {
            let byte = self.transport.read();
            match self.decoder.push(byte) {
                None => {}
                Some(Ok(Frame::Sample(sample))) => {
                    devices::set_inputs(&sample);
                    self.at_us = sample.time_us;
                    return self.at_us;
                }
                Some(Ok(frame @ (Frame::Command(_) | Frame::MapRequest(_)))) => {
                    if let Ok(bytes) = encode(&frame) {
                        devices::hear(&bytes);
                    }
                }
                Some(_) => SHARED.faults.count(|faults| &mut faults.bytes_lost),
            }
        }
    }

    fn send(&mut self, frame: &Frame) {
        if let Ok(bytes) = encode(frame) {
            self.transport.write(&bytes);
        }
    }
}
