//! Inputs between the time of the state and that of the clock: a run is behind the clock while a step stays open. No impulse of them is
//! lost.

use crate::tape::Tape;
use crate::variator::pulleys::loads::LinearInputs;
use crate::variator::run::inputs::{InputProfile, SHORTEST_STEP};
use crate::variator::settings::signals::Inputs;

/// Most segments: 20 ms in communication steps of 1 ms, each a ramp and a rest. In shorter steps, inputs are replaced by their mean once
/// there are more.
const SEGMENTS: usize = 48;

/// Segments, the oldest first.
#[derive(Debug)]
pub(super) struct PendingInputs {
    segments: Vec<LinearInputs>,
}

impl Clone for PendingInputs {
    /// A copy has as much memory: it doesn't allocate in a step either.
    fn clone(&self) -> Self {
        let mut copy = Self::new();
        copy.segments.extend_from_slice(&self.segments);
        copy
    }
}

impl PendingInputs {
    pub fn new() -> Self {
        Self {
            segments: Vec::with_capacity(SEGMENTS),
        }
    }

    /// Adds the inputs of a profile between two times, s.
    pub fn add(&mut self, profile: &InputProfile, [from, to]: [f64; 2]) {
        let knee = profile.segment(from).until.clamp(from, to);
        for [from, until] in [[from, knee], [knee, to]] {
            if until - from > SHORTEST_STEP {
                if self.segments.len() == SEGMENTS {
                    self.level(self.segments[0].from);
                }
                let segment = profile.segment(from);
                let inputs = segment.at(from);
                self.segments.push(LinearInputs {
                    from,
                    until,
                    inputs,
                    ..segment
                });
            }
        }
    }

    /// Forgets what lies before a time, s.
    pub fn forget(&mut self, before: f64) {
        self.segments.retain(|segment| segment.until > before + SHORTEST_STEP);
    }

    /// Replaces the inputs from a time on, s, by their mean.
    pub fn level(&mut self, from: f64) {
        let Some(last) = self.segments.last() else { return };
        let until = last.until;
        if until - from > SHORTEST_STEP {
            let mean = LinearInputs::constant(from, &self.mean([from, until]));
            self.segments.clear();
            self.segments.push(LinearInputs { until, ..mean });
        }
    }

    /// Mean of the inputs from one time to another, s.
    pub fn mean(&self, span: [f64; 2]) -> Inputs {
        let length = span[1] - span[0];
        let mut mean = Inputs::ZERO;
        for segment in &self.segments {
            let [from, to] = part(segment, span);
            if to > from {
                mean = mean.after((to - from) / length, &segment.at(0.5 * (from + to)));
            }
        }
        mean
    }

    /// The straight line from the inputs at one time to those at another, s, moved so that its mean is theirs.
    pub fn line(&self, span: [f64; 2]) -> LinearInputs {
        let [from, to] = span;
        let length = to - from;
        let mean = self.mean(span);
        let within = |segment: &&LinearInputs| {
            let [from, to] = part(segment, span);
            to - from > SHORTEST_STEP
        };
        let ends = self
            .segments
            .iter()
            .find(within)
            .zip(self.segments.iter().rfind(within));
        let Some((first, last)) = ends else {
            return LinearInputs::constant(from, &mean);
        };
        let rates = Inputs::blend([(1.0 / length, last.at(to)), (-1.0 / length, first.at(from))]);
        LinearInputs {
            from,
            until: to,
            inputs: mean.after(-0.5 * length, &rates),
            rates,
        }
    }

    /// Writes to a tape, or reads from it.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        let mut count = self.segments.len() as u64;
        tape.counter(&mut count);
        if count > SEGMENTS as u64 {
            tape.reject();
            return;
        }
        self.segments.resize(count as usize, LinearInputs::NONE);
        for segment in &mut self.segments {
            segment.serialize(tape);
        }
    }
}

/// The part of a segment that lies between two times, s.
fn part(segment: &LinearInputs, [from, to]: [f64; 2]) -> [f64; 2] {
    [segment.from.max(from), segment.until.min(to)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variator::run::inputs::tests::{profile, torque};

    /// Inputs of 1 ms each: a ramp of 0.5 ms to a torque, N·m.
    fn pending(torques: &[f64]) -> PendingInputs {
        let mut pending = PendingInputs::new();
        let mut present = 0.0;
        for (k, &given) in torques.iter().enumerate() {
            let span = [k, k + 1].map(|k| 1e-3 * k as f64);
            let profile = InputProfile::new(0.5e-3, span, &torque(present), &torque(given), &Inputs::ZERO);
            pending.add(&profile, span);
            present = given;
        }
        pending
    }

    fn mean(pending: &PendingInputs, span: [f64; 2]) -> f64 {
        pending.mean(span).primary.torque
    }

    #[test]
    fn no_impulse_is_lost_until_the_run_has_caught_up() {
        let mut pending = pending(&[50.0, 50.0, -50.0]);
        let impulse = 3e-3 * mean(&pending, [0.0, 3e-3]);
        assert!((impulse - (37.5e-3 + 50e-3 - 25e-3)).abs() < 1e-12, "{impulse}");
        let ticks = [[0.0, 0.25e-3], [0.25e-3, 1.75e-3], [1.75e-3, 3e-3]];
        for level_from in [None, Some(0.25e-3)] {
            if let Some(from) = level_from {
                pending.level(from);
            }
            let impulse_of_lines: f64 = ticks
                .iter()
                .map(|&[from, to]| {
                    let line = pending.line([from, to]);
                    (to - from) * line.at(0.5 * (from + to)).primary.torque
                })
                .sum();
            let expected = impulse - level_from.map_or(0.0, |_| 0.5 * 0.25e-3 * 25.0);
            assert!(
                (impulse_of_lines - expected).abs() < 1e-12,
                "{impulse_of_lines}, not {expected}"
            );
        }
        pending.forget(3e-3);
        assert!(pending.segments.is_empty());
    }

    fn of_profile(time: f64, rate: f64) -> (InputProfile, PendingInputs) {
        let profile = profile(time, rate);
        let mut pending = PendingInputs::new();
        pending.add(&profile, [2.0, 2.01]);
        (profile, pending)
    }

    #[test]
    fn the_mean_is_that_of_a_jump_or_a_ramp() {
        for (time, expected) in [(0.0, 30.0), (4e-3, 26.0)] {
            let (_, pending) = of_profile(time, 0.0);
            assert!((mean(&pending, [2.0, 2.01]) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_line_has_the_mean_and_the_change_of_the_inputs() {
        for (time, rate) in [(0.0, 0.0), (4e-3, 0.0), (-1.0, 0.0), (4e-3, 100.0)] {
            let (profile, pending) = of_profile(time, rate);
            for [from, to] in [[2.0, 2.001], [2.003, 2.006], [2.0, 2.01]] {
                let [first, last] = [from, to].map(|time| profile.segment(time).at(time).primary.torque);
                let line = pending.line([from, to]);
                let [start, middle, end] = [from, 0.5 * (from + to), to].map(|time| line.at(time).primary.torque);
                assert!(
                    (end - start - (last - first)).abs() < 1e-9,
                    "{time}, {rate}: {start} to {end}"
                );
                let mean = mean(&pending, [from, to]);
                assert!((middle - mean).abs() < 1e-9, "{time}, {rate}: {middle}, not {mean}");
            }
        }
    }

    #[test]
    fn a_line_reaches_over_several_profiles() {
        let pending = pending(&[50.0, -30.0]);
        for (span, change) in [
            ([0.25e-3, 1e-3], 25.0),
            ([0.75e-3, 1.25e-3], -40.0),
            ([0.0, 2e-3], -30.0),
        ] {
            let line = pending.line(span);
            let [start, middle, end] = [span[0], 0.5 * (span[0] + span[1]), span[1]].map(|t| line.at(t).primary.torque);
            assert!((middle - mean(&pending, span)).abs() < 1e-9);
            assert!((end - start - change).abs() < 1e-9, "{span:?}: {start} to {end}");
        }
    }

    #[test]
    fn it_never_holds_more_than_there_is_memory_for() {
        let mut pending = pending(&[10.0; 100]);
        assert!(pending.segments.len() <= SEGMENTS);
        assert_eq!(pending.segments.capacity(), SEGMENTS);
        assert_eq!(pending.clone().segments.capacity(), SEGMENTS);
        assert!((mean(&pending, [0.0, 0.1]) - (10.0 - 2.5e-3 / 0.1)).abs() < 1e-9);
        pending.level(0.0);
        assert_eq!(pending.segments.len(), 1);
        assert!((mean(&pending, [0.05, 0.1]) - (10.0 - 2.5e-3 / 0.1)).abs() < 1e-9);
    }

    #[test]
    fn it_is_written_and_read() {
        let mut written = pending(&[10.0, 20.0]);
        let mut tape = Tape::writer();
        written.serialize(&mut tape);
        let bytes = tape.into_bytes();
        let mut read = PendingInputs::new();
        let mut tape = Tape::reader(&bytes);
        read.serialize(&mut tape);
        assert_eq!(tape.finish(), Ok(()));
        assert_eq!(format!("{read:?}"), format!("{written:?}"));
        let mut tape = Tape::reader(&[255; 8]);
        read.serialize(&mut tape);
        assert!(tape.finish().is_err());
    }
}
