//! Inputs as functions of time: over a communication step they come into force at once, over a ramp, or at given rates. In real time
//! they wait while a step stays open and the run is behind the clock; no impulse of them is lost.

use crate::archive::Archive;
use crate::variator::pulleys::loads::LinearInputs;
use crate::variator::settings::signals::Inputs;

/// Shortest time to advance by, s: rates over less are rounding errors.
pub(super) const SHORTEST_STEP: f64 = 1.0e-9;

/// Inputs over a communication step: a ramp, which may have no length, and what follows it.
#[derive(Clone, Copy, Debug)]
pub struct InputProfile {
    ramp: LinearInputs,
    rest: LinearInputs,
}

impl InputProfile {
    /// Inputs that stay as they are.
    pub fn constant(from: f64, inputs: &Inputs) -> Self {
        let rest = LinearInputs::constant(from, inputs);
        let ramp = LinearInputs { until: from, ..rest };
        Self { ramp, rest }
    }

    /// Inputs that go from `present` to those given over `time`, s: no longer than the step from `from` to `to`; a negative time
    /// stands for all of it. An input that has a rate starts at its value and changes at that rate.
    pub fn new(time: f64, [from, to]: [f64; 2], present: &Inputs, given: &Inputs, rates: &Inputs) -> Self {
        let step = to - from;
        let whole = time < 0.0 || time >= step - SHORTEST_STEP;
        let time = if whole { step } else { time };
        let rest = LinearInputs {
            rates: *rates,
            ..LinearInputs::constant(from, given)
        };
        let mut ramp = LinearInputs { until: from, ..rest };
        let slopes = ramp.inputs.each_mut().into_iter().zip(ramp.rates.each_mut());
        for ((start, rate), present) in slopes.zip(present.values()) {
            if *rate == 0.0 && time > 0.0 {
                *rate = (*start - present) / time;
                *start = present;
            }
        }
        if ramp.inputs == rest.inputs {
            return Self { ramp, rest };
        }
        ramp.until = if whole { to } else { from + time };
        let rest = LinearInputs {
            from: ramp.until,
            inputs: rest.at(ramp.until),
            ..rest
        };
        Self { ramp, rest }
    }

    /// The same from `now` on, s, but for the inputs that have changed from `before` to `given`: these have their new values at once, and no
    /// rate.
    pub fn changed(&self, now: f64, before: &Inputs, given: &Inputs) -> Self {
        let changed = |segment: &LinearInputs, from: f64| {
            let mut segment = LinearInputs {
                from,
                inputs: segment.inputs.after(from - segment.from, &segment.rates),
                ..*segment
            };
            let fields = segment.inputs.each_mut().into_iter().zip(segment.rates.each_mut());
            for ((value, rate), (before, given)) in fields.zip(before.values().into_iter().zip(given.values())) {
                if before != given {
                    (*value, *rate) = (given, 0.0);
                }
            }
            segment
        };
        Self {
            ramp: changed(&self.ramp, now),
            rest: changed(&self.rest, now.max(self.ramp.until)),
        }
    }

    /// The ramp and what follows it.
    pub fn segments(&self) -> [LinearInputs; 2] {
        [self.ramp, self.rest]
    }

    /// The segment in force from a time on, s.
    pub fn segment(&self, time: f64) -> LinearInputs {
        if time < self.ramp.until { self.ramp } else { self.rest }
    }
}

/// Most segments: 20 ms in communication steps of 1 ms, each a ramp and a rest. In shorter steps, inputs are replaced by their mean once
/// there are more.
const SEGMENTS: usize = 48;

/// Inputs between the time of the state and that of the clock: segments, the oldest first.
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
        let change = profile.segment(from).until.clamp(from, to);
        for [from, until] in [[from, change], [change, to]] {
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

    /// Writes to an archive, or reads from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let mut count = self.segments.len() as u64;
        archive.counter(&mut count);
        if count > SEGMENTS as u64 {
            archive.reject();
            return;
        }
        self.segments.resize(count as usize, LinearInputs::NONE);
        for segment in &mut self.segments {
            segment.serialize(archive);
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

    /// A torque on the primary shaft alone, N·m.
    fn torque(value: f64) -> Inputs {
        let mut inputs = Inputs::ZERO;
        inputs.primary.torque = value;
        inputs
    }

    /// From 10 to 30 N·m within 10 ms from 2 s on: over a time, s, or from 30 N·m at a rate.
    fn profile(time: f64, rate: f64) -> InputProfile {
        InputProfile::new(time, [2.0, 2.01], &torque(10.0), &torque(30.0), &torque(rate))
    }

    fn at(profile: &InputProfile, time: f64) -> f64 {
        profile.segment(time).at(time).primary.torque
    }

    fn mean(pending: &PendingInputs, span: [f64; 2]) -> f64 {
        pending.mean(span).primary.torque
    }

    /// Torques at the start, in the middle and at the end of the line over a time.
    fn line(pending: &PendingInputs, [from, to]: [f64; 2]) -> [f64; 3] {
        let line = pending.line([from, to]);
        [from, 0.5 * (from + to), to].map(|time| line.at(time).primary.torque)
    }

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

    /// Time of a ramp, s, and rate; end of the ramp, s; torques at the start and the end, and their mean, N·m.
    #[test]
    fn an_input_jumps_ramps_or_follows_its_rate() {
        for (time, rate, until, torques) in [
            (0.0, 0.0, 2.0, [30.0, 30.0, 30.0]),
            (4e-3, 0.0, 2.004, [10.0, 30.0, 26.0]),
            (-1.0, 0.0, 2.01, [10.0, 30.0, 20.0]),
            (0.5, 0.0, 2.01, [10.0, 30.0, 20.0]),
            (4e-3, 100.0, 2.0, [30.0, 31.0, 30.5]),
        ] {
            let profile = profile(time, rate);
            let mut pending = PendingInputs::new();
            pending.add(&profile, [2.0, 2.01]);
            assert!((profile.ramp.until - until).abs() < 1e-12, "{time}, {rate}");
            let found = [at(&profile, 2.0), at(&profile, 2.01), mean(&pending, [2.0, 2.01])];
            for (found, expected) in found.into_iter().zip(torques) {
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{time}, {rate}: {found}, not {expected}"
                );
            }
            for [from, to] in [[2.0, 2.001], [2.003, 2.006], [2.0, 2.01]] {
                let [start, middle, end] = line(&pending, [from, to]);
                let change = at(&profile, to) - at(&profile, from);
                assert!((end - start - change).abs() < 1e-9, "{time}, {rate}: {start} to {end}");
                assert!((middle - mean(&pending, [from, to])).abs() < 1e-9, "{time}, {rate}");
            }
        }
    }

    #[test]
    fn inputs_that_change_count_at_once_and_the_others_go_on() {
        let mut given = torque(30.0);
        let profile = profile(4e-3, 0.0);
        given.secondary.torque = -7.0;
        for now in [2.001, 2.005] {
            let changed = profile.changed(now, &torque(30.0), &given);
            for time in [now, now + 1e-3, 2.01] {
                assert!((at(&changed, time) - at(&profile, time)).abs() < 1e-12, "{now}, {time}");
                assert_eq!(changed.segment(time).at(time).secondary.torque, -7.0, "{now}, {time}");
            }
        }
    }

    #[test]
    fn a_force_that_falls_ends_at_zero() {
        let mut segment = LinearInputs::constant(0.0, &Inputs::ZERO);
        (
            segment.inputs.primary.clamping_force,
            segment.rates.primary.clamping_force,
        ) = (10.0, -100.0);
        assert_eq!(segment.at(1.0).primary.clamping_force, 0.0);
    }

    #[test]
    fn no_impulse_is_lost_until_the_run_has_caught_up() {
        let mut pending = pending(&[50.0, 50.0, -50.0]);
        let impulse = 37.5e-3 + 50e-3 - 25e-3;
        for (level_from, expected) in [(None, impulse), (Some(0.25e-3), impulse - 0.125e-3 * 25.0)] {
            if let Some(from) = level_from {
                pending.level(from);
            }
            let spans = [[0.0, 0.25e-3], [0.25e-3, 1.75e-3], [1.75e-3, 3e-3]];
            let found: f64 = spans
                .map(|span| (span[1] - span[0]) * line(&pending, span)[1])
                .iter()
                .sum();
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
        pending.forget(3e-3);
        assert!(pending.segments.is_empty());
    }

    #[test]
    fn a_line_reaches_over_several_profiles() {
        let pending = pending(&[50.0, -30.0]);
        for (span, change) in [
            ([0.25e-3, 1e-3], 25.0),
            ([0.75e-3, 1.25e-3], -40.0),
            ([0.0, 2e-3], -30.0),
        ] {
            let [start, middle, end] = line(&pending, span);
            assert!((middle - mean(&pending, span)).abs() < 1e-9);
            assert!((end - start - change).abs() < 1e-9, "{span:?}: {start} to {end}");
        }
    }

    #[test]
    fn it_never_holds_more_than_there_is_memory_for() {
        let mut pending = pending(&[10.0; 100]);
        assert!(pending.segments.len() <= SEGMENTS && pending.segments.capacity() == SEGMENTS);
        assert_eq!(pending.clone().segments.capacity(), SEGMENTS);
        for _ in 0..2 {
            assert!((mean(&pending, [0.0, 0.1]) - (10.0 - 2.5e-3 / 0.1)).abs() < 1e-9);
            pending.level(0.0);
        }
        assert_eq!(pending.segments.len(), 1);
    }

    #[test]
    fn more_segments_than_there_is_memory_for_are_not_read() {
        let bytes = [255; 8];
        let mut archive = Archive::reader(&bytes);
        PendingInputs::new().serialize(&mut archive);
        assert!(archive.finish().is_err());
    }
}
