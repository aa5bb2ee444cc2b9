//! Inputs that a run in real time has not lived through yet: while a tick stays open, or after one that was not taken, it is behind
//! the clock. Nothing of them is lost on the way, and no impulse.

use crate::tape::Tape;
use crate::variator::run::course::{Course, Held, SHORTEST_STEP};
use crate::variator::settings::signals::Inputs;

/// So many pieces there is memory for: 20 ms in communication steps of 1 ms, each a ramp and a rest. In shorter steps, inputs are held
/// at their mean once there are more.
const PIECES: usize = 48;

/// Inputs along a line until a time, s.
#[derive(Clone, Copy, Debug)]
struct Piece {
    held: Held,
    until: f64,
}

impl Piece {
    /// The part of it that lies between two times, s.
    fn part(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        [self.held.from.max(from), self.until.min(to)]
    }
}

/// Inputs piece by piece, the oldest first.
#[derive(Debug)]
pub(super) struct Backlog {
    pieces: Vec<Piece>,
}

impl Clone for Backlog {
    /// A copy has as much memory: it doesn't allocate in a step either.
    fn clone(&self) -> Self {
        let mut copy = Self::new();
        copy.pieces.extend_from_slice(&self.pieces);
        copy
    }
}

impl Backlog {
    pub fn new() -> Self {
        Self {
            pieces: Vec::with_capacity(PIECES),
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.pieces.clear();
    }

    /// Adds the inputs of a course between two times, s.
    pub fn add(&mut self, course: &Course, [from, to]: [f64; 2]) {
        let knee = course.until(from).clamp(from, to);
        for [from, until] in [[from, knee], [knee, to]] {
            if until - from > SHORTEST_STEP {
                if self.pieces.len() == PIECES {
                    self.level(self.pieces[0].held.from);
                }
                let held = course.held(from);
                let inputs = held.at(from);
                self.pieces.push(Piece {
                    held: Held { from, inputs, ..held },
                    until,
                });
            }
        }
    }

    /// Forgets what lies before a time, s.
    pub fn forget(&mut self, before: f64) {
        self.pieces.retain(|piece| piece.until > before + SHORTEST_STEP);
    }

    /// Holds the inputs from a time on, s, at their mean.
    pub fn level(&mut self, from: f64) {
        let Some(last) = self.pieces.last() else { return };
        let until = last.until;
        if until - from > SHORTEST_STEP {
            let held = Held::constant(from, &self.mean([from, until]));
            self.clear();
            self.pieces.push(Piece { held, until });
        }
    }

    /// Mean of the inputs from one time to another, s.
    pub fn mean(&self, span: [f64; 2]) -> Inputs {
        let length = span[1] - span[0];
        let mut mean = Inputs::ZERO;
        for piece in &self.pieces {
            let [from, to] = piece.part(span);
            if to > from {
                mean = mean.after((to - from) / length, &piece.held.at(0.5 * (from + to)));
            }
        }
        mean
    }

    /// The straight line from the inputs at one time to those at another, s, moved so that its mean is theirs.
    pub fn line(&self, span: [f64; 2]) -> Held {
        let [from, to] = span;
        let length = to - from;
        let mean = self.mean(span);
        let within = |piece: &&Piece| {
            let [from, to] = piece.part(span);
            to - from > SHORTEST_STEP
        };
        let ends = self.pieces.iter().find(within).zip(self.pieces.iter().rfind(within));
        let Some((first, last)) = ends else {
            return Held::constant(from, &mean);
        };
        let rates = Inputs::blend([(1.0 / length, last.held.at(to)), (-1.0 / length, first.held.at(from))]);
        Held {
            from,
            inputs: mean.after(-0.5 * length, &rates),
            rates,
        }
    }

    /// Writes to a tape, or reads from it.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        let mut count = self.pieces.len() as u64;
        tape.counter(&mut count);
        if count > PIECES as u64 {
            tape.reject();
            return;
        }
        let none = Piece {
            held: Held::NONE,
            until: 0.0,
        };
        self.pieces.resize(count as usize, none);
        for piece in &mut self.pieces {
            piece.held.serialize(tape);
            tape.real(&mut piece.until);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variator::run::course::tests::{course, torque};

    /// Inputs of 1 ms each: a ramp of 0.5 ms to a torque, N·m.
    fn backlog(torques: &[f64]) -> Backlog {
        let mut backlog = Backlog::new();
        let mut present = 0.0;
        for (k, &given) in torques.iter().enumerate() {
            let span = [k, k + 1].map(|k| 1e-3 * k as f64);
            let course = Course::new(0.5e-3, span, &torque(present), &torque(given), &Inputs::ZERO);
            backlog.add(&course, span);
            present = given;
        }
        backlog
    }

    fn mean(backlog: &Backlog, span: [f64; 2]) -> f64 {
        backlog.mean(span).primary.torque
    }

    #[test]
    fn no_impulse_is_lost_until_the_run_has_caught_up() {
        let mut backlog = backlog(&[50.0, 50.0, -50.0]);
        let impulse = 3e-3 * mean(&backlog, [0.0, 3e-3]);
        assert!((impulse - (37.5e-3 + 50e-3 - 25e-3)).abs() < 1e-12, "{impulse}");
        let ticks = [[0.0, 0.25e-3], [0.25e-3, 1.75e-3], [1.75e-3, 3e-3]];
        for level_from in [None, Some(0.25e-3)] {
            if let Some(from) = level_from {
                backlog.level(from);
            }
            let lived: f64 = ticks
                .iter()
                .map(|&[from, to]| {
                    let line = backlog.line([from, to]);
                    (to - from) * line.at(0.5 * (from + to)).primary.torque
                })
                .sum();
            let expected = impulse - level_from.map_or(0.0, |_| 0.5 * 0.25e-3 * 25.0);
            assert!((lived - expected).abs() < 1e-12, "{lived}, not {expected}");
        }
        backlog.forget(3e-3);
        assert!(backlog.pieces.is_empty());
    }

    fn of_course(time: f64, rate: f64) -> (Course, Backlog) {
        let course = course(time, rate);
        let mut backlog = Backlog::new();
        backlog.add(&course, [2.0, 2.01]);
        (course, backlog)
    }

    #[test]
    fn the_mean_is_that_of_a_jump_or_a_ramp() {
        for (time, expected) in [(0.0, 30.0), (4e-3, 26.0)] {
            let (_, backlog) = of_course(time, 0.0);
            assert!((mean(&backlog, [2.0, 2.01]) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_line_has_the_mean_and_the_change_of_the_inputs() {
        for (time, rate) in [(0.0, 0.0), (4e-3, 0.0), (-1.0, 0.0), (4e-3, 100.0)] {
            let (course, backlog) = of_course(time, rate);
            for [from, to] in [[2.0, 2.001], [2.003, 2.006], [2.0, 2.01]] {
                let [first, last] = [from, to].map(|time| course.held(time).at(time).primary.torque);
                let line = backlog.line([from, to]);
                let [start, middle, end] = [from, 0.5 * (from + to), to].map(|time| line.at(time).primary.torque);
                assert!(
                    (end - start - (last - first)).abs() < 1e-9,
                    "{time}, {rate}: {start} to {end}"
                );
                let mean = mean(&backlog, [from, to]);
                assert!((middle - mean).abs() < 1e-9, "{time}, {rate}: {middle}, not {mean}");
            }
        }
    }

    #[test]
    fn a_line_reaches_over_several_courses() {
        let backlog = backlog(&[50.0, -30.0]);
        for (span, change) in [
            ([0.25e-3, 1e-3], 25.0),
            ([0.75e-3, 1.25e-3], -40.0),
            ([0.0, 2e-3], -30.0),
        ] {
            let line = backlog.line(span);
            let [start, middle, end] = [span[0], 0.5 * (span[0] + span[1]), span[1]].map(|t| line.at(t).primary.torque);
            assert!((middle - mean(&backlog, span)).abs() < 1e-9);
            assert!((end - start - change).abs() < 1e-9, "{span:?}: {start} to {end}");
        }
    }

    #[test]
    fn it_never_holds_more_than_there_is_memory_for() {
        let mut backlog = backlog(&[10.0; 100]);
        assert!(backlog.pieces.len() <= PIECES);
        assert_eq!(backlog.pieces.capacity(), PIECES);
        assert_eq!(backlog.clone().pieces.capacity(), PIECES);
        assert!((mean(&backlog, [0.0, 0.1]) - (10.0 - 2.5e-3 / 0.1)).abs() < 1e-9);
        backlog.level(0.0);
        assert_eq!(backlog.pieces.len(), 1);
        assert!((mean(&backlog, [0.05, 0.1]) - (10.0 - 2.5e-3 / 0.1)).abs() < 1e-9);
    }

    #[test]
    fn it_is_written_and_read() {
        let mut written = backlog(&[10.0, 20.0]);
        let mut tape = Tape::writer();
        written.serialize(&mut tape);
        let bytes = tape.into_bytes();
        let mut read = Backlog::new();
        let mut tape = Tape::reader(&bytes);
        read.serialize(&mut tape);
        assert_eq!(tape.finish(), Ok(()));
        assert_eq!(format!("{read:?}"), format!("{written:?}"));
        let mut tape = Tape::reader(&[255; 8]);
        read.serialize(&mut tape);
        assert!(tape.finish().is_err());
    }
}
