//! Inputs as functions of time: they come into force at once, over a ramp, or change at given rates.

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

    /// Both parts in their order.
    #[must_use]
    pub fn segments(&self) -> [LinearInputs; 2] {
        [self.ramp, self.rest]
    }

    /// The segment in force from a time on, s.
    pub fn segment(&self, time: f64) -> LinearInputs {
        if time < self.ramp.until { self.ramp } else { self.rest }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A torque on the primary shaft alone, N·m.
    pub fn torque(value: f64) -> Inputs {
        let mut inputs = Inputs::ZERO;
        inputs.primary.torque = value;
        inputs
    }

    /// From 10 to 30 N·m within 10 ms from 2 s on: over a time, s, or from 30 N·m at a rate.
    pub fn profile(time: f64, rate: f64) -> InputProfile {
        InputProfile::new(time, [2.0, 2.01], &torque(10.0), &torque(30.0), &torque(rate))
    }

    #[test]
    fn an_input_jumps_ramps_or_follows_its_rate() {
        let at = |profile: &InputProfile, time: f64| profile.segment(time).at(time).primary.torque;
        let jump = profile(0.0, 0.0);
        assert_eq!((jump.ramp.until, at(&jump, 2.0)), (2.0, 30.0));
        let short = profile(4e-3, 0.0);
        assert_eq!(
            (short.ramp.until, at(&short, 2.0), at(&short, 2.004)),
            (2.004, 10.0, 30.0)
        );
        assert!((at(&short, 2.001) - 15.0).abs() < 1e-9);
        for whole in [-1.0, 0.5] {
            let whole = profile(whole, 0.0);
            assert!((whole.ramp.until - 2.01).abs() < 1e-12);
            assert!((whole.segment(2.0).at(2.01).primary.torque - 30.0).abs() < 1e-9);
        }
        let given = profile(4e-3, 100.0);
        assert_eq!((at(&given, 2.0), given.ramp.until), (30.0, 2.0));
        assert!((at(&given, 2.01) - 31.0).abs() < 1e-9);
    }

    #[test]
    fn inputs_that_change_count_at_once_and_the_others_go_on() {
        let mut given = torque(30.0);
        let profile = profile(4e-3, 0.0);
        given.secondary.torque = -7.0;
        for now in [2.001, 2.005] {
            let changed = profile.changed(now, &torque(30.0), &given);
            for time in [now, now + 1e-3, 2.01] {
                let [old, new] = [&profile, &changed].map(|profile| profile.segment(time).at(time));
                assert!((new.primary.torque - old.primary.torque).abs() < 1e-12, "{now}, {time}");
                assert_eq!(new.secondary.torque, -7.0, "{now}, {time}");
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
}
