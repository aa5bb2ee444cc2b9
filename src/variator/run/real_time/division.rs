//! Number of steps in a millisecond of real time: the more, the longer a run has been on time. Steps of 1 ms follow a ripple of 100 Hz
//! within some percent only, however well they are solved. A load that is hard to solve needs the work of a millisecond for one step.

use crate::solver::bounded::TICK;
use crate::tape::Tape;

/// Milliseconds (or shorter communication steps) on time before there are twice as many ticks: at first, and at most.
const WAIT: [u64; 2] = [10, 160];
/// Shortest tick, s.
const SHORTEST: f64 = TICK / 8.0;

/// A number of ticks that doubles after some time on time, and is one again once a run is late. If divided ticks were late, the next
/// time on time has to be twice as long: so that there are whole ticks where an engine fires each 14 ms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Division {
    ticks: f64,
    on_time: u64,
    wait: u64,
}

impl Default for Division {
    fn default() -> Self {
        Self {
            ticks: 1.0,
            on_time: 0,
            wait: WAIT[0],
        }
    }
}

impl Division {
    /// Calm ticks in a millisecond.
    pub fn ticks(self) -> f64 {
        self.ticks
    }

    /// Begins a millisecond, or a shorter stretch of so many seconds, on time or not. Each tick should get one Jacobian at least.
    pub fn follow(&mut self, is_on_time: bool, jacobians: usize, length: f64) {
        let [least, most] = WAIT;
        if is_on_time {
            self.on_time += 1;
            if self.on_time >= self.wait {
                if self.ticks > 1.0 {
                    self.wait = (self.wait / 2).max(least);
                }
                self.ticks *= 2.0;
                self.on_time = 0;
            }
        } else {
            if self.ticks > 1.0 {
                self.wait = (2 * self.wait).min(most);
            }
            self.ticks = 1.0;
            self.on_time = 0;
        }
        let most = (length / SHORTEST).round().min(jacobians as f64);
        self.ticks = self.ticks.min(most).max(1.0);
    }

    /// Writes to a tape, or reads from it.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.ticks);
        tape.counter(&mut self.on_time);
        tape.counter(&mut self.wait);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks after so many stretches with an effort of 4.
    fn after(division: &mut Division, is_on_time: bool, count: u64) -> f64 {
        for _ in 0..count {
            division.follow(is_on_time, 4, TICK);
        }
        division.ticks()
    }

    #[test]
    fn ticks_double_while_on_time_as_far_as_there_is_work() {
        let mut division = Division::default();
        let wait = WAIT[0];
        assert_eq!(after(&mut division, true, wait - 1), 1.0);
        assert_eq!(after(&mut division, true, 1), 2.0);
        assert_eq!(after(&mut division, true, wait), 4.0);
        assert_eq!(after(&mut division, true, 10 * wait), 4.0);
        for (jacobians, length, ticks) in [
            (3, TICK, 3.0),
            (1, TICK, 1.0),
            (4, 0.25 * TICK, 2.0),
            (4, 0.01 * TICK, 1.0),
        ] {
            let mut division = division;
            division.follow(true, jacobians, length);
            assert_eq!(division.ticks(), ticks, "{jacobians}, {length}");
        }
        for _ in 0..wait {
            division.follow(true, 16, TICK);
        }
        assert_eq!(division.ticks(), 8.0);
    }

    #[test]
    fn late_ticks_are_whole_and_the_next_wait_is_longer_if_they_were_divided() {
        let [least, most] = WAIT;
        let mut division = Division::default();
        let mut wait = least;
        for _ in 0..10 {
            assert_eq!(after(&mut division, true, wait - 1), 1.0);
            assert_eq!(after(&mut division, false, 3), 1.0, "late before it was divided");
            assert_eq!(after(&mut division, true, wait), 2.0);
            assert_eq!(after(&mut division, false, 3), 1.0, "late and divided");
            wait = (2 * wait).min(most);
        }
        assert_eq!(after(&mut division, true, most), 2.0);
        assert_eq!(
            after(&mut division, true, most),
            4.0,
            "on time and divided: the wait gets shorter again"
        );
        assert_eq!(after(&mut division, false, 1), 1.0);
        assert_eq!(after(&mut division, true, most - 1), 1.0);
        assert_eq!(after(&mut division, true, 1), 2.0);
    }
}
