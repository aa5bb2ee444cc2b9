//! Loads and set points at the pulleys, as functions of time.

use crate::pulley::{PerPulley, Pulley};
use crate::tape::Tape;

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

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        for sheave in self.sheave.each_mut() {
            if let SheaveMode::Force(force) = sheave {
                tape.real(force);
            }
        }
        for shaft in self.shaft.each_mut() {
            if let ShaftMode::Torque(load) | ShaftMode::Setpoint(load) = shaft {
                tape.real(load);
            }
        }
    }
}

/// Rates of the loads of a [`Boundary`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadRates {
    /// Rates of clamping forces, N/s.
    pub force: PerPulley<f64>,
    /// Rates of the forces of pressures, N/s.
    pub oil: PerPulley<f64>,
    /// Rates of external torques, N·m/s, or of speed set points, rad/s².
    pub shaft: PerPulley<f64>,
}

/// Loads that change in proportion to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loads {
    /// Time at which the loads are those of `start`, s.
    from: f64,
    start: Boundary,
    /// Forces of pressures beside the forces of `start`, N.
    oil: PerPulley<f64>,
    rates: LoadRates,
}

impl Loads {
    /// Loads that do not change.
    #[must_use]
    pub fn constant(start: Boundary) -> Self {
        Self::changing(0.0, (start, PerPulley::default()), LoadRates::default())
    }

    /// Loads that are `start`, and forces of pressures, N, in addition to its clamping forces, at the time `from`, s. They change at
    /// `rates`.
    #[must_use]
    pub fn changing(from: f64, (start, oil): (Boundary, PerPulley<f64>), rates: LoadRates) -> Self {
        Self {
            from,
            start,
            oil,
            rates,
        }
    }

    /// The boundary conditions at a time, s. A falling clamping force stops at zero: an actuator can't pull its sheave.
    #[must_use]
    pub fn at(&self, time: f64) -> Boundary {
        let mut boundary = self.start;
        let after = time - self.from;
        for pulley in Pulley::BOTH {
            if let SheaveMode::Force(force) = &mut boundary.sheave[pulley] {
                if self.rates.force[pulley] != 0.0 {
                    *force = (*force + after * self.rates.force[pulley]).max(0.0);
                }
                *force += self.oil[pulley] + after * self.rates.oil[pulley];
            }
            if let ShaftMode::Torque(load) | ShaftMode::Setpoint(load) = &mut boundary.shaft[pulley] {
                *load += after * self.rates.shaft[pulley];
            }
        }
        boundary
    }

    /// Writes the loads to a tape, or reads them. Before reading, boundary conditions of the same kinds must be set.
    pub(crate) fn serialize(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.from);
        self.start.serialize(tape);
        let LoadRates { force, oil, shaft } = &mut self.rates;
        for values in [&mut self.oil, force, oil, shaft] {
            for value in values.each_mut() {
                tape.real(value);
            }
        }
    }
}
