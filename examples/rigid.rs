//! Mesh errors of thrust ratio and slip over ratio and torque, with rigid sheaves or with those that
//! tilt: the default mesh, also with `--arcs` elements on each arc, beside one with `--times` as many
//! elements. Figures of `docs/notebook/experiments.md`.
//!
//! `cargo run --release --example rigid [-- --tilting] [--ale0] [--force N] [--speed RAD_PER_S]
//! [--arcs 16] [--times 3] [--entry]`; `--entry` prints the contact where the belt enters the primary
//! arc.

use std::error::Error;

use clap::Parser;
use pushbelt::pulley::Pulley;
use pushbelt::variator::Variator;
use pushbelt::variator::settings::RingModel;
use pushbelt_support::film::{Load, film_variator, steady};
use pushbelt_support::steady::stations;
use pushbelt_support::variators::{SPEED, rigid};

/// r_S/r_P.
const RATIOS: [f64; 5] = [0.444, 0.667, 1.0, 1.5, 2.25];
/// Torques over that of full slip.
const SHARES: [f64; 3] = [0.0, 0.3, 0.6];
/// Length of the printed part of the belt, before and behind the start of the arc, m.
const ENTRY: f64 = 0.01;

#[derive(Parser)]
struct Options {
    /// Sheaves that tilt
    #[arg(long)]
    tilting: bool,
    #[arg(long)]
    ale0: bool,
    /// Secondary clamping force, N
    #[arg(long, default_value_t = 15e3)]
    force: f64,
    /// Primary speed, rad/s
    #[arg(long, default_value_t = SPEED)]
    speed: f64,
    /// Elements on each arc of the coarser mesh
    #[arg(long)]
    arcs: Option<i32>,
    /// Elements of the finer mesh, over those of the default one
    #[arg(long, default_value_t = 3)]
    times: i32,
    /// Contact at the entry of the primary arc
    #[arg(long)]
    entry: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let ring = if options.ale0 { RingModel::Ale0 } else { RingModel::Ale };
    let mut parameters = film_variator(ring);
    if !options.tilting {
        parameters = rigid(parameters);
    }
    let mut meshes = [1, options.times].map(|times| parameters.mesh.refined(times));
    if let Some(arcs) = options.arcs {
        (meshes[0].primary_arc, meshes[0].secondary_arc) = (arcs, arcs);
    }
    let (mut thrust, mut slip, mut work) = (Vec::new(), Vec::new(), [(0, 0); 2]);
    println!(
        "| r_S/r_P | torque | thrust ratios | error, % | slip, % | error, % |\n|---|---|---|---|---|---|"
    );
    for ratio in RATIOS {
        for share in SHARES {
            let mut found = Vec::new();
            for (mesh, work) in meshes.iter().zip(&mut work) {
                parameters.mesh = mesh.clone();
                let load = Load::Share(share);
                let Some(mut variator) = steady(&parameters, ratio, options.speed, options.force, load)?
                else {
                    break;
                };
                let counts = variator.start_work();
                *work = (work.0 + counts.residuals, work.1 + counts.factorizations);
                if options.entry {
                    entry(&variator);
                }
                let outputs = variator.outputs();
                found.push([outputs.thrust_ratio, outputs.slip]);
            }
            let &[[default, slips], [fine, fine_slips]] = &found[..] else {
                println!("| {ratio} | {share} | not found |");
                continue;
            };
            let errors = [default / fine - 1.0, slips / fine_slips - 1.0].map(|error| 100.0 * error);
            thrust.push(errors[0]);
            if share > 0.0 {
                slip.push(errors[1]);
            }
            println!(
                "| {ratio} | {share} | {default:.4}, {fine:.4} | {:+.2} | {:.3}, {:.3} | {:+.1} |",
                errors[0],
                100.0 * slips,
                100.0 * fine_slips,
                errors[1]
            );
        }
    }
    println!(
        "\nthrust ratio {}, slip under torque {}",
        summary(&thrust),
        summary(&slip)
    );
    println!("residuals and factorizations of the starts: {work:?}");
    Ok(())
}

/// Root mean square and largest magnitude.
fn summary(errors: &[f64]) -> String {
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    let most = errors.iter().fold(0.0_f64, |most, error| most.max(error.abs()));
    format!("{rms:.2} % rms, {most:.2} % at most")
}

/// Prints the stations around the start of the primary arc.
fn entry(variator: &Variator) {
    let stations = stations(variator.system(), variator.state());
    let mut on_arc = stations
        .iter()
        .filter(|at| at.pulley == Pulley::Primary && at.sample.on_arc());
    let Some(start) = on_arc.next().map(|at| at.sample.xi) else {
        return;
    };
    println!("place, mm; pitch radius, mm; curvature, 1/m; normal force, N/m; sliding, m/s");
    for sample in stations
        .iter()
        .map(|at| &at.sample)
        .filter(|s| (s.xi - start).abs() < ENTRY)
    {
        println!(
            "{:7.3} {:9.5} {:6.2} {:8.0} {:8.5}",
            1e3 * (sample.xi - start),
            1e3 * sample.pitch_radius,
            sample.ring_curvature,
            sample.normal,
            sample.sliding
        );
    }
}
