//! How far outputs are off under a load, beside a run of a tight tolerance.

use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::loads::{LOADS, LoadHistory};
use pushbelt_support::tracking::{TRACKED, Trace, trace};
use pushbelt_support::variators::variator;
use serde_json::{Value, json};

use crate::Table;

/// Tolerance of the runs that are compared with.
const EXACT: f64 = 1e-6;

/// Tolerances that users may choose: the default and a coarser one.
const CHOSEN: [f64; 2] = [1e-4, 1e-3];

/// The run with that tolerance.
pub fn exact((load, ratio): (LoadHistory, f64), parameters: &Parameters, seconds: f64) -> Trace {
    let mut exact = parameters.clone();
    exact.solver.tolerance = EXACT;
    trace(load, &exact, ratio, seconds, |_| ())
}

/// Root mean squares of the differences beside the ranges, of each output; as text, too.
pub fn errors(found: &Trace, exact: &Trace) -> (String, Value) {
    let rows: Vec<_> = TRACKED
        .iter()
        .zip(found.off(exact).into_iter().zip(exact.ranges()))
        .map(|((name, _), (off, range))| (name, off, range))
        .collect();
    let text: Vec<String> = rows
        .iter()
        .map(|(name, off, range)| format!("{name} {off:.2e} of {range:.2e}"))
        .collect();
    let data = rows
        .iter()
        .map(|(name, off, range)| json!({"output": name, "off": off, "range": range}))
        .collect();
    (text.join(", "), data)
}

/// Rows of the table: each load at each ratio for `seconds`, with each ring and tolerance.
pub fn measure(table: &mut Table, letters: &str, seconds: f64) {
    for load in LOADS.into_iter().filter(|load| letters.contains(load.letter())) {
        for &ratio in load.ratios() {
            for ring in [RingModel::Ale, RingModel::Ale0] {
                let mut parameters = variator(ring);
                let exact = exact((load, ratio), &parameters, seconds);
                for tolerance in CHOSEN {
                    parameters.solver.tolerance = tolerance;
                    let found = trace(load, &parameters, ratio, seconds, |_| ());
                    let (text, off) = errors(&found, &exact);
                    table.row(
                        &format!("{} {load:?}, ratio {ratio}, {ring:?}, {tolerance:e}", load.letter()),
                        format!("{text}; {:.3} % of the energy unaccounted", 100.0 * found.unaccounted),
                        json!({
                            "load": load.letter().to_string(),
                            "ratio": ratio,
                            "ring": format!("{ring:?}"),
                            "tolerance": tolerance,
                            "errors": off,
                            "unaccounted": found.unaccounted,
                        }),
                    );
                }
            }
        }
    }
}
