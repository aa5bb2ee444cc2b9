//! What loads cost that jump, ripple or are noisy, beside a smooth one: processor time of every
//! communication step.

use cpu_time::ThreadTime;
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::bench::text;
use pushbelt_support::loads::{Driven, LOADS, LoadHistory};
use pushbelt_support::variators::{one_cell, variator};
use serde_json::json;

use crate::{Table, numbers, quantiles};

/// A step that takes longer than this is counted, s.
const LONG: f64 = 1e-3;

/// Rows of the table: each load at each ratio for `seconds`, with each ring, jumping and over the
/// default ramp.
pub fn measure(table: &mut Table, letters: &str, seconds: f64) {
    for load in LOADS.into_iter().filter(|load| letters.contains(load.letter())) {
        for &ratio in load.ratios() {
            for (name, parameters) in rings() {
                for ramp in [0.0, parameters.solver.input_ramp] {
                    let mut parameters = parameters.clone();
                    parameters.solver.input_ramp = ramp;
                    row(table, (load, ratio), (name, parameters), seconds);
                }
            }
        }
    }
}

/// The rings that are compared, by name.
pub fn rings() -> [(&'static str, Parameters); 3] {
    [
        ("ALE", variator(RingModel::Ale)),
        ("ALE, one cell", one_cell(RingModel::Ale)),
        ("ALE0", variator(RingModel::Ale0)),
    ]
}

fn row(
    table: &mut Table,
    (load, ratio): (LoadHistory, f64),
    (ring, parameters): (&str, Parameters),
    seconds: f64,
) {
    let shape = if parameters.solver.input_ramp == 0.0 {
        "jumping"
    } else {
        "ramped"
    };
    let mut driven = Driven::new(load, parameters, ratio);
    let start = driven.variator.counts();
    let steps = (seconds / load.step()).round().max(1.0) as usize;
    let mut times = Vec::with_capacity(steps);
    for _ in 0..steps {
        let inputs = driven.inputs();
        let clock = ThreadTime::now();
        driven.variator.advance(driven.until(), &inputs).expect("a step");
        driven.variator.outputs();
        times.push(clock.elapsed().as_secs_f64());
    }
    let total: f64 = times.iter().sum();
    let factor = seconds / total;
    let slowest = quantiles(&times, [0.5, 0.99, 0.999, 1.0]);
    let long = times.iter().filter(|&&time| time > LONG).count() as f64 / steps as f64;
    let counts = driven.variator.counts() - start;
    table.row(
        &format!("{} {load:?}, ratio {ratio}, {ring}, {shape}", load.letter()),
        format!(
            "{factor:.2} x real time; {} ms; {:.0} % above 1 ms; {}",
            slowest.map(|time| format!("{:.2}", 1e3 * time)).join(", "),
            100.0 * long,
            text(&counts)
        ),
        json!({
            "load": load.letter().to_string(),
            "ratio": ratio,
            "ring": ring,
            "inputs": shape,
            "real_time_factor": factor,
            "seconds": slowest,
            "above_1_ms": long,
            "counts": numbers(&counts),
        }),
    );
}
