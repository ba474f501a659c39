//! Prints what drives through the flat among people come to: `cargo run --release --package tests --example crowds -- 1 144`.

use tests::crowds::{Crowded, drive_through_crowd};

fn main() {
    let arguments: Vec<u64> = std::env::args().skip(1).map(|text| text.parse().expect("a seed is a number")).collect();
    let &[first, last] = &arguments[..] else { panic!("say which seeds: FIRST LAST, as in 1 144") };
    let drives: Vec<(u64, Crowded)> = (first..=last).map(|seed| (seed, drive_through_crowd(seed))).collect();
    let count = |is_so: fn(&Crowded) -> bool| drives.iter().filter(|(_, drive)| is_so(drive)).count();
    println!("drives: {}", drives.len());
    println!("lost their map among the people and found it: {}", count(Crowded::is_back));
    println!("took a displacement for real: {}", count(|drive| drive.jolts > 0));
    println!("over 15 cm off where it found itself: {}", count(|drive| drive.found_off_m() > 0.15));
    println!("over 15 cm off in the end: {}", count(|drive| drive.off_m > 0.15));
    for (seed, drive) in drives.iter().filter(|(_, drive)| drive.jolts > 0 || drive.off_m > 0.15 || !drive.is_back()) {
        println!("seed {seed}: {drive:.2?}");
    }
}
