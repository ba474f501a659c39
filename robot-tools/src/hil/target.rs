//! Where the firmware runs: in the emulator, reached by semihosting or by its serial line, or on a board at a port.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::port;

/// The emulated board: an STM32F405.
const MACHINE: &str = "olimex-stm32-h405";
/// An instruction takes 2^4 = 16 ns: at 168 MHz 2.7 cycles, where an update takes 1.9 by the core's documented timings.
const INSTRUCTION_TIME: &str = "shift=4,sleep=off";
/// The emulator gets this long to end by itself.
const GRACE: Duration = Duration::from_secs(5);

/// Where the firmware runs.
#[derive(Clone, Debug)]
pub enum Target {
    /// In qemu, linked by semihosting calls on two pipes: the fastest way.
    Emulator {
        /// The firmware's image, an ELF file.
        image: PathBuf,
    },
    /// The same with an instruction taking a fixed time of the processor's own clock, so that what is late shows.
    EmulatorTimed {
        /// The firmware's image, an ELF file.
        image: PathBuf,
    },
    /// In qemu, linked by the emulated serial line.
    EmulatorSerial {
        /// The firmware's image, an ELF file.
        image: PathBuf,
    },
    /// On a board.
    Port {
        /// The serial port, for instance `/dev/ttyUSB0`.
        device: String,
    },
}

/// What a target begins with.
#[derive(Clone, Debug, Default)]
pub struct Beginning {
    /// Whether it hands look backs over.
    pub hand_overs: bool,
    /// What its flash for maps has.
    pub flash: Vec<u8>,
    /// Words of the flash that are written before its power fails; none where that does not.
    pub power_words: Option<u32>,
}

impl Beginning {
    /// What the firmware reads on the emulator's command line.
    fn words(&self) -> String {
        let hand_overs = if self.hand_overs { "" } else { "no-hand-overs" };
        let power = self.power_words.map(|words| format!("power={words} ")).unwrap_or_default();
        format!("{power}{hand_overs}")
    }
}

/// Name of the file that the emulator's flash is kept in.
const FLASH: &str = "flash";

/// A running target.
pub struct Running {
    /// Bytes to the firmware; taken first when the target ends.
    pub to: Option<Box<dyn Write + Send>>,
    /// Bytes from the firmware; taken by whoever reads them.
    pub from: Option<Opener>,
    emulator: Option<Emulator>,
}

/// Opens the reading end, which may block until the emulator opens its own.
pub type Opener = Box<dyn FnOnce() -> std::io::Result<Box<dyn Read + Send>> + Send>;

struct Emulator {
    child: Child,
    dir: PathBuf,
}

impl Target {
    /// Starts it; an emulated one begins with this.
    ///
    /// # Errors
    /// What is missing, and what to do about it.
    pub fn start(&self, begin: &Beginning) -> Result<Running, String> {
        let pipes = ["to-robot", "from-robot"];
        match self {
            Self::Emulator { image } => emulate(image, pipes, begin, &["-serial", "null"]),
            Self::EmulatorTimed { image } => {
                emulate(image, pipes, begin, &["-serial", "null", "-icount", INSTRUCTION_TIME])
            }
            Self::EmulatorSerial { image } => {
                // The second serial line of the machine is USART2.
                let line = ["-chardev", "pipe,id=line,path=line", "-serial", "null", "-serial", "chardev:line"];
                emulate(image, ["line.in", "line.out"], begin, &line)
            }
            Self::Port { device } => open_port(device),
        }
    }
}

impl Running {
    /// Why the target ended, if it did.
    pub fn ended(&mut self) -> Option<String> {
        let status = self.emulator.as_mut()?.child.try_wait().ok()??;
        Some(format!("the emulator ended: {status}"))
    }

    /// What the emulator's flash for maps has now; none of a board's.
    pub fn flash(&self) -> Option<Vec<u8>> {
        std::fs::read(self.emulator.as_ref()?.dir.join(FLASH)).ok()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // The closed pipe tells the firmware to end.
        self.to = None;
        let Some(emulator) = &mut self.emulator else { return };
        let start = Instant::now();
        while start.elapsed() < GRACE && matches!(emulator.child.try_wait(), Ok(None)) {
            std::thread::sleep(Duration::from_millis(10));
        }
        // An emulator that has ended already cannot be killed, which is as well.
        let _ = emulator.child.kill();
        let _ = emulator.child.wait();
        let _ = std::fs::remove_dir_all(&emulator.dir);
    }
}

fn emulate(image: &Path, [to, from]: [&str; 2], begin: &Beginning, options: &[&str]) -> Result<Running, String> {
    let built = "`cargo xtask hil` builds it";
    let image = image.canonicalize().map_err(|error| format!("{}: {error}; {built}", image.display()))?;
    let dir = std::env::temp_dir().join(format!("wall-slam-hil-{}", std::process::id()));
    let failed = |error: std::io::Error| format!("{}: {error}", dir.display());
    std::fs::create_dir_all(&dir).map_err(failed)?;
    for name in [to, from] {
        let made = Command::new("mkfifo").arg(dir.join(name)).status();
        if !made.is_ok_and(|status| status.success()) {
            return Err(format!("`mkfifo {}` failed: the emulator is reached through pipes", dir.join(name).display()));
        }
    }
    std::fs::write(dir.join(FLASH), &begin.flash).map_err(failed)?;
    let mut qemu = Command::new("qemu-system-arm");
    qemu.current_dir(&dir).args(["-machine", MACHINE, "-display", "none", "-monitor", "none"]).args(options);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-append", &begin.words(), "-kernel"]).arg(&image);
    qemu.stdin(Stdio::null());
    let child = qemu.spawn().map_err(|error| format!("qemu-system-arm: {error}; `cargo xtask setup` installs it"))?;
    // Opened for reading too, so that opening does not wait for the emulator.
    let pipe = OpenOptions::new().read(true).write(true).open(dir.join(to)).map_err(failed)?;
    let from = dir.join(from);
    Ok(Running {
        to: Some(Box::new(pipe)),
        from: Some(Box::new(move || Ok(Box::new(File::open(from)?)))),
        emulator: Some(Emulator { child, dir }),
    })
}

fn open_port(device: &str) -> Result<Running, String> {
    let (from, to) = port::open(device)?;
    Ok(Running { to: Some(to), from: Some(Box::new(move || Ok(from))), emulator: None })
}
