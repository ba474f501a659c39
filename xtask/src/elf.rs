//! A linked program: its functions, and who calls whom.

use crate::run::Result;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::path::{Path, PathBuf};

/// A function or a variable of the program.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Readable name.
    pub name: String,
    /// Where it lies; functions without the Thumb bit.
    pub address: u64,
    /// Bytes.
    pub size: u64,
    /// Whether it is code.
    pub is_function: bool,
}

/// A linked program.
pub struct Elf {
    path: PathBuf,
    symbols: Vec<Symbol>,
    text: Vec<(u64, Vec<u8>)>,
    flash_bytes: u64,
    static_ram_bytes: u64,
}

/// A call or jump from one function to another.
#[derive(Clone, Debug)]
pub struct Call {
    /// Where it is.
    pub at: u64,
    /// Where it goes.
    pub to: u64,
}

impl Elf {
    /// Reads a program for the robot's processor.
    pub fn read(path: &Path) -> Result<Self> {
        let bad = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let bytes = std::fs::read(path).map_err(|error| bad(&error))?;
        let file = object::File::parse(bytes.as_slice()).map_err(|error| bad(&error))?;
        let mut symbols: Vec<Symbol> = file.symbols().filter(|symbol| !symbol.is_undefined()).map(symbol).collect();
        symbols.sort_by_key(|symbol| symbol.address);
        let text = file.sections().filter(|section| section.kind() == object::SectionKind::Text);
        let text = text.map(|section| Ok((section.address(), section.data().map_err(|error| bad(&error))?.to_vec())));
        let text = text.collect::<Result<_>>()?;
        let (mut flash_bytes, mut static_ram_bytes) = (0, 0);
        for section in file.sections().filter(|section| section.address() >= FLASH_START) {
            let in_ram = section.address() >= CCRAM_START;
            // Initial values of variables lie in flash, too.
            flash_bytes += if in_ram && !is_loaded(&section) { 0 } else { section.size() };
            static_ram_bytes += if in_ram { section.size() } else { 0 };
        }
        Ok(Self { path: path.to_owned(), symbols, text, flash_bytes, static_ram_bytes })
    }

    /// Flash that the program takes.
    pub fn flash_bytes(&self) -> u64 {
        self.flash_bytes
    }

    /// RAM of its variables.
    pub fn static_ram_bytes(&self) -> u64 {
        self.static_ram_bytes
    }

    /// All symbols, by address.
    pub fn symbols(&self) -> &[Symbol] {
        &self.symbols
    }

    /// The symbol with this name.
    pub fn find(&self, name: &str) -> Option<&Symbol> {
        self.symbols.iter().find(|symbol| symbol.name == name)
    }

    /// The function that contains this address.
    pub fn function_at(&self, address: u64) -> Option<&Symbol> {
        let inside = |symbol: &&Symbol| (symbol.address..symbol.address + symbol.size.max(1)).contains(&address);
        self.symbols.iter().filter(|symbol| symbol.is_function).find(inside)
    }

    /// Every direct call and long jump in the program.
    pub fn calls(&self) -> Vec<Call> {
        let mut calls = Vec::new();
        for function in self.symbols.iter().filter(|symbol| symbol.is_function) {
            let mut at = function.address;
            while at < function.address + function.size {
                let Some(first) = self.halfword(at) else { break };
                // Instructions of 32 bits start with 0b11101, 0b11110 or 0b11111.
                let wide = first >= 0xe800;
                if let (true, Some(second)) = (wide, self.halfword(at + 2)) {
                    calls.extend(branch_target(at, first, second).map(|to| Call { at, to }));
                }
                at += if wide { 4 } else { 2 };
            }
        }
        calls
    }

    /// Source lines of an address, the innermost inlined function first.
    pub fn lines(&self, address: u64) -> Result<Vec<String>> {
        let bad = |error: &dyn std::fmt::Display| format!("{}: {error}", self.path.display());
        let loader = addr2line::Loader::new(&self.path).map_err(|error| bad(&error))?;
        let mut frames = loader.find_frames(address).map_err(|error| bad(&error))?;
        let mut lines = Vec::new();
        while let Some(frame) = frames.next().map_err(|error| bad(&error))? {
            if let Some(location) = frame.location {
                lines.push(format!("{}:{}", location.file.unwrap_or("?"), location.line.unwrap_or(0)));
            }
        }
        Ok(lines)
    }

    fn halfword(&self, address: u64) -> Option<u16> {
        self.text.iter().find_map(|(start, bytes)| {
            let at = usize::try_from(address.checked_sub(*start)?).ok()?;
            Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]))
        })
    }
}

/// Start of the STM32F405's RAM: the core-coupled one, then the other.
const CCRAM_START: u64 = 0x1000_0000;

/// Start of its flash; what the debugger reads lies below, at 0.
const FLASH_START: u64 = 0x0800_0000;

/// Whether it has content in the file; what is zero at the start has none.
fn is_loaded(section: &object::Section<'_, '_>) -> bool {
    section.file_range().is_some_and(|(_, size)| size > 0)
}

fn symbol(symbol: object::Symbol<'_, '_>) -> Symbol {
    let is_function = symbol.kind() == SymbolKind::Text;
    let name = symbol.name().unwrap_or_default();
    Symbol {
        name: format!("{:#}", rustc_demangle::demangle(name)),
        address: if is_function { symbol.address() & !1 } else { symbol.address() },
        size: symbol.size(),
        is_function,
    }
}

/// Where a 32-bit BL or B goes; none for other instructions (ARMv7-M Architecture Reference Manual, A7.7.12, A7.7.18).
fn branch_target(at: u64, first: u16, second: u16) -> Option<u64> {
    let link = second & 0xd000 == 0xd000;
    let jump = second & 0xd000 == 0x9000;
    if first & 0xf800 != 0xf000 || !(link || jump) {
        return None;
    }
    let (first, second) = (u32::from(first), u32::from(second));
    let sign = first >> 10 & 1;
    let i1 = !((second >> 13) ^ sign) & 1;
    let i2 = !((second >> 11) ^ sign) & 1;
    let bits = sign << 24 | i1 << 23 | i2 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    let offset = i64::from((bits << 7).cast_signed() >> 7);
    at.checked_add(4)?.checked_add_signed(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_calls() {
        // As an assembler encodes them: bl .+4, bl .-4, b.w .+0x1000.
        assert_eq!(branch_target(0x100, 0xf000, 0xf800), Some(0x104));
        assert_eq!(branch_target(0x100, 0xf7ff, 0xfffe), Some(0x100));
        assert_eq!(branch_target(0x100, 0xf000, 0xbffe), Some(0x1100));
        assert_eq!(branch_target(0x100, 0xee30, 0x0a00), None, "a floating-point addition");
    }
}
