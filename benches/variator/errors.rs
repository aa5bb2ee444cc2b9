//! Errors beside the times: of steady states against ten times the elements; of the manoeuvre
//! against twice the elements and a tenth of the tolerance, because ten times the elements take a
//! quarter of an hour there, and against ever tighter tolerances on its own mesh.

use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::RingModel;
use pushbelt::variator::settings::{Inputs, Outputs, Parameters};
use pushbelt_support::bench::STEP;
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::variators::{one_cell, variator};
use serde_json::json;

use crate::{Table, nine_steady_states};

const FINER: i32 = 10;
const FINER_IN_THE_MANOEUVRE: i32 = 2;
const TIGHTER: f64 = 0.1;

/// Largest error of the thrust ratios that were `found`; of `ALE` also with one cell in each
/// element.
pub fn of_steady_states(table: &mut Table, model: RingModel, found: &[Option<f64>]) {
    let (_, (_, fine)) = nine_steady_states(variator(model), FINER);
    thrust_ratio_row(table, &format!("{model:?}"), (found, &fine));
    if model == RingModel::Ale {
        let (_, (_, coarser)) = nine_steady_states(one_cell(model), 1);
        thrust_ratio_row(table, &format!("{model:?}, one cell"), (&coarser, &fine));
    }
}

fn thrust_ratio_row(table: &mut Table, ring: &str, (found, fine): (&[Option<f64>], &[Option<f64>])) {
    let both = found.iter().zip(fine).filter_map(|(a, b)| Some((*a)? / (*b)? - 1.0));
    let (count, largest) = both.fold((0, 0.0_f64), |(n, most), error| (n + 1, most.max(error.abs())));
    table.row(
        &format!("  their largest error of the thrust ratio, {ring}"),
        format!("{:.2} %, {count} states", 100.0 * largest),
        json!({"thrust_ratio": largest, "states": count}),
    );
}

type Read = fn(&Outputs) -> f64;
/// Outputs at each communication point.
type Rows = Vec<Vec<f64>>;

/// What is compared over the manoeuvre.
const OUTPUTS: [(&str, Read); 5] = [
    ("primary speed", |o| o.primary.speed),
    ("secondary speed", |o| o.secondary.speed),
    ("ratio", |o| o.ratio_geometric),
    ("thrust ratio", |o| o.thrust_ratio),
    ("losses", |o| o.losses.total()),
];

/// Tolerances of the ladder as parts of the default; the last is what the others are compared with.
const LADDER: [f64; 4] = [1.0, 1e-1, 1e-2, TIGHTEST];
const TIGHTEST: f64 = 1e-3;
/// Steps between which the belt has gripped and does not slip through: from 0.25 to 8.5 s.
const GRIPPING: std::ops::Range<usize> = 250..8500;
/// What is compared there too; forces ring after the belt has gripped.
const FORCES: [(&str, Read); 3] = [
    ("primary axial force", |o| o.primary.axial_force),
    ("push force", |o| o.push_force_max),
    ("primary shaft torque", |o| o.primary.shaft_torque),
];

/// Errors of outputs over the manoeuvre as shares of their ranges: means against a finer mesh, and
/// of ever tighter tolerances in the root mean square and at the worst communication point.
pub fn of_manoeuvre(table: &mut Table, model: RingModel, trace: &[Inputs]) {
    let reads: Vec<(&str, Read)> = OUTPUTS.into_iter().chain(FORCES).collect();
    let with = |tolerance: f64| {
        let mut parameters = variator(model);
        parameters.solver.tolerance *= tolerance;
        parameters
    };
    let [found @ .., exact] = LADDER.map(|tolerance| traced(with(tolerance), trace, &reads));
    let mut finer = with(TIGHTER);
    finer.mesh = finer.mesh.refined(FINER_IN_THE_MANOEUVRE);
    let fine = traced(finer, trace, &OUTPUTS);
    let errors: Vec<(&str, f64)> = OUTPUTS
        .iter()
        .enumerate()
        .map(|(k, (name, _))| (*name, off(&found[0], &fine, k).sum::<f64>() / fine.len() as f64))
        .collect();
    let text: Vec<String> = errors
        .iter()
        .map(|(name, e)| format!("{name} {:.2} %", 100.0 * e))
        .collect();
    table.row(
        &format!("  its mean errors as shares of the ranges, {model:?}"),
        text.join(", "),
        json!(errors),
    );
    for (tolerance, found) in LADDER.iter().zip(&found) {
        ladder_row(
            table,
            &reads,
            (found, &exact),
            &format!("{tolerance} of the tolerance against {TIGHTEST}, {model:?}"),
        );
    }
    // Friction that falls with sliding lets waves grow in macro-slip.
    let parts = [&found[0], &exact].map(|rows| rows[GRIPPING].to_vec());
    let name = format!("1 of it from 0.25 to 8.5 s, {model:?}");
    ladder_row(table, &reads, (&parts[0], &parts[1]), &name);
    let [found, exact] = [1.0, TIGHTEST].map(|tolerance| {
        let mut parameters = with(tolerance);
        parameters.friction.fall = 0.0;
        traced(parameters, trace, &reads)
    });
    ladder_row(
        table,
        &reads,
        (&found, &exact),
        &format!("1 of it with friction.fall = 0, {model:?}"),
    );
}

/// A row of root mean squares and largest differences.
fn ladder_row(
    table: &mut Table,
    reads: &[(&str, Read)],
    (found, exact): (&[Vec<f64>], &[Vec<f64>]),
    name: &str,
) {
    let errors: Vec<(&str, [f64; 2])> = reads
        .iter()
        .enumerate()
        .map(|(k, (name, _))| {
            let square: f64 = off(found, exact, k).map(|e| e * e).sum();
            let mean = (square / exact.len() as f64).sqrt();
            (*name, [mean, off(found, exact, k).fold(0.0, f64::max)])
        })
        .collect();
    let text: Vec<String> = errors
        .iter()
        .map(|(name, [mean, most])| format!("{name} {:.3} % ({:.2} %)", 100.0 * mean, 100.0 * most))
        .collect();
    table.row(&format!("  {name}"), text.join(", "), json!(errors));
}

/// Differences of a column as shares of the range that it should have.
fn off(found: &[Vec<f64>], exact: &[Vec<f64>], k: usize) -> impl Iterator<Item = f64> {
    let range = range(exact, k);
    found.iter().zip(exact).map(move |(a, b)| (a[k] - b[k]).abs() / range)
}

fn range(rows: &[Vec<f64>], k: usize) -> f64 {
    let column = rows.iter().map(|row| row[k]);
    column.clone().fold(f64::NEG_INFINITY, f64::max) - column.fold(f64::INFINITY, f64::min)
}

fn traced(parameters: Parameters, trace: &[Inputs], reads: &[(&str, Read)]) -> Rows {
    let mut variator = Variator::new(Manoeuvre::variator(parameters)).expect("valid parameters");
    variator.initialise(0.0, &trace[0]).expect("a start");
    let row = |(k, inputs): (usize, &Inputs)| {
        variator.advance((k + 1) as f64 * STEP, inputs).expect("a step");
        let outputs = variator.outputs();
        reads.iter().map(|(_, read)| read(outputs)).collect()
    };
    trace.iter().enumerate().map(row).collect()
}
