//! Loads and set points at the pulleys, as functions of time.

use crate::archive::Archive;
use crate::pulley::PerPulley;
use crate::variator::settings::parameters::{Axial, Drive, Parameters};
use crate::variator::settings::signals::Inputs;

/// Condition that determines a sheave's axial position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SheaveMode {
    /// The force of clamp and pressure, N, is given.
    Force(f64),
    /// The sheave stands still.
    Held,
    /// A spring holds Θ near `theta`: the clamping force is `force` + [`RATIO_STIFFNESS`]·(`theta` − Θ). The steady solver
    /// moves `force` to the reaction.
    Ratio {
        /// Set point of Θ.
        theta: f64,
        /// Force at `theta`, N.
        force: f64,
    },
}

/// Stiffness of the spring that holds the ratio of a steady solution, N per unit of Θ: a clamping force of 20 kN moves Θ by
/// no more than 1e-3.
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
    /// Secondary only: both speeds change in proportion, ω̇_S/ω_S = ω̇_P/ω_P, under the two external torques, N·m.
    Balanced {
        /// At the secondary shaft.
        own: f64,
        /// At the primary shaft.
        primary: f64,
    },
    /// Secondary only: the speed follows from the torque, N·m, that the belt takes from the primary pulley. The torque excludes
    /// the drag of the shafts.
    Transmit(f64),
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

/// Inputs that change in proportion to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearInputs {
    /// Time from which they change, s.
    pub from: f64,
    /// Time at which others follow, s.
    pub until: f64,
    /// Inputs at `from`.
    pub inputs: Inputs,
    /// Their time derivatives.
    pub rates: Inputs,
}

impl LinearInputs {
    /// No inputs at all.
    pub const NONE: Self = Self {
        from: 0.0,
        until: f64::INFINITY,
        inputs: Inputs::ZERO,
        rates: Inputs::ZERO,
    };

    /// Inputs that do not change.
    #[must_use]
    pub fn constant(from: f64, inputs: &Inputs) -> Self {
        Self {
            from,
            inputs: *inputs,
            ..Self::NONE
        }
    }

    /// Inputs at a time, s. A clamping force that falls ends at zero: sheaves are pushed, never pulled.
    #[must_use]
    pub fn at(&self, time: f64) -> Inputs {
        let mut inputs = self.inputs.after(time - self.from, &self.rates);
        for pulley in [&mut inputs.primary, &mut inputs.secondary] {
            pulley.clamping_force = pulley.clamping_force.max(0.0);
        }
        inputs
    }

    /// Writes to an archive, or reads from it.
    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.from);
        archive.within(&mut self.until, f64::MIN, f64::INFINITY);
        for value in self.inputs.each_mut().into_iter().chain(self.rates.each_mut()) {
            archive.real(value);
        }
    }
}

/// What acts on the pulleys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loads {
    /// Inputs of a run. Of torques, forces and pressures a share acts, which grows in a soft start.
    Inputs(LinearInputs, f64),
    /// The same conditions at all times.
    Constant(Boundary),
}

impl Loads {
    /// Inputs that are held, in a run under load.
    #[must_use]
    pub fn held(inputs: &Inputs) -> Self {
        Self::Inputs(LinearInputs::constant(0.0, inputs), 1.0)
    }

    /// The boundary conditions at a time, s.
    pub(crate) fn at(&self, time: f64, parameters: &Parameters) -> Boundary {
        let (given, share) = match self {
            Self::Inputs(given, share) => (given, *share),
            Self::Constant(boundary) => return *boundary,
        };
        let after = time - given.from;
        let linear = |start: f64, rate: f64| start + after * rate;
        Boundary {
            sheave: PerPulley::from_fn(|pulley| {
                let of = parameters.pulley(pulley);
                let (inputs, rates) = (given.inputs.pulley(pulley), given.rates.pulley(pulley));
                let [oil, oil_rate] = [inputs, rates].map(|inputs| share * (of.cylinder.area * inputs.pressure));
                let clamp = linear(share * inputs.clamping_force, share * rates.clamping_force).max(0.0);
                match of.axial {
                    Axial::Force => SheaveMode::Force(clamp + linear(oil, oil_rate)),
                    Axial::Held => SheaveMode::Held,
                }
            }),
            shaft: PerPulley::from_fn(|pulley| {
                let (inputs, rates) = (given.inputs.pulley(pulley), given.rates.pulley(pulley));
                match parameters.pulley(pulley).drive {
                    Drive::Torque => ShaftMode::Torque(linear(share * inputs.torque, share * rates.torque)),
                    Drive::Speed => ShaftMode::Setpoint(linear(inputs.speed_setpoint, rates.speed_setpoint)),
                }
            }),
        }
    }

    /// Inputs at a time, s; none of a steady solution.
    pub(crate) fn inputs(&self, time: f64) -> Inputs {
        match self {
            Self::Inputs(given, _) => given.at(time),
            Self::Constant(_) => Inputs::ZERO,
        }
    }

    /// Writes the loads of a run to an archive, or reads them.
    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>) {
        let (mut given, mut share) = match *self {
            Self::Inputs(given, share) => (given, share),
            Self::Constant(_) => (LinearInputs::NONE, 1.0),
        };
        given.serialize(archive);
        archive.within(&mut share, 0.0, 1.0);
        *self = Self::Inputs(given, share);
    }
}
