//! Unstable steady states: all modes up to 20 kHz over ratios, torques and speeds, with a clamping
//! force of 12 kN. Prints each state with growing modes, and the fastest of them.
//!
//! `cargo run --release --example modes [-- --rigid] [--finer] [--ale0]`

use std::error::Error;
use std::f64::consts::TAU;

use clap::Parser;
use pushbelt::variator::linear::{LinearError, modes};
use pushbelt::variator::settings::Inputs;
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::variators::rigid;

const RATIOS: [f64; 7] = [0.45, 0.6, 0.8, 1.0, 1.3, 1.7, 2.2];
/// N·m.
const TORQUES: [f64; 5] = [-60.0, 0.0, 30.0, 60.0, 100.0];
/// rad/s.
const SPEEDS: [f64; 3] = [50.0, 209.44, 600.0];
/// N.
const CLAMPING: f64 = 12e3;
/// Hz.
const FASTEST: f64 = 2e4;
/// Slower growth is that of the ratio or a speed, which a driver or a controller stabilises, 1/s.
const SLOW: f64 = 2.0;

#[derive(Parser)]
struct Options {
    /// Sheaves that don't tilt
    #[arg(long)]
    rigid: bool,
    /// Twice the elements
    #[arg(long)]
    finer: bool,
    /// `ALE0`
    #[arg(long)]
    ale0: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let mut parameters = Parameters::default();
    if options.rigid {
        parameters = rigid(parameters);
    }
    if options.finer {
        parameters.mesh = parameters.mesh.refined(2);
    }
    if options.ale0 {
        parameters.ring_model = RingModel::Ale0;
    }
    println!("| speed | ratio | torque | a mode grows by, 1/s | at, Hz |\n|---|---|---|---|---|");
    let mut growing = Vec::new();
    for speed in SPEEDS {
        let (mut found, mut unstable) = (0, 0);
        for ratio in RATIOS {
            for torque in TORQUES {
                parameters.initial.ratio = ratio;
                parameters.initial.primary_speed = speed;
                let mut inputs = Inputs::default();
                inputs.primary.torque = torque;
                inputs.secondary.torque = -torque * ratio;
                inputs.primary.clamping_force = CLAMPING;
                inputs.secondary.clamping_force = CLAMPING;
                let [growth, turn] = match modes(&parameters, &inputs, FASTEST) {
                    Ok(modes) => modes[0],
                    // Beyond capacity.
                    Err(LinearError::Unsteady(_)) => continue,
                    Err(error) => return Err(error.into()),
                };
                found += 1;
                if growth > SLOW {
                    unstable += 1;
                    println!(
                        "| {speed} rad/s | {ratio} | {torque} N·m | {growth:.0} | {:.0} |",
                        turn / TAU
                    );
                }
            }
        }
        growing.push(format!("{unstable} of {found} at {speed} rad/s"));
    }
    println!("\na mode grows in {}", growing.join(", "));
    Ok(())
}
