//! How inputs that a master gives come into force: at once, over a ramp, or with the rates that it gives.

use crate::variator::settings::signals::{Inputs, PulleyInputs};

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
        let after = time - self.from;
        let mut inputs = each(&self.inputs, &self.rates, |value, rate| value + after * rate);
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
    /// Time at which the ramp ends, s.
    pub knee: f64,
    /// From then on.
    rest: Held,
}

impl Course {
    /// Inputs that go from `present` to those given over `time`, s: no longer than the step from `from` to `to`; a negative time
    /// stands for all of it. An input that has a rate starts at its value and changes at that rate.
    pub fn new(time: f64, [from, to]: [f64; 2], present: &Inputs, given: &Inputs, rates: &Inputs) -> Self {
        let step = to - from;
        let time = if time < 0.0 { step } else { time.min(step) };
        let rest = Held {
            from,
            inputs: *given,
            rates: *rates,
        };
        let start = each3(
            present,
            given,
            rates,
            |present, given, rate| if rate == 0.0 { present } else { given },
        );
        if time <= 0.0 || start == *given {
            return Self {
                ramp: rest,
                knee: from,
                rest,
            };
        }
        let ramp = Held {
            from,
            inputs: start,
            rates: each3(&start, given, rates, |start, given, rate| {
                if rate == 0.0 { (given - start) / time } else { rate }
            }),
        };
        let knee = from + time;
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

    /// The inputs in force from a time on, s, until the knee or the end.
    pub fn held(&self, time: f64) -> Held {
        if time < self.knee { self.ramp } else { self.rest }
    }
}

/// A function of each value of two sets of inputs.
fn each(a: &Inputs, b: &Inputs, f: impl Fn(f64, f64) -> f64) -> Inputs {
    each3(a, b, b, |a, b, _| f(a, b))
}

/// A function of each value of three sets of inputs.
fn each3(a: &Inputs, b: &Inputs, c: &Inputs, f: impl Fn(f64, f64, f64) -> f64) -> Inputs {
    let of = |a: &PulleyInputs, b: &PulleyInputs, c: &PulleyInputs| PulleyInputs {
        torque: f(a.torque, b.torque, c.torque),
        clamping_force: f(a.clamping_force, b.clamping_force, c.clamping_force),
        speed_setpoint: f(a.speed_setpoint, b.speed_setpoint, c.speed_setpoint),
    };
    Inputs {
        primary: of(&a.primary, &b.primary, &c.primary),
        secondary: of(&a.secondary, &b.secondary, &c.secondary),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn torque(value: f64) -> Inputs {
        let mut inputs = Inputs::ZERO;
        inputs.primary.torque = value;
        inputs
    }

    fn course(time: f64, rate: f64) -> Course {
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
    fn a_force_that_falls_ends_at_zero() {
        let mut held = Held::constant(0.0, &Inputs::ZERO);
        (held.inputs.primary.clamping_force, held.rates.primary.clamping_force) = (10.0, -100.0);
        assert_eq!(held.at(1.0).primary.clamping_force, 0.0);
    }
}
