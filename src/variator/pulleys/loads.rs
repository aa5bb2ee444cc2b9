//! Loads and set points at the pulleys, as functions of time.

use crate::archive::Archive;
use crate::pulley::PerPulley;
use crate::variator::settings::{Axial, Drive, Inputs, Parameters};

/// Condition that determines a sheave's axial position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SheaveMode {
    /// The force of clamp and pressure, N, is given.
    Force(f64),
    /// The sheave stands still.
    Held,
    /// A spring holds Θ near `theta`: the clamping force is `force` + [`RATIO_STIFFNESS`]·(`theta`
    /// − Θ). The steady solver moves `force` to the reaction.
    Ratio {
        /// Set point of Θ.
        theta: f64,
        /// Force at `theta`, N.
        force: f64,
    },
}

/// Factor on the inertias of the pulleys in a steady solution, so that their speeds follow the
/// belt: without it a tenth more work, and one start in a hundred is not found. Half: -4, -2 % of
/// the Jacobians and residuals of forty random starts; twice: 0, 0.
pub(crate) const PSEUDO_INERTIA: f64 = 40.0;

/// Time in which the reaction force of a steady solution is corrected, and in which its sheaves
/// tilt, s: a soft sheave with its own time of milliseconds oscillates against the spring of Θ. Of
/// 126 starts with soft sheaves 14 are not found, with this time 8, with twice 2. But twice takes
/// five times the work where a torque is far beyond capacity.
pub(crate) const FORCE_TIME: f64 = 0.02;

/// Stiffness of the spring that holds the ratio of a steady solution, N per unit of Θ: a clamping
/// force of 20 kN moves Θ by no more than 1e-3. Half: 0, +2; twice: -1, 0.
pub const RATIO_STIFFNESS: f64 = 2.0e7;

/// Condition that determines a pulley's speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShaftMode {
    /// The external torque, N·m, is given.
    Torque(f64),
    /// The speed follows the set point, rad/s, with a lag.
    Setpoint(f64),
    /// The speed stays constant.
    Fixed,
    /// Secondary only: both speeds change in proportion, ω̇_S/ω_S = ω̇_P/ω_P, under the two
    /// external torques, N·m.
    Balanced {
        /// At the secondary shaft.
        own: f64,
        /// At the primary shaft.
        primary: f64,
    },
}

/// Boundary conditions at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Conditions of the movable sheaves.
    pub sheave: PerPulley<SheaveMode>,
    /// Conditions of the shafts.
    pub shaft: PerPulley<ShaftMode>,
}

impl Boundary {
    /// Sheaves are held and shafts keep their speeds.
    pub const HELD: Self = Self {
        sheave: PerPulley {
            secondary: SheaveMode::Held,
            primary: SheaveMode::Held,
        },
        shaft: PerPulley {
            secondary: ShaftMode::Fixed,
            primary: ShaftMode::Fixed,
        },
    };

    /// Forces of clamps and pressures on the movable sheaves, N; 0 where they are held.
    #[must_use]
    pub fn clamping_forces(&self) -> PerPulley<f64> {
        self.sheave.map(|sheave| match sheave {
            SheaveMode::Force(force) => force,
            SheaveMode::Held | SheaveMode::Ratio { .. } => 0.0,
        })
    }
}

/// Shortest time of a change of inputs and of a step, s: rates over less are rounding errors.
pub(crate) const SHORTEST_STEP: f64 = 1.0e-9;

/// Inputs as functions of time, linear before and after one kink, the end of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputProfile {
    /// Time of the kink, s.
    pub kink: f64,
    /// Inputs there.
    pub(crate) inputs: Inputs,
    /// Their time derivatives before it and after it.
    pub(crate) rates: [Inputs; 2],
}

impl InputProfile {
    /// Constant inputs.
    #[must_use]
    pub fn constant(inputs: &Inputs) -> Self {
        Self {
            kink: 0.0,
            inputs: *inputs,
            rates: [Inputs::ZERO; 2],
        }
    }

    /// Inputs that ramp from `present` to those given over `time`, s: at most the step from `from`
    /// to `to`, and at once below a nanosecond; a negative time is the whole step. An input with a
    /// rate starts at its value and changes at that rate.
    #[must_use]
    pub fn new(time: f64, [from, to]: [f64; 2], present: &Inputs, given: &Inputs, rates: &Inputs) -> Self {
        let whole = time < 0.0 || time >= to - from - SHORTEST_STEP;
        let jumps = time < SHORTEST_STEP;
        let end = if whole {
            to
        } else {
            from + if jumps { 0.0 } else { time }
        };
        let mut ramp = *rates;
        if end > from {
            let changes = given.values().into_iter().zip(present.values());
            for (rate, (given, present)) in ramp.each_mut().into_iter().zip(changes) {
                if *rate == 0.0 {
                    *rate = (given - present) / (end - from);
                }
            }
        }
        let kink = if ramp == *rates { from } else { end };
        Self {
            kink,
            inputs: given.after(kink - from, rates),
            rates: [ramp, *rates],
        }
    }

    /// Sets the inputs that have changed from `before` to `given` to their new values, without a
    /// rate.
    pub(crate) fn change(&mut self, before: &Inputs, given: &Inputs) {
        let (before, given) = (before.values(), given.values());
        for k in (0..given.len()).filter(|&k| before[k] != given[k]) {
            *self.inputs.each_mut()[k] = given[k];
            for rates in &mut self.rates {
                *rates.each_mut()[k] = 0.0;
            }
        }
    }

    /// Inputs at a time, s. A clamping force that falls ends at zero.
    #[must_use]
    pub fn evaluate(&self, time: f64) -> Inputs {
        let rates = &self.rates[usize::from(time >= self.kink)];
        let mut inputs = self.inputs.after(time - self.kink, rates);
        for pulley in [&mut inputs.primary, &mut inputs.secondary] {
            pulley.clamping_force = pulley.clamping_force.max(0.0);
        }
        inputs
    }

    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.kink);
        let [before, after] = &mut self.rates;
        for value in [&mut self.inputs, before, after].into_iter().flat_map(Inputs::each_mut) {
            archive.real(value);
        }
    }
}

/// What acts on the pulleys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loads {
    /// Inputs of a run.
    Inputs(InputProfile),
    /// The same conditions at all times, of a steady solution: inertias of the pulleys are
    /// `PSEUDO_INERTIA` times as large, and sheaves tilt in `FORCE_TIME`.
    Steady(Boundary),
}

impl Loads {
    /// Inputs that are held.
    #[must_use]
    pub fn held(inputs: &Inputs) -> Self {
        Self::Inputs(InputProfile::constant(inputs))
    }

    pub(crate) fn boundary(&self, time: f64, parameters: &Parameters) -> Boundary {
        let given = match self {
            Self::Inputs(profile) => profile.evaluate(time),
            Self::Steady(boundary) => return *boundary,
        };
        Boundary {
            sheave: PerPulley::from_fn(|pulley| {
                let of = parameters.pulley(pulley);
                match of.axial {
                    Axial::Force => SheaveMode::Force(given.pulley(pulley).force(&of.cylinder)),
                    Axial::Held => SheaveMode::Held,
                }
            }),
            shaft: PerPulley::from_fn(|pulley| {
                let inputs = given.pulley(pulley);
                match parameters.pulley(pulley).drive {
                    Drive::Torque => ShaftMode::Torque(inputs.torque),
                    Drive::Speed => ShaftMode::Setpoint(inputs.speed_setpoint),
                }
            }),
        }
    }

    /// Inputs at a time, s; none of a steady solution.
    pub(crate) fn inputs(&self, time: f64) -> Inputs {
        match self {
            Self::Inputs(given) => given.evaluate(time),
            Self::Steady(_) => Inputs::ZERO,
        }
    }

    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>) {
        let mut given = match *self {
            Self::Inputs(given) => given,
            Self::Steady(_) => InputProfile::constant(&Inputs::ZERO),
        };
        given.serialize(archive);
        *self = Self::Inputs(given);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn torque(value: f64) -> Inputs {
        let mut inputs = Inputs::ZERO;
        inputs.primary.torque = value;
        inputs
    }

    /// Time of a ramp, s, and rate; end of the ramp, s; torques at the start, 5 ms later and at the
    /// end, N·m.
    #[test]
    fn an_input_jumps_ramps_or_follows_its_rate() {
        for (time, rate, kink, torques) in [
            (0.0, 0.0, 2.0, [30.0, 30.0, 30.0]),
            (1e-100, 0.0, 2.0, [30.0, 30.0, 30.0]),
            (4e-3, 0.0, 2.004, [10.0, 30.0, 30.0]),
            (-1.0, 0.0, 2.01, [10.0, 20.0, 30.0]),
            (0.5, 0.0, 2.01, [10.0, 20.0, 30.0]),
            (4e-3, 100.0, 2.0, [30.0, 30.5, 31.0]),
        ] {
            let rates = torque(rate);
            let profile = InputProfile::new(time, [2.0, 2.01], &torque(10.0), &torque(30.0), &rates);
            assert!((profile.kink - kink).abs() < 1e-12, "{time}, {rates:?}");
            // An input that changes counts at once, and the others go on.
            let mut changed = profile;
            let mut given = torque(30.0);
            given.secondary.torque = -7.0;
            changed.change(&torque(30.0), &given);
            for (at, expected) in [2.0, 2.005, 2.01].into_iter().zip(torques) {
                let found = profile.evaluate(at).primary.torque;
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{time}, {rates:?}: {found}, not {expected}"
                );
                assert_eq!(changed.evaluate(at).primary.torque, found, "{time}, {at}");
                assert_eq!(changed.evaluate(at).secondary.torque, -7.0, "{time}, {at}");
            }
        }
    }
}
