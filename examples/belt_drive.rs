//! The variator under one of the loads of `cargo fmu bench -- --loads`, for comparison with a code
//! for belt drives.
//!
//! `cargo run --release --example belt_drive -- --load b --model ale0 --seconds 1`
//!
//! Prints the processor time of steps and outputs, the least of several runs. `--csv` writes one
//! line per step: time (s), speeds (rad/s), torques of the belt on the pulleys (N·m), slip, belt
//! speed (m/s).

use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, ValueEnum};
use cpu_time::ThreadTime;
use pushbelt::variator::settings::RingModel;
use pushbelt_support::loads::{Driven, LOADS, LoadHistory};
use pushbelt_support::variators::variator;

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Model {
    /// The ring deflects from its reference curve.
    Ale,
    /// The ring follows its reference curve.
    Ale0,
}

/// A variator under a load.
#[derive(Debug, Parser)]
struct Arguments {
    /// Letter of the load.
    #[arg(long, default_value = "b", value_parser = load)]
    load: LoadHistory,
    #[arg(long, default_value = "ale")]
    model: Model,
    /// Sliding speed at which friction is nearly full, m/s, if not the default.
    #[arg(long)]
    friction_velocity: Option<f64>,
    /// Geometric ratio.
    #[arg(long, default_value_t = 1.0)]
    ratio: f64,
    /// Time to simulate, s.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Number of runs.
    #[arg(long, default_value_t = 1)]
    runs: u32,
    /// File for the series.
    #[arg(long)]
    csv: Option<PathBuf>,
}

fn load(letter: &str) -> Result<LoadHistory, String> {
    LOADS
        .into_iter()
        .find(|load| letter == load.letter().to_string())
        .ok_or_else(|| format!("no load has the letter {letter:?}: give one from a to j"))
}

/// Processor time of one run, s, and its series.
fn run(arguments: &Arguments) -> Result<(Duration, String), Box<dyn Error>> {
    let ring = match arguments.model {
        Model::Ale => RingModel::Ale,
        Model::Ale0 => RingModel::Ale0,
    };
    let mut parameters = variator(ring);
    parameters.friction.velocity = arguments.friction_velocity.unwrap_or(parameters.friction.velocity);
    let mut driven = Driven::new(arguments.load, parameters, arguments.ratio);
    let steps = (arguments.seconds / arguments.load.step()).round();
    let mut series = String::from("time,primary,secondary,torque_p,torque_s,slip,belt\n");
    let mut spent = Duration::ZERO;
    for _ in 0..steps as usize {
        let inputs = driven.inputs();
        let time = driven.until();
        let clock = ThreadTime::now();
        driven.variator.advance(time, &inputs)?;
        driven.variator.outputs();
        spent += clock.elapsed();
        let o = driven.variator.outputs();
        let (p, s) = (&o.primary, &o.secondary);
        writeln!(
            series,
            "{time:.6},{},{},{},{},{},{}",
            p.speed, s.speed, p.shaft_torque, s.shaft_torque, o.slip, o.belt_speed
        )?;
    }
    Ok((spent, series))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let mut least = Duration::MAX;
    for _ in 0..arguments.runs.max(1) {
        let (spent, series) = run(&arguments)?;
        least = least.min(spent);
        if let Some(path) = &arguments.csv {
            std::fs::write(path, series)?;
        }
    }
    println!("CPU time {:.4} s", least.as_secs_f64());
    println!("{:.2} x real time", arguments.seconds / least.as_secs_f64());
    Ok(())
}
