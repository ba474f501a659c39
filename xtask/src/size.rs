//! Flash, RAM and stack of the robot's program, held against their budgets.

use crate::elf::{Elf, Symbol};
use crate::hil;
use crate::run::{Result, run};
use crate::thumb::{TARGET, Thumb};
use std::collections::BTreeMap;

/// Most flash of the shipped program, bytes.
const FLASH_BUDGET: u64 = 320 * 1024;
/// Most RAM: statics of the shipped program and the deepest stack of a drive in the loop, bytes.
const RAM_BUDGET: u64 = 176 * 1024;
/// Largest symbols that are printed.
const SYMBOLS: usize = 15;

/// What the program takes, bytes.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Flash of the shipped build.
    pub flash: u64,
    /// Variables of the shipped build.
    pub statics: u64,
    /// Deepest stack of a drive in the loop.
    pub stack: u64,
}

/// Prints the tables; fails over budget.
pub fn size() -> Result {
    let (sizes, shipped) = measure()?;
    // Nothing lies below this address: a stack that overflows faults.
    let guarded = shipped.find("_stack_end").is_some_and(|end| end.address == CCRAM_START);
    if !guarded {
        return Err("the stack does not end at the start of the core-coupled RAM: an overflow would corrupt".into());
    }
    print_crates(&shipped);
    print_largest(&shipped, "flash", |symbol| symbol.is_function);
    print_largest(&shipped, "static RAM", |symbol| !symbol.is_function && symbol.address >= CCRAM_START);
    let rows = sizes.rows();
    for (name, bytes, budget) in rows {
        let budget = budget.map(|budget| format!("budget {budget}")).unwrap_or_default();
        println!("{name:<24}{bytes:>10} bytes   {budget}");
    }
    let over = rows.into_iter().filter(|(_, bytes, budget)| budget.is_some_and(|budget| *bytes > budget));
    let over: Vec<String> = over.map(|(name, bytes, _)| format!("{name}: {bytes} bytes")).collect();
    if over.is_empty() { Ok(()) } else { Err(format!("over budget: {}", over.join("; "))) }
}

/// Builds the robot's program, with its back end at work whatever its sensors are, and drives its loop build.
pub fn measure() -> Result<(Sizes, Elf)> {
    let shipped = build()?;
    let stack = hil::deepest_stack()?;
    let sizes = Sizes { flash: shipped.flash_bytes(), statics: shipped.static_ram_bytes(), stack };
    Ok((sizes, shipped))
}

impl Sizes {
    /// Name, bytes and budget of each figure.
    pub fn rows(&self) -> [(&'static str, u64, Option<u64>); 4] {
        [
            ("flash", self.flash, Some(FLASH_BUDGET)),
            ("static RAM", self.statics, None),
            ("stack", self.stack, None),
            ("RAM with stack", self.statics + self.stack, Some(RAM_BUDGET)),
        ]
    }
}

/// Start of the STM32F405's core-coupled RAM; its other RAM lies above.
const CCRAM_START: u64 = 0x1000_0000;

/// What makes cargo build or run the program that the robot is shipped with.
const SHIPPED: [&str; 7] = ["--release", "--package", "firmware", "--bin", "robot", "--features", "board"];

/// Builds the robot's program and flashes it through a debug probe.
pub fn flash() -> Result {
    run(Thumb::require()?.cargo("firmware", "run").args(SHIPPED))
}

fn build() -> Result<Elf> {
    let thumb = Thumb::require()?;
    run(thumb.cargo("firmware", "build").args(SHIPPED))?;
    Elf::read(&thumb.target_dir().join(TARGET).join("release/robot"))
}

fn print_crates(elf: &Elf) {
    let mut crates: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    for symbol in elf.symbols() {
        let sizes = crates.entry(crate_of(&symbol.name)).or_default();
        sizes[usize::from(symbol.address >= CCRAM_START)] += symbol.size;
    }
    let mut rows: Vec<_> = crates.into_iter().filter(|(_, sizes)| sizes.iter().sum::<u64>() >= 256).collect();
    rows.sort_by_key(|(_, sizes)| std::cmp::Reverse(sizes[0] + sizes[1]));
    println!("{:<24}{:>10}{:>12}", "crate (symbols' sizes)", "flash", "static RAM");
    for (name, [flash, ram]) in rows {
        println!("{name:<24}{flash:>10}{ram:>12}");
    }
}

/// The crate that a symbol is named after. A generic function counts for the crate that wrote it.
fn crate_of(name: &str) -> String {
    let start = name.trim_start_matches(['<', '&', '(', '[', '*']);
    let word: String = start.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if start[word.len()..].starts_with("::") { word } else { "(assembly, C names)".to_owned() }
}

fn print_largest(elf: &Elf, what: &str, wanted: impl Fn(&Symbol) -> bool) {
    let mut symbols: Vec<&Symbol> = elf.symbols().iter().filter(|symbol| wanted(symbol)).collect();
    symbols.sort_by_key(|symbol| std::cmp::Reverse(symbol.size));
    println!("\nlargest in {what}");
    for symbol in symbols.into_iter().take(SYMBOLS) {
        let name: String = symbol.name.chars().take(90).collect();
        println!("{:>10}  {name}", symbol.size);
    }
    println!();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_belong_to_crates() {
        assert_eq!(crate_of("slam_core::slam::Slam<_>::step"), "slam_core");
        assert_eq!(crate_of("<core::fmt::Formatter>::pad"), "core");
        assert_eq!(crate_of("<&T as core::fmt::Debug>::fmt"), "(assembly, C names)");
        assert_eq!(crate_of("memcpy"), "(assembly, C names)");
    }
}
