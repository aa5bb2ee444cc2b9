//! Inputs and outputs of a variator at every communication step, in SI units. Their rows are in
//! [`table`](super::table) and [`unit`](crate::unit).
#![expect(missing_docs, reason = "fields are described in the tables of variables")]

pub use super::choices::StartState;
use crate::cylinder::Cylinder;
use crate::pulley::Pulley;
use crate::ring::stress::RingStress;

/// Number of points of the profiles along the belt, ξ_k = (k−1)L/72.
pub const PROFILE_POINTS: usize = 72;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Input {
    pub name: &'static str,
    pub unit: &'static str,
    /// Size in which changes are counted.
    pub size: f64,
}

const fn input(name: &'static str, unit: &'static str, size: f64) -> Input {
    Input { name, unit, size }
}

/// The inputs in the order of [`Inputs::values`].
pub(crate) const INPUTS: [Input; 8] = [
    input("primary.torque", "N.m", 50.0),
    input("primary.clampingForce", "N", 5.0e3),
    input("primary.speedSetpoint", "rad/s", 100.0),
    input("primary.pressure", "Pa", 5.0e5),
    input("secondary.torque", "N.m", 50.0),
    input("secondary.clampingForce", "N", 5.0e3),
    input("secondary.speedSetpoint", "rad/s", 100.0),
    input("secondary.pressure", "Pa", 5.0e5),
];

/// Inputs of one pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PulleyInputs {
    pub torque: f64,
    pub clamping_force: f64,
    pub speed_setpoint: f64,
    pub pressure: f64,
}

impl PulleyInputs {
    /// Force of clamp and pressure on the movable sheave, N.
    #[must_use]
    pub fn force(&self, cylinder: &Cylinder) -> f64 {
        self.clamping_force + cylinder.area * self.pressure
    }
}

/// Inputs of the variator, held over a communication step or linear in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    pub primary: PulleyInputs,
    pub secondary: PulleyInputs,
}

impl Inputs {
    /// No load; as rates, no change.
    pub const ZERO: Self = {
        let none = PulleyInputs {
            torque: 0.0,
            clamping_force: 0.0,
            speed_setpoint: 0.0,
            pressure: 0.0,
        };
        Self {
            primary: none,
            secondary: none,
        }
    };

    /// The values, the primary pulley's first.
    pub fn each_mut(&mut self) -> [&mut f64; 8] {
        let [[a, b, c, d], [e, f, g, h]] = [&mut self.primary, &mut self.secondary].map(|of| {
            [
                &mut of.torque,
                &mut of.clamping_force,
                &mut of.speed_setpoint,
                &mut of.pressure,
            ]
        });
        [a, b, c, d, e, f, g, h]
    }

    /// The values, the primary pulley's first.
    pub(crate) fn values(mut self) -> [f64; 8] {
        self.each_mut().map(|value| *value)
    }

    /// The inputs after a time, s, in which they change at `rates`.
    #[must_use]
    pub fn after(mut self, time: f64, rates: &Self) -> Self {
        for (value, rate) in self.each_mut().into_iter().zip(rates.values()) {
            *value += time * rate;
        }
        self
    }

    /// Inputs of a pulley.
    #[must_use]
    pub fn pulley(&self, pulley: Pulley) -> &PulleyInputs {
        match pulley {
            Pulley::Secondary => &self.secondary,
            Pulley::Primary => &self.primary,
        }
    }
}

/// Outputs of one pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PulleyOutputs {
    pub speed: f64,
    pub radius: f64,
    pub position: f64,
    pub sheave_velocity: f64,
    pub clamping_force_total: f64,
    pub flow: f64,
    pub volume: f64,
    pub axial_force: f64,
    pub shaft_torque: f64,
    pub external_torque: f64,
    pub power: f64,
    pub spiral: f64,
    pub tilt: f64,
    pub idle_arc: f64,
}

/// Losses, each from its own law, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses<L = f64> {
    pub sheaves: L,
    pub ring: L,
    pub layers: L,
    pub joints: L,
    pub element_rotation: L,
    pub shafts: L,
    pub seals: L,
    pub other: L,
}

impl Losses {
    /// Sum of all losses, W.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.sheaves
            + self.ring
            + self.layers
            + self.shafts
            + self.other
            + self.element_rotation
            + self.joints
            + self.seals
    }
}

type Field = [f64; PROFILE_POINTS];

/// Fields along the belt at ξ_k = (k−1)L/[`PROFILE_POINTS`].
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub position: Field,
    pub push_force: Field,
    pub ring_tension: Field,
    pub normal_force: Field,
    pub radial_deviation: Field,
    pub sliding_speed: Field,
    pub lateral_deflection: Field,
    pub gap: Field,
    pub ring_stress: Field,
}

impl Default for Profile {
    fn default() -> Self {
        let zero = [0.0; PROFILE_POINTS];
        Self {
            position: zero,
            push_force: zero,
            ring_tension: zero,
            normal_force: zero,
            radial_deviation: zero,
            sliding_speed: zero,
            lateral_deflection: zero,
            gap: zero,
            ring_stress: zero,
        }
    }
}

/// Work of a run since its start, and the remaining error of its last communication step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    pub steps: i32,
    pub jacobians: i32,
    pub residuals: i32,
    pub defect: f64,
    pub behind: f64,
    pub skipped: f64,
    pub rollbacks: i32,
}

/// Scalar outputs of a variator in its present state. Only `external_torque` in torque drive and
/// `clamping_force_total` depend on the inputs, as held over the last step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    pub primary: PulleyOutputs,
    pub secondary: PulleyOutputs,
    pub thrust_ratio: f64,
    pub belt_speed: f64,
    pub ring_speed: f64,
    pub ratio_speed: f64,
    pub ratio_geometric: f64,
    pub reference_theta: f64,
    pub slip: f64,
    pub losses: Losses,
    pub efficiency: f64,
    pub belt_efficiency: f64,
    pub torque_utilisation: f64,
    pub macro_slip: bool,
    pub past_peak: bool,
    pub push_force_max: f64,
    pub ring_tension_max: f64,
    pub ring_tension_min: f64,
    pub ring_stress: RingStress,
    pub misalignment: f64,
    pub lateral_max: f64,
    pub skew: f64,
    pub stored_energy: f64,
    pub energy_residual: f64,
    pub start_state: StartState,
    pub work: Work,
}

/// Outputs and profile of a variator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    pub outputs: Outputs,
    pub profile: Profile,
}

impl AsRef<Outputs> for Readings {
    fn as_ref(&self) -> &Outputs {
        &self.outputs
    }
}

impl AsRef<Self> for Outputs {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// Readings without a profile.
impl From<Outputs> for Readings {
    fn from(outputs: Outputs) -> Self {
        Self {
            outputs,
            profile: Profile::default(),
        }
    }
}
