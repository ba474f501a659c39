//! Nothing of its own: `cargo bench --package bench` runs `benches/update.rs`.

#![forbid(unsafe_code)]
