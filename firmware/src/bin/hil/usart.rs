//! The link through USART2 (PA2 out, PA3 in), 115200 baud, polled: in lock step nothing arrives while the robot thinks.

use stm32_metapac::{GPIOA, RCC, USART2, gpio, usart};

/// The clock after reset, which USART2 runs on.
const HSI_HZ: u32 = 16_000_000;
const BAUD: u32 = 115_200;
/// The pins' function that is USART2.
const ALTERNATE: u8 = 7;

/// The serial line.
pub struct Transport;

impl Transport {
    /// Sets up pins and line.
    pub fn open() -> Self {
        RCC.ahb1enr().modify(|enable| enable.set_gpioaen(true));
        RCC.apb1enr().modify(|enable| enable.set_usart2en(true));
        for pin in [2, 3] {
            GPIOA.afr(0).modify(|function| function.set_afr(pin, ALTERNATE));
            GPIOA.moder().modify(|mode| mode.set_moder(pin, gpio::vals::Moder::ALTERNATE));
        }
        USART2.brr().write_value(usart::regs::Brr((HSI_HZ + BAUD / 2) / BAUD));
        USART2.cr1().write(|control| {
            control.set_ue(true);
            control.set_te(true);
            control.set_re(true);
        });
        Self
    }

    /// Waits for the next byte.
    pub fn read(&mut self) -> u8 {
        while !USART2.sr().read().rxne() {}
        USART2.dr().read().dr() as u8
    }

    /// Sends bytes.
    pub fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            while !USART2.sr().read().txe() {}
            USART2.dr().write(|data| data.set_dr((*byte).into()));
        }
    }
}

/// Nobody says a word to a board before it starts.
pub fn command_line(_text: &mut [u8]) -> &[u8] {
    &[]
}
