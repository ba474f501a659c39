//! What a small robot is, for firmware and simulator alike.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
