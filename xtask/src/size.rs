//! Flash, RAM and stack of the robot's program, held against their budgets.

use crate::elf::{Elf, Symbol};
use crate::hil;
use crate::run::{Result, root, run};
use crate::thumb::{TARGET, Thumb};
use std::collections::BTreeMap;

/// Most flash of the shipped program, bytes.
const FLASH_BUDGET: u64 = 160 * 1024;
/// Most RAM: statics of the shipped program and the deepest stack of a drive in the loop, bytes.
const RAM_BUDGET: u64 = 64 * 1024;
/// Largest symbols that are printed.
const SYMBOLS: usize = 15;
/// Where a drive in the loop leaves its figures.
const DRIVE: &str = "target/hil/semihosting";

/// Prints the tables; fails over budget.
pub fn size() -> Result {
    let shipped = build()?;
    let stack = drive()?;
    let flash = shipped.flash_bytes();
    let statics = shipped.static_ram_bytes();
    print_crates(&shipped);
    print_largest(&shipped, "flash", |symbol| symbol.is_function);
    print_largest(&shipped, "static RAM", |symbol| !symbol.is_function && symbol.address >= RAM_START);
    println!("{:<24}{flash:>10} bytes   budget {FLASH_BUDGET}", "flash");
    println!("{:<24}{statics:>10} bytes", "static RAM");
    println!("{:<24}{stack:>10} bytes   the most in a three-minute drive of the loop build", "stack");
    println!("{:<24}{:>10} bytes   budget {RAM_BUDGET}", "RAM with stack", statics + stack);
    let mut over = Vec::new();
    if flash > FLASH_BUDGET {
        over.push(format!("flash: {flash} bytes, at most {FLASH_BUDGET}"));
    }
    if statics + stack > RAM_BUDGET {
        over.push(format!("RAM with stack: {} bytes, at most {RAM_BUDGET}", statics + stack));
    }
    if over.is_empty() { Ok(()) } else { Err(format!("over budget: {}", over.join("; "))) }
}

/// Start of the STM32F405's RAM.
const RAM_START: u64 = 0x2000_0000;

fn build() -> Result<Elf> {
    let thumb = Thumb::require()?;
    let mut build = thumb.cargo("firmware", "build");
    run(build.args(["--release", "--package", "firmware", "--bin", "robot", "--features", "board"]))?;
    Elf::read(&thumb.target_dir().join(TARGET).join("release/robot"))
}

/// The deepest stack of a drive in the loop, bytes.
fn drive() -> Result<u64> {
    hil::hil(&["--minutes", "3", "--out", DRIVE])?;
    let file = root().join(DRIVE).join("hil.json");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let value = text.lines().find_map(|line| line.trim().strip_prefix("\"stack_used_bytes\":"));
    let value = value.and_then(|value| value.trim().trim_end_matches(',').parse().ok());
    value.ok_or_else(|| format!("{}: no stack_used_bytes", file.display()))
}

fn print_crates(elf: &Elf) {
    let mut crates: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    for symbol in elf.symbols() {
        let sizes = crates.entry(crate_of(&symbol.name)).or_default();
        sizes[usize::from(symbol.address >= RAM_START)] += symbol.size;
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
