//! Bytes read as numbers.

/// What is left of the bytes; past their end all is zero.
pub struct Source<'a>(&'a [u8]);

impl<'a> Source<'a> {
    /// All of the bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// True where nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// A whole number below `n`, at most 256.
    pub fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) * n / 256
    }

    /// True for so many of 256 bytes.
    pub fn chance(&mut self, of_256: u8) -> bool {
        self.byte() < of_256
    }

    /// 0 to 1, of two bytes.
    pub fn unit(&mut self) -> f64 {
        f64::from(u16::from_le_bytes([self.byte(), self.byte()])) / f64::from(u16::MAX)
    }

    /// A number between two.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A positive number between two, each decade as likely.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        (low.ln() + (high / low).ln() * self.unit()).exp()
    }

    /// Any bits at all, one time in four; otherwise one of the numbers that programs trip over.
    pub fn odd(&mut self) -> f32 {
        const ODD: [f32; 16] = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            1e-45,
            -0.0,
            0.0,
            -1.0,
            1e30,
            -1e20,
            1e6,
            3.0,
            0.155,
            1e-6,
        ];
        match self.below(64) {
            i @ 0..16 => ODD[i],
            16..48 => self.between(-4.0, 4.0) as f32,
            _ => f32::from_bits(u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])),
        }
    }
}
