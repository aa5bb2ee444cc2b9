//! `ALE0` beside `ALE`: thrust ratios of the nine load cases, and how fast both shift.
//!
//! `cargo run --release --example level_of_detail` prints a line a load case and a line a shift. Shifts start without load
//! at 1000 rpm, in the steady state of the speed ratio s = r_P/r_S and the secondary force. There F_P is raised by e^0.3.
//! The gain is ds/dt per unit of ln F_P, from 60 to 120 ms after the step.

use std::error::Error;

use pushbelt::pulley::PerPulley;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Drive, Inputs, Outputs, RingModel};
use pushbelt_lab::load_cases::LoadCase;
use pushbelt_lab::steady::load_case;
use pushbelt_lab::variators::{inputs, variator};

/// Rings beside each other.
const RINGS: [RingModel; 2] = [RingModel::Ale, RingModel::Ale0];
/// 1000 rpm, rad/s.
const SPEED: f64 = 104.72;
/// Logarithm of the step of F_P.
const STEP: f64 = 0.3;
/// Times between which the shift is measured, s.
const WINDOW: [f64; 2] = [0.06, 0.12];
/// Communication step, s.
const COMMUNICATION: f64 = 1e-3;

/// The thrust ratio and slip of a load case.
fn thrust(ring: RingModel, torque: f64, of_three: usize) -> [f64; 2] {
    let parameters = variator(ring);
    let case = LoadCase::three(&parameters, torque)[of_three];
    let outputs = load_case(&parameters, &case).outputs;
    [outputs.thrust_ratio, outputs.slip]
}

/// A variator without load in its steady state at the speed ratio `s`, under these clamping forces, N.
fn unloaded(ring: RingModel, s: f64, clamping: PerPulley<f64>) -> Result<(Variator, Inputs), Box<dyn Error>> {
    let mut parameters = variator(ring);
    parameters.primary.drive = Drive::Speed;
    parameters.initial.ratio = 1.0 / s;
    let mut loads = inputs((0.0, clamping.primary), (0.0, clamping.secondary));
    loads.primary.speed_setpoint = SPEED;
    let mut variator = Variator::new(parameters)?;
    variator.initialise(0.0, &loads)?;
    Ok((variator, loads))
}

/// Gain of a shift at the speed ratio `s` and the secondary force `force`, N, in 1/s; F_P/F_S before the step.
fn shift(ring: RingModel, s: f64, force: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let mut clamping = PerPulley {
        secondary: force,
        primary: force,
    };
    clamping.primary = unloaded(ring, s, clamping)?.0.outputs().primary.axial_force;
    let (mut variator, mut loads) = unloaded(ring, s, clamping)?;
    loads.primary.clamping_force *= STEP.exp();
    let speed_ratio = |outputs: &Outputs| 1.0 / outputs.ratio_geometric;
    let mut reached = [0.0; 2];
    let mut clock = 0.0;
    for (reached, until) in reached.iter_mut().zip(WINDOW) {
        while clock < until - 0.5 * COMMUNICATION {
            clock += COMMUNICATION;
            variator.advance(clock, &loads)?;
        }
        *reached = speed_ratio(variator.outputs());
    }
    let gain = (reached[1] - reached[0]) / (WINDOW[1] - WINDOW[0]) / STEP;
    Ok([gain, clamping.primary / clamping.secondary])
}

/// How far `ALE0` is from `ALE`, %.
fn off([ale, ale0]: [f64; 2]) -> f64 {
    100.0 * (ale0 / ale - 1.0)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("thrust ratio: ALE, ALE0, difference; slip: ALE, ALE0");
    for torque in [30.0, 50.0, 100.0] {
        for (k, name) in ["underdrive", "medium", "overdrive"].into_iter().enumerate() {
            let found = RINGS.map(|ring| thrust(ring, torque, k));
            let [thrust, slip] = [0, 1].map(|i| found.map(|of| of[i]));
            println!(
                "{name:<10} {torque:>3} N·m  {:.4} {:.4} {:+.1} %  {:.2} % {:.2} %",
                thrust[0],
                thrust[1],
                off(thrust),
                100.0 * slip[0],
                100.0 * slip[1]
            );
        }
    }
    println!("shift gain, 1/s: ALE, ALE0, difference; F_P/F_S before: ALE, ALE0");
    for s in [0.6, 0.8, 1.0, 1.25, 1.5, 1.8] {
        for force in [8e3, 12e3, 20e3] {
            let [ale, ale0] = RINGS.map(|ring| shift(ring, s, force));
            let (ale, ale0) = (ale?, ale0?);
            println!(
                "s {s:<4} {:>2} kN  {:.4} {:.4} {:+.1} %  {:.4} {:.4}",
                force / 1e3,
                ale[0],
                ale0[0],
                off([ale[0], ale0[0]]),
                ale[1],
                ale0[1]
            );
        }
    }
    Ok(())
}
