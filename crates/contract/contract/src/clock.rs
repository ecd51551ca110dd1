// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU time of the whole process and wall clock over the same span, nanosecond counters.
//!
//! On a software driver the process clock contains the driver's worker threads, and a busy machine
//! does not move it: there it is the clock to compare by. Source: POSIX `CLOCK_PROCESS_CPUTIME_ID`.

use rustix::time::{ClockId, Timespec, clock_gettime};

/// Started when made.
#[derive(Debug, Clone, Copy)]
pub struct CpuStopwatch {
    cpu: Timespec,
    wall: Timespec,
}

impl CpuStopwatch {
    /// Starts now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            cpu: clock_gettime(ClockId::ProcessCPUTime),
            wall: clock_gettime(ClockId::Monotonic),
        }
    }

    /// Process CPU time since the start, milliseconds.
    #[must_use]
    pub fn cpu_ms(&self) -> f64 {
        elapsed_ms(self.cpu, clock_gettime(ClockId::ProcessCPUTime))
    }

    /// Wall clock since the start, milliseconds.
    #[must_use]
    pub fn wall_ms(&self) -> f64 {
        elapsed_ms(self.wall, clock_gettime(ClockId::Monotonic))
    }
}

fn elapsed_ms(from: Timespec, to: Timespec) -> f64 {
    (to.tv_sec - from.tv_sec) as f64 * 1e3 + (to.tv_nsec - from.tv_nsec) as f64 * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleeping_costs_wall_time_and_no_cpu_time() {
        let watch = CpuStopwatch::start();
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert!(watch.wall_ms() >= 50.0);
        assert!(watch.cpu_ms() < 25.0, "{}", watch.cpu_ms());
    }

    #[test]
    fn a_second_thread_counts() {
        let watch = CpuStopwatch::start();
        let spin = std::thread::spawn(|| {
            let own = CpuStopwatch::start();
            while own.cpu_ms() < 20.0 {
                std::hint::spin_loop();
            }
        });
        spin.join().expect("spins");
        assert!(watch.cpu_ms() >= 20.0);
    }
}
