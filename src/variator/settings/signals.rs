//! Inputs and outputs of a variator at every communication step.

use crate::cylinder::Cylinder;
use crate::pulley::{PerPulley, Pulley};
use crate::variator::settings::capacity::short;
pub use crate::variator::settings::choices::StartState;

/// Number of points of the profiles along the belt, ξ_k = (k−1)L/72.
pub const PROFILE_POINTS: usize = 72;

/// Inputs of one pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PulleyInputs {
    /// External shaft torque, positive in the direction of positive speed, N·m.
    pub torque: f64,
    /// Closing force on the movable sheave, ≥ 0, N.
    pub clamping_force: f64,
    /// Speed set point, used in speed drive only, rad/s.
    pub speed_setpoint: f64,
    /// Pressure in the cylinder above ambient, Pa.
    pub pressure: f64,
}

impl PulleyInputs {
    /// Force of clamp and pressure on the movable sheave, N.
    #[must_use]
    pub fn force(&self, cylinder: &Cylinder) -> f64 {
        self.clamping_force + cylinder.area * self.pressure
    }

    /// A remark on a pressure that opens the pulley at a time, s, where the force on its sheave is `total`, N; none where it closes.
    #[must_use]
    pub fn opening(&self, pulley: Pulley, time: f64, total: f64) -> Option<String> {
        let (name, pressure, clamping) = (pulley.name(), self.pressure, self.clamping_force);
        (total <= 0.0 && total < clamping).then(|| {
            format!(
                "at {time} s {name}.pressure = {pressure} Pa opens the {name} pulley: with clampingForce = {clamping} N, spring and rotating oil \
                 the force on its sheave is {} N",
                short(total)
            )
        })
    }
}

/// Inputs of the variator: held over a communication step, or in proportion to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// Inputs of the primary pulley.
    pub primary: PulleyInputs,
    /// Inputs of the secondary pulley.
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
        let [primary, secondary] = [&mut self.primary, &mut self.secondary];
        [
            &mut primary.torque,
            &mut primary.clamping_force,
            &mut primary.speed_setpoint,
            &mut primary.pressure,
            &mut secondary.torque,
            &mut secondary.clamping_force,
            &mut secondary.speed_setpoint,
            &mut secondary.pressure,
        ]
    }

    /// The values, the primary pulley's first.
    pub(crate) fn values(mut self) -> [f64; 8] {
        self.each_mut().map(|value| *value)
    }

    /// The sum of the inputs, each times its share.
    #[must_use]
    pub(crate) fn blend(parts: [(f64, Self); 2]) -> Self {
        let mut sum = Self::ZERO;
        for (share, part) in parts {
            sum = sum.after(share, &part);
        }
        sum
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
    /// Angular speed ω, rad/s.
    pub speed: f64,
    /// Pressure-weighted mean pitch radius of the arc, m.
    pub radius: f64,
    /// Movable-sheave displacement, closing positive, 0 at ratio 1, m.
    pub position: f64,
    /// Its rate, m/s.
    pub sheave_velocity: f64,
    /// Axial force on the movable sheave from outside the belt: clamp and cylinder, or the reaction of a held sheave, N.
    pub clamping_force_total: f64,
    /// Flow into the cylinder, m³/s.
    pub flow: f64,
    /// Axial belt force on one sheave, N.
    pub axial_force: f64,
    /// Torque of the belt on the pulley, N·m.
    pub shaft_torque: f64,
    /// External torque at the shaft: the input, or the reaction in speed drive, N·m.
    pub external_torque: f64,
    /// −shaft_torque·ω, power into the belt, W.
    pub power: f64,
    /// Spread of the running radius within the arc, m.
    pub spiral: f64,
    /// Tilt of one sheave, the mean of both, rad.
    pub tilt: f64,
    /// Idle arc: from the entry to where the push force has changed by a tenth of the difference of the strands, rad.
    pub idle_arc: f64,
}

/// Losses, each from its own law, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses<L = f64> {
    /// Friction between element flanks and sheaves.
    pub sheaves: L,
    /// Friction between ring and elements.
    pub ring: L,
    /// Friction between the layers of the ring.
    pub layers: L,
    /// Friction in the joints of a pull chain.
    pub joints: L,
    /// Elements that start and stop turning where they enter and leave an arc.
    pub spin: L,
    /// Drag of the shafts in seals, oil and bearings.
    pub shafts: L,
    /// Friction of the cylinders' seals.
    pub seals: L,
    /// Sheave damper, tilt relaxation, chain, structural and contact damping, end stops.
    pub other: L,
}

impl Losses {
    /// Sum of all losses, W.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.sheaves + self.ring + self.layers + self.shafts + self.other + self.spin + self.joints + self.seals
    }
}

/// Fields along the belt at ξ_k = (k−1)L/[`PROFILE_POINTS`].
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Place ξ_k, m.
    pub position: [f64; PROFILE_POINTS],
    /// Push force Q between the elements, N.
    pub push_force: [f64; PROFILE_POINTS],
    /// Ring tension T, N.
    pub ring_tension: [f64; PROFILE_POINTS],
    /// Normal force per flank and length, N/m.
    pub normal_force: [f64; PROFILE_POINTS],
    /// Radius less the arc's mean radius; on strands the normal distance from the tangent line (outward positive), m.
    pub radial_deviation: [f64; PROFILE_POINTS],
    /// Tangential sliding speed of the flanks on the nearer pulley; 0 where there is no contact, m/s.
    pub sliding_speed: [f64; PROFILE_POINTS],
    /// Deflection w along z from the middle between the two belt planes, m; 0 of a planar ring.
    pub lateral_deflection: [f64; PROFILE_POINTS],
    /// Gap between neighbouring elements, 0 in contact, m.
    pub gap: [f64; PROFILE_POINTS],
    /// Stress of the most loaded face of the ring's layers, Pa.
    pub ring_stress: [f64; PROFILE_POINTS],
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
    /// Steps of the integrator, including rejected ones.
    pub steps: i32,
    /// Jacobians formed and factored.
    pub jacobians: i32,
    /// Residuals evaluated.
    pub residuals: i32,
    /// Largest remaining Newton correction of the last communication step, relative to the limit of accurate steps.
    pub defect: f64,
    /// Delay of the outputs behind the communication point, s; 0 in accurate steps.
    pub behind: f64,
    /// Steps in real time that had no solution and were begun again with half the length.
    pub rollbacks: i32,
}

/// Stress of the most loaded face of the ring's layers, that with the largest stress over a revolution, Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RingStress {
    /// Largest stress.
    pub max: f64,
    /// Amplitude of the cycle on each pulley.
    pub amplitude: PerPulley<f64>,
    /// Mean stress of the same cycle.
    pub mean: PerPulley<f64>,
}

/// Scalar outputs of a variator in its present state. No entry depends on the present inputs
/// except `external_torque` in torque drive and `clamping_force_total`, which have the inputs as held over the last step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Outputs of the primary pulley.
    pub primary: PulleyOutputs,
    /// Outputs of the secondary pulley.
    pub secondary: PulleyOutputs,
    /// Axial belt force primary / secondary; 0 where the secondary force is below 1 N, at most 100.
    pub thrust_ratio: f64,
    /// Mean pitch-line speed of the elements, m/s.
    pub belt_speed: f64,
    /// Drift rate ṡ of the ring, m/s.
    pub ring_speed: f64,
    /// ω_P/ω_S, 0 at standstill.
    pub ratio_speed: f64,
    /// r_S/r_P of the pressure-weighted radii.
    pub ratio_geometric: f64,
    /// Θ, the ratio coordinate of the reference curve.
    pub reference_theta: f64,
    /// 1 − (ω_S/ω_P)·ratio_geometric; 0 near standstill, clamped to ±2.
    pub slip: f64,
    /// Losses by their causes.
    pub losses: Losses,
    /// Driven / driving shaft power, 0 where no power flows. The drag of the shafts is in it.
    pub efficiency: f64,
    /// Driven / driving power at the belt, 0 where no power flows. The drag of the shafts is not in it.
    pub belt_efficiency: f64,
    /// abs(belt torque on P) cosβ/(2 μ F_S r_P), at most 10.
    pub torque_utilisation: f64,
    /// All loaded cells of a pulley slide one way.
    pub macro_slip: bool,
    /// Largest push force, N.
    pub push_force_max: f64,
    /// Largest ring tension, N.
    pub ring_tension_max: f64,
    /// Smallest ring tension, N.
    pub ring_tension_min: f64,
    /// Stress in the layers of the ring.
    pub ring_stress: RingStress,
    /// Middle of the primary pulley less that of the secondary along z, m.
    pub misalignment: f64,
    /// Largest lateral deflection from the middle between the two belt planes, either way, m; 0 of a planar ring.
    pub lateral_max: f64,
    /// Mean inclination w' of the strands from S to P, rad; 0 of a planar ring.
    pub skew: f64,
    /// Kinetic and elastic energy of belt and pulleys, J.
    pub stored_energy: f64,
    /// Energy balance since the start: supplied − lost − stored, J.
    pub energy_residual: f64,
    /// State that the run started from.
    pub start_state: StartState,
    /// Work of the run.
    pub work: Work,
}

/// Outputs and profile of a variator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// Scalar outputs.
    pub outputs: Outputs,
    /// Fields along the belt.
    pub profile: Profile,
}

impl AsRef<Outputs> for Readings {
    fn as_ref(&self) -> &Outputs {
        &self.outputs
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
