//! How inputs that a master gives come into force: at once, over a ramp, or with the rates that it gives.

use crate::tape::Tape;
use crate::variator::settings::signals::Inputs;

/// Shortest time to advance by, s: rates over less are rounding errors.
pub(super) const SHORTEST_STEP: f64 = 1.0e-9;

/// Inputs from a point of time on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// Time from which they change, s.
    pub from: f64,
    /// Inputs then.
    pub inputs: Inputs,
    /// Their time derivatives.
    pub rates: Inputs,
}

impl Held {
    /// No inputs at all.
    pub const NONE: Self = Self {
        from: 0.0,
        inputs: Inputs::ZERO,
        rates: Inputs::ZERO,
    };

    /// Writes to a tape, or reads from it.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.from);
        for value in self.inputs.each_mut().into_iter().chain(self.rates.each_mut()) {
            tape.real(value);
        }
    }

    /// Inputs that do not change.
    pub fn constant(from: f64, inputs: &Inputs) -> Self {
        Self {
            from,
            inputs: *inputs,
            rates: Inputs::ZERO,
        }
    }

    /// Inputs at a time, s. A clamping force that falls ends at zero: sheaves are pushed, never pulled.
    pub fn at(&self, time: f64) -> Inputs {
        let mut inputs = self.inputs.after(time - self.from, &self.rates);
        for pulley in [&mut inputs.primary, &mut inputs.secondary] {
            pulley.clamping_force = pulley.clamping_force.max(0.0);
        }
        inputs
    }
}

/// Inputs over a communication step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    /// While inputs ramp.
    ramp: Held,
    /// Time at which the ramp ends, s; that of its start where there is none.
    knee: f64,
    /// From then on.
    rest: Held,
}

impl Course {
    /// Inputs that go from `present` to those given over `time`, s: no longer than the step from `from` to `to`; a negative time
    /// stands for all of it. An input that has a rate starts at its value and changes at that rate.
    pub fn new(time: f64, [from, to]: [f64; 2], present: &Inputs, given: &Inputs, rates: &Inputs) -> Self {
        let step = to - from;
        let whole = time < 0.0 || time >= step - SHORTEST_STEP;
        let time = if whole { step } else { time };
        let rest = Held {
            from,
            inputs: *given,
            rates: *rates,
        };
        let mut ramp = rest;
        let slopes = ramp.inputs.each_mut().into_iter().zip(ramp.rates.each_mut());
        for ((start, rate), present) in slopes.zip(present.values()) {
            if *rate == 0.0 && time > 0.0 {
                *rate = (*start - present) / time;
                *start = present;
            }
        }
        if ramp.inputs == rest.inputs {
            return Self { ramp, knee: from, rest };
        }
        let knee = if whole { to } else { from + time };
        Self {
            ramp,
            knee,
            rest: Held {
                from: knee,
                inputs: rest.at(knee),
                ..rest
            },
        }
    }

    /// The same from `now` on, s, but for the inputs that were given anew: these have the values `given` at once and keep them.
    /// `before` is what was given until now.
    pub fn given_anew(&self, now: f64, before: &Inputs, given: &Inputs) -> Self {
        let anew = |held: &Held, from: f64| {
            let mut held = Held {
                from,
                inputs: held.inputs.after(from - held.from, &held.rates),
                rates: held.rates,
            };
            let fields = held.inputs.each_mut().into_iter().zip(held.rates.each_mut());
            for ((value, rate), (before, given)) in fields.zip(before.values().into_iter().zip(given.values())) {
                if before != given {
                    (*value, *rate) = (given, 0.0);
                }
            }
            held
        };
        Self {
            ramp: anew(&self.ramp, now),
            knee: self.knee,
            rest: anew(&self.rest, now.max(self.knee)),
        }
    }

    /// The inputs in force from a time on, s.
    pub fn held(&self, time: f64) -> Held {
        if time < self.knee { self.ramp } else { self.rest }
    }

    /// Until when they change alike, s.
    pub fn until(&self, time: f64) -> f64 {
        if time < self.knee { self.knee } else { f64::INFINITY }
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
    pub fn course(time: f64, rate: f64) -> Course {
        Course::new(time, [2.0, 2.01], &torque(10.0), &torque(30.0), &torque(rate))
    }

    #[test]
    fn an_input_jumps_ramps_or_follows_its_rate() {
        let at = |course: &Course, time: f64| course.held(time).at(time).primary.torque;
        let jump = course(0.0, 0.0);
        assert_eq!((jump.knee, at(&jump, 2.0)), (2.0, 30.0));
        let short = course(4e-3, 0.0);
        assert_eq!((short.knee, at(&short, 2.0), at(&short, 2.004)), (2.004, 10.0, 30.0));
        assert!((at(&short, 2.001) - 15.0).abs() < 1e-9);
        for whole in [-1.0, 0.5] {
            let whole = course(whole, 0.0);
            assert!((whole.knee - 2.01).abs() < 1e-12);
            assert!((whole.held(2.0).at(2.01).primary.torque - 30.0).abs() < 1e-9);
        }
        let given = course(4e-3, 100.0);
        assert_eq!((at(&given, 2.0), given.knee), (30.0, 2.0));
        assert!((at(&given, 2.01) - 31.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_given_anew_counts_at_once_and_the_rest_goes_on() {
        let mut given = torque(30.0);
        let course = course(4e-3, 0.0);
        given.secondary.torque = -7.0;
        for now in [2.001, 2.005] {
            let anew = course.given_anew(now, &torque(30.0), &given);
            for time in [now, now + 1e-3, 2.01] {
                let [old, new] = [&course, &anew].map(|course| course.held(time).at(time));
                assert!((new.primary.torque - old.primary.torque).abs() < 1e-12, "{now}, {time}");
                assert_eq!(new.secondary.torque, -7.0, "{now}, {time}");
            }
        }
    }

    #[test]
    fn a_force_that_falls_ends_at_zero() {
        let mut held = Held::constant(0.0, &Inputs::ZERO);
        (held.inputs.primary.clamping_force, held.rates.primary.clamping_force) = (10.0, -100.0);
        assert_eq!(held.at(1.0).primary.clamping_force, 0.0);
    }
}
