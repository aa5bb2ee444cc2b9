//! The nine load cases of steady states.

use crate::variators::SPEED;
use pushbelt::contact;
use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::variator::pulleys::loads::{Boundary, ShaftMode};
use pushbelt::variator::settings::{Axial, Drive, Inputs, Parameters};
use pushbelt::variator::steady::solve::SteadyTask;
use pushbelt::variator::system::VariatorSystem;

/// One of the nine cases: 2000 rpm, the ratio held by the primary sheave, the secondary clamping
/// force 1.3 times that of full tangential slip.
#[derive(Clone, Copy, Debug)]
pub struct LoadCase {
    /// Ratio by name.
    pub name: &'static str,
    /// Θ.
    pub theta: f64,
    /// Torque on the primary shaft, N·m.
    pub torque: f64,
    /// F_S, N.
    pub clamping: f64,
}

impl LoadCase {
    /// The case of Θ and torque.
    pub fn new(parameters: &Parameters, name: &'static str, theta: f64, torque: f64) -> Self {
        Self {
            name,
            theta,
            torque,
            clamping: clamping(parameters, ratio(theta), 1.3 * torque),
        }
    }

    /// Underdrive, medium, overdrive at one torque.
    pub fn three(parameters: &Parameters, torque: f64) -> [Self; 3] {
        [("underdrive", -0.4), ("medium", 0.0), ("overdrive", 0.4)]
            .map(|(name, theta)| Self::new(parameters, name, theta, torque))
    }

    pub fn task(&self) -> SteadyTask {
        transmitted(ratio(self.theta), self.clamping, self.torque)
    }

    /// Its steady start: the torque drives the primary pulley, whose sheave is held.
    pub fn start(&self, parameters: &Parameters) -> (Parameters, Inputs) {
        let (mut p, mut inputs) = (parameters.clone(), Inputs::ZERO);
        (p.initial.steady, p.initial.ratio, p.initial.primary_speed) = (true, ratio(self.theta), SPEED);
        (p.primary.axial, p.secondary.drive) = (Axial::Held, Drive::Speed);
        inputs.primary.torque = self.torque;
        inputs.secondary.clamping_force = self.clamping;
        inputs.secondary.speed_setpoint = SPEED / p.initial.ratio;
        (p, inputs)
    }
}

/// Least clamping force at which the primary pulley transmits a torque at a ratio, at least 6 kN.
pub fn clamping(parameters: &Parameters, ratio: f64, capacity: f64) -> f64 {
    let system = VariatorSystem::new(parameters);
    let primary = system.belt.curve.radii(ratio).expect("the belt closes").primary;
    let radius = primary - parameters.belt.pitch_offset;
    let cos_beta = parameters.geometry.wedge_angle.cos();
    (capacity / contact::full_slip_torque(&parameters.friction, cos_beta, 1.0, radius)).max(6000.0)
}

pub fn pair<T>(secondary: T, primary: T) -> PerPulley<T> {
    PerPulley { secondary, primary }
}

/// Speeds of the shafts without slip at a ratio and a primary speed, rad/s.
pub fn speeds(ratio: f64, primary: f64) -> PerPulley<f64> {
    pair(primary / ratio, primary)
}

/// i_g of Θ.
pub fn ratio(theta: f64) -> f64 {
    (1.0 - theta) / (1.0 + theta)
}

/// A task at a given ratio and given speeds; `reaction` is the pulley whose sheave holds the ratio.
pub fn given(ratio: f64, reaction: Pulley, clamping: f64) -> SteadyTask {
    SteadyTask {
        ratio,
        reaction,
        clamping: PerPulley::from_fn(|_| clamping),
        shaft: Boundary::HELD.shaft,
        warm: false,
    }
}

/// A task under a secondary clamping force, N, and a torque on the primary shaft, N·m; the speed of
/// the secondary one is held.
pub fn transmitted(ratio: f64, clamping: f64, torque: f64) -> SteadyTask {
    SteadyTask {
        shaft: pair(ShaftMode::Fixed, ShaftMode::Torque(torque)),
        ..given(ratio, Pulley::Primary, clamping)
    }
}
