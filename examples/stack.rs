//! The law of the stack over loads and states, and `ALE0` beside `ALE`: figures of
//! `docs/notebook/experiments.md`.
//!
//! `cargo run --release --example stack -- WHAT [--ale0] [--finer]`, WHAT being
//! - `manoeuvre`, `loads=bceg`: counts of the solver and the least push force,
//! - `states`: the least push force over ratios, torques and forces up to 7000 rpm,
//! - `levels`: 75 states of `ALE0` against `ALE`, or with `--finer` of twice the elements against
//!   the default mesh,
//! - `mirror`: thrust ratios without torque at i and 1/i, which multiply to 1 between pulleys alike
//!   and without a stack.

use std::error::Error;

use clap::Parser;
use pushbelt::pulley::PerPulley;
use pushbelt::variator::Variator;
use pushbelt::variator::settings::{Outputs, Parameters, RingModel};
use pushbelt_support::film::{Load, RATIOS, film_variator, lowest_push, outputs, steady};
use pushbelt_support::fingerprint::STEP;
use pushbelt_support::loads::{Driven, LOADS};
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::variators::variator;

/// Span of a load, s.
const SPAN: f64 = 0.5;
/// Least slip that is compared, and least idle arc, rad.
const LEAST: [f64; 2] = [0.003, 0.05];
/// Differences that are counted: of slips, relative, and of idle arcs, rad.
const BEYOND: [f64; 3] = [0.2, 0.3, 0.35];

#[derive(Parser)]
struct Options {
    what: String,
    #[arg(long)]
    ale0: bool,
    #[arg(long)]
    finer: bool,
}

type Outcome = Result<(), Box<dyn Error>>;

fn meshed(ring: RingModel, finer: bool) -> Parameters {
    let mut parameters = film_variator(ring);
    if finer {
        parameters.mesh = parameters.mesh.refined(2);
    }
    parameters
}

fn manoeuvre(ring: RingModel) -> Outcome {
    let trace = Manoeuvre::read().trace(STEP);
    let mut variator = Variator::new(Manoeuvre::variator(variator(ring)))?;
    variator.initialise(0.0, &trace[0])?;
    let mut low = f64::INFINITY;
    for (k, inputs) in trace.iter().enumerate() {
        variator.advance((k + 1) as f64 * STEP, inputs)?;
        low = low.min(lowest_push(&variator));
    }
    println!("{ring:?}: {:?}, least push force {low:.1} N", variator.counts());
    Ok(())
}

fn loads(ring: RingModel, letters: &str) -> Outcome {
    for load in LOADS.into_iter().filter(|load| letters.contains(load.letter())) {
        for &ratio in load.ratios() {
            let mut driven = Driven::new(load, variator(ring), ratio);
            let (start, mut low) = (driven.variator.counts(), f64::INFINITY);
            while driven.until() < SPAN + 0.5 * load.step() {
                driven.step();
                low = low.min(lowest_push(&driven.variator));
            }
            let counts = driven.variator.counts() - start;
            println!(
                "{} {ratio} {ring:?}: {counts:?}, least push force {low:.1} N",
                load.letter()
            );
        }
    }
    Ok(())
}

fn states(parameters: &Parameters) -> Outcome {
    for speed in [52.36, 209.44, 400.0, 733.0] {
        let (mut low, mut none) = (f64::INFINITY, 0);
        for ratio in RATIOS {
            for share in [-0.6, 0.0, 0.4, 0.8] {
                for force in [2e3, 12e3] {
                    let found = steady(parameters, ratio, speed, force, Load::Share(share))?;
                    low = low.min(found.as_ref().map_or(f64::INFINITY, lowest_push));
                    none += i32::from(found.is_none());
                }
            }
        }
        println!("{speed} rad/s: least push force {low:.1} N; {none} of 24 not steady");
    }
    Ok(())
}

/// Differences of states: relative ones of thrust ratio and slip, and of both idle arcs, rad.
fn differences(a: &Outputs, b: &Outputs) -> (f64, Option<f64>, Vec<f64>) {
    let slip = (a.slip.abs() > LEAST[0]).then(|| b.slip / a.slip - 1.0);
    let arcs = |o: &Outputs| PerPulley {
        primary: o.primary.idle_arc,
        secondary: o.secondary.idle_arc,
    };
    let (x, y) = (arcs(a), arcs(b));
    let idle = [[x.primary, y.primary], [x.secondary, y.secondary]];
    let idle = idle.iter().filter(|pair| pair.iter().any(|arc| *arc > LEAST[1]));
    let idle = idle.map(|[x, y]| y - x).collect();
    (b.thrust_ratio / a.thrust_ratio - 1.0, slip, idle)
}

fn levels(pair: &[Parameters; 2]) -> Outcome {
    let (mut thrust, mut slips, mut arcs) = (Vec::new(), Vec::new(), Vec::new());
    for ratio in [2.25, 1.5, 1.0, 1.0 / 1.5, 1.0 / 2.25] {
        for force in [6e3, 15e3, 30e3] {
            for share in [-0.5, 0.0, 0.3, 0.6, 0.8] {
                let found = [
                    outputs(&pair[0], ratio, force, Load::Share(share))?,
                    outputs(&pair[1], ratio, force, Load::Share(share))?,
                ];
                let [Some(a), Some(b)] = &found else {
                    println!("{ratio:.3} {force} N {share}: not steady");
                    continue;
                };
                let (off, slip, idle) = differences(a, b);
                println!(
                    "{ratio:.3} {force} N {share}: thrust ratio {:+.2} %, slip {slip:+.2?}, idle arcs {idle:+.2?}",
                    1e2 * off
                );
                thrust.push(off);
                slips.extend(slip);
                arcs.extend(idle);
            }
        }
    }
    let rms = |of: &[f64]| (of.iter().map(|x| x * x).sum::<f64>() / of.len() as f64).sqrt();
    let worst = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let beyond = |of: &[f64], bound: f64| of.iter().filter(|x| x.abs() > bound).count();
    println!(
        "thrust ratio rms {:.2} %, worst {:.1} % of {}; slip rms {:.1} %, beyond 20 and 30 %: {} and {} of {}; idle arcs beyond 0.35 rad: {} of {}",
        1e2 * rms(&thrust),
        1e2 * worst(&thrust),
        thrust.len(),
        1e2 * rms(&slips),
        beyond(&slips, BEYOND[0]),
        beyond(&slips, BEYOND[1]),
        slips.len(),
        beyond(&arcs, BEYOND[2]),
        arcs.len()
    );
    Ok(())
}

fn mirror(parameters: &Parameters) -> Outcome {
    for ratio in [2.25, 1.5] {
        let mut product = 1.0;
        for ratio in [ratio, 1.0 / ratio] {
            let outputs = outputs(parameters, ratio, 15e3, Load::Share(0.0))?;
            product *= outputs.map_or(f64::NAN, |o| o.thrust_ratio);
        }
        println!("{ratio}: z(i) z(1/i) - 1 = {:+.1} %", 1e2 * (product - 1.0));
    }
    Ok(())
}

fn main() -> Outcome {
    let Options { what, ale0, finer } = Options::parse();
    let ring = if ale0 { RingModel::Ale0 } else { RingModel::Ale };
    match what.split_once('=').unwrap_or((&what, "")) {
        ("manoeuvre", _) => manoeuvre(ring),
        ("loads", letters) => loads(ring, letters),
        ("states", _) => states(&meshed(ring, finer)),
        ("levels", _) if finer => levels(&[meshed(ring, false), meshed(ring, true)]),
        ("levels", _) => levels(&[RingModel::Ale, RingModel::Ale0].map(|ring| meshed(ring, false))),
        ("mirror", _) => mirror(&meshed(ring, finer)),
        _ => Err(format!("{what}: manoeuvre, loads=LETTERS, states, levels or mirror").into()),
    }
}
