//! The link through the emulator: two pipes and a file on the host, opened by semihosting.
#![allow(unsafe_code, reason = "calls the emulator with pointers")]

use cortex_m_semihosting::{debug, syscall};

/// Modes of SYS_OPEN, as of fopen: "rb", "r+b" and "wb".
const READ: usize = 1;
const UPDATE: usize = 3;
const WRITE: usize = 5;

/// The two pipes, in the folder that the emulator was started in.
pub struct Transport {
    from_host: usize,
    to_host: usize,
    bytes: [u8; 256],
    next: usize,
    end: usize,
}

impl Transport {
    /// Opens the pipes.
    pub fn open() -> Self {
        let from_host = open(b"to-robot\0", READ);
        let to_host = open(b"from-robot\0", WRITE);
        Self { from_host, to_host, bytes: [0; 256], next: 0, end: 0 }
    }

    /// The next byte; ends the program when the host has closed the pipe.
    pub fn read(&mut self) -> u8 {
        if self.next == self.end {
            let room = self.bytes.len();
            // SAFETY: the host writes at most `room` bytes into the buffer.
            let missing = unsafe { syscall!(READ, self.from_host, self.bytes.as_mut_ptr(), room) };
            self.next = 0;
            self.end = room.saturating_sub(missing);
            if self.end == 0 {
                exit(debug::EXIT_SUCCESS);
            }
        }
        let byte = self.bytes[self.next];
        self.next += 1;
        byte
    }

    /// Sends bytes; ends the program when the host does not take them.
    pub fn write(&mut self, bytes: &[u8]) {
        // SAFETY: the host only reads the bytes.
        let missing = unsafe { syscall!(WRITE, self.to_host, bytes.as_ptr(), bytes.len()) };
        if missing != 0 {
            exit(debug::EXIT_FAILURE);
        }
    }
}

/// A file in the folder that the emulator was started in.
pub struct HostFile(usize);

impl HostFile {
    /// Opens a file that is there; its name ends with a zero byte.
    pub fn open(name: &[u8]) -> Self {
        Self(open(name, UPDATE))
    }

    /// Reads bytes from this place of the file on; ends the program where there are fewer.
    ///
    /// # Safety
    /// There is memory for so many bytes, and nobody refers to it.
    pub unsafe fn read(&self, offset: usize, to: *mut u8, len: usize) {
        self.seek(offset);
        // SAFETY: the host writes at most `len` bytes, for which there is memory by the caller's word.
        let missing = unsafe { syscall!(READ, self.0, to, len) };
        if missing != 0 {
            exit(debug::EXIT_FAILURE);
        }
    }

    /// Writes bytes to this place of the file; ends the program where the host does not take them.
    pub fn write(&self, offset: usize, bytes: &[u8]) {
        self.seek(offset);
        // SAFETY: the host only reads the bytes.
        let missing = unsafe { syscall!(WRITE, self.0, bytes.as_ptr(), bytes.len()) };
        if missing != 0 {
            exit(debug::EXIT_FAILURE);
        }
    }

    fn seek(&self, offset: usize) {
        // SAFETY: no memory is touched.
        if unsafe { syscall!(SEEK, self.0, offset) } != 0 {
            exit(debug::EXIT_FAILURE);
        }
    }
}

/// The emulator's command line.
pub fn command_line(text: &mut [u8]) -> &[u8] {
    // SAFETY: the host writes at most as many bytes as there are, the last one a zero.
    let failed = unsafe { syscall!(GET_CMDLINE, text.as_mut_ptr(), text.len()) } != 0;
    let line = text.split(|byte| *byte == 0).next().unwrap_or_default();
    if failed { &[] } else { line }
}

/// Ends the program, as a power cut does.
pub fn end() -> ! {
    exit(debug::EXIT_SUCCESS)
}

fn open(name: &[u8], mode: usize) -> usize {
    // SAFETY: the host only reads the name, which ends with a zero byte.
    let handle = unsafe { syscall!(OPEN, name.as_ptr(), mode, name.len() - 1) };
    if handle == usize::MAX {
        exit(debug::EXIT_FAILURE);
    }
    handle
}

fn exit(status: debug::ExitStatus) -> ! {
    loop {
        debug::exit(status);
    }
}
