//! Real time beside the accurate runs: processor time of every step, and how far outputs are off.

use cpu_time::ThreadTime;
use pushbelt::variator::settings::{Mode, Parameters, RingModel};
use pushbelt_lab::loads::{LOADS, LoadHistory};
use pushbelt_lab::tracking::trace;
use pushbelt_lab::variators::{one_cell, variator};
use serde_json::json;

use crate::tracked::{errors, exact};
use crate::{Table, quantiles};

/// Shares of their ranges by which speeds, ratio, slip and thrust ratio may be off.
const LIMITS: [f64; 5] = [0.02, 0.02, 0.02, 0.02, 0.03];

/// Rows of the table: each load at each ratio for `seconds`, with each ring.
pub fn measure(table: &mut Table, letters: &str, effort: i32, seconds: f64) {
    let (mut within, mut all) = (0, 0);
    for load in LOADS.into_iter().filter(|load| letters.contains(load.letter())) {
        for &ratio in load.ratios() {
            for (name, mut parameters) in [
                ("ALE", variator(RingModel::Ale)),
                ("ALE, one cell", one_cell(RingModel::Ale)),
                ("ALE0", variator(RingModel::Ale0)),
            ] {
                parameters.solver.effort = effort;
                within += row(table, (load, ratio), (name, parameters), seconds);
                all += LIMITS.len();
            }
        }
    }
    table.row(
        &format!("outputs within their limits, effort {effort}"),
        format!("{within} of {all}"),
        json!({"effort": effort, "within": within, "all": all}),
    );
}

/// Returns how many outputs are within their limits.
fn row(
    table: &mut Table,
    (load, ratio): (LoadHistory, f64),
    (ring, mut parameters): (&str, Parameters),
    seconds: f64,
) -> usize {
    let exact = exact((load, ratio), &parameters, seconds);
    parameters.solver.mode = Mode::RealTime;
    let mut times = Vec::new();
    let mut clock = None;
    let found = trace(load, &parameters, ratio, seconds, |driven| {
        driven.variator.outputs();
        // From the first step on: before it is the start.
        let from: Option<ThreadTime> = clock.replace(ThreadTime::now());
        times.extend(from.map(|from| from.elapsed().as_secs_f64() * 1e-3 / load.step()));
    });
    let slowest = quantiles(&times, [0.5, 0.99, 1.0]);
    let (text, off) = errors(&found, &exact);
    let first =
        |trace: &pushbelt_lab::tracking::Trace| trace.first_slip().map(|step| 1e3 * load.step() * (step + 1) as f64);
    table.row(
        &format!("{} {load:?}, ratio {ratio}, {ring}, real time", load.letter()),
        format!(
            "{} ms a tick; {}; macro-slip from {:?} ms, {:?} ms; {:.2} % of the energy unaccounted; defect {:.1e}",
            slowest.map(|time| format!("{:.2}", 1e3 * time)).join(", "),
            text,
            first(&found),
            first(&exact),
            100.0 * found.unaccounted,
            found.defect
        ),
        json!({
            "load": load.letter().to_string(),
            "ratio": ratio,
            "ring": ring,
            "seconds_a_tick": slowest,
            "errors": off,
            "first_macro_slip_ms": [first(&found), first(&exact)],
            "unaccounted": found.unaccounted,
            "defect": found.defect,
        }),
    );
    let shares = found.off(&exact).into_iter().zip(exact.ranges());
    let within = shares.zip(LIMITS).filter(|((off, range), limit)| *off <= limit * range);
    within.count()
}
