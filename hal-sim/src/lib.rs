//! A simulated robot board and home.
