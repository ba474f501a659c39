//! How long a computation takes, whatever else the machine does.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Processor time that this thread has used. Where the system does not say (it is Linux that does), the clock's.
pub fn processor_time() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let said = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = said.and_then(|said| said.split_whitespace().next()?.parse().ok());
    nanoseconds.map_or_else(|| START.elapsed(), Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_processor_time() {
        let (before, begun) = (processor_time(), Instant::now());
        // The system counts in ticks of some milliseconds.
        while processor_time() == before && begun.elapsed() < Duration::from_secs(10) {
            std::hint::black_box(std::hint::black_box(1.0_f64).sqrt());
        }
        assert!(processor_time() > before);
    }
}
