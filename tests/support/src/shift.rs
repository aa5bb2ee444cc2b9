//! The rate of the ratio after a step of the primary clamping force.

use crate::run::Run;
use crate::variators::{inputs, variator};
use pushbelt::variator::settings::{Drive, RingModel};

/// 1000 rpm, rad/s.
const SPEED: f64 = 104.72;
/// Logarithm of the step of F_P.
const STEP: f64 = 0.3;
/// Delay of the measurement after the step, and its duration, s.
const SPAN: f64 = 0.06;
/// Communication step, s.
const COMMUNICATION: f64 = 1e-3;

/// A shift after a step of F_P.
#[derive(Debug)]
pub struct Shift {
    /// ds/dt per unit of ln F_P, s = r_P/r_S, from 60 to 120 ms after F_P rose by e^0.3, 1/s.
    pub gain: f64,
    /// F_P/F_S before the step.
    pub force_ratio: f64,
    /// The run, at its end.
    pub run: Run,
}

/// The shift from the steady state without load at 1000 rpm, at the speed ratio `s` and the
/// secondary force `force`, N.
pub fn unloaded_shift(model: RingModel, s: f64, force: f64) -> Shift {
    let mut parameters = variator(model);
    parameters.primary.drive = Drive::Speed;
    parameters.initial.ratio = 1.0 / s;
    let start = |primary: f64| {
        let mut start = inputs((0.0, primary), (0.0, force));
        start.primary.speed_setpoint = SPEED;
        Run::new(parameters.clone(), start)
    };
    let holding = start(force).variator.outputs().primary.axial_force;
    let mut run = start(holding);
    run.inputs.primary.clamping_force *= STEP.exp();
    let [from, to] = [SPAN; 2].map(|span| 1.0 / run.go(span, COMMUNICATION).ratio_geometric);
    Shift {
        gain: (to - from) / SPAN / STEP,
        force_ratio: holding / force,
        run,
    }
}
