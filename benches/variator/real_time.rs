//! Real time beside accurate runs: work and processor time of a millisecond, how far outputs are
//! off, and how late they are.

use cpu_time::ThreadTime;
use pushbelt::variator::settings::{Mode, Parameters};
use pushbelt_support::loads::{Driven, LOADS, LoadHistory};
use pushbelt_support::meter::Meter;
use pushbelt_support::tracking::{Trace, trace};
use serde_json::json;

use crate::loads::rings;
use crate::tracked::{errors, exact};
use crate::{Table, quantiles};

/// Shares of their ranges by which speeds, ratio, slip and thrust ratio may be off.
const LIMITS: [f64; 5] = [0.02, 0.02, 0.02, 0.02, 0.03];

/// What is measured of the runs with an effort.
#[derive(Default)]
struct Found {
    within: usize,
    all: usize,
    /// Work, units, processor time, s, and delay, s, of each millisecond.
    work: Vec<f64>,
    times: Vec<f64>,
    behind: Vec<f64>,
    unaccounted: f64,
}

/// Rows of the table: each load at each ratio for `seconds`, with each ring and effort.
pub fn measure(table: &mut Table, letters: &str, efforts: &[i32], seconds: f64) {
    let rings = rings();
    let mut sums: Vec<_> = rings
        .iter()
        .map(|_| efforts.iter().map(|_| Found::default()).collect::<Vec<_>>())
        .collect();
    for load in LOADS.into_iter().filter(|load| letters.contains(load.letter())) {
        for &ratio in load.ratios() {
            for ((name, parameters), sums) in rings.iter().zip(&mut sums) {
                let exact = exact((load, ratio), parameters, seconds);
                for (&effort, sum) in efforts.iter().zip(sums) {
                    let mut parameters = parameters.clone();
                    parameters.solver.effort = effort;
                    row(table, sum, (load, ratio), (name, parameters), &exact);
                }
            }
        }
    }
    for (k, &effort) in efforts.iter().enumerate() {
        let sums = || sums.iter().map(|sums| &sums[k]);
        for ((name, _), sum) in rings.iter().zip(sums()) {
            summary(table, &format!("{name}, effort {effort}"), effort, sum);
        }
        let (within, all) = sums().fold((0, 0), |(within, all), sum| (within + sum.within, all + sum.all));
        table.row(
            &format!("all rings, effort {effort}: outputs within their limits"),
            format!("{within} of {all}"),
            json!({"effort": effort, "within": within, "all": all}),
        );
    }
}

fn row(
    table: &mut Table,
    sum: &mut Found,
    (load, ratio): (LoadHistory, f64),
    (ring, mut parameters): (&str, Parameters),
    exact: &Trace,
) {
    let effort = parameters.solver.effort;
    let seconds = exact.rows.len() as f64 * load.step();
    parameters.solver.mode = Mode::RealTime;
    let a_millisecond = 1e-3 / load.step();
    let (mut work, mut times, mut behind) = (Vec::new(), Vec::new(), Vec::new());
    let mut meter = Meter::new(&Driven::new(load, parameters.clone(), ratio).variator);
    let mut clock = None;
    let found = trace(load, &parameters, ratio, seconds, |driven| {
        behind.push(driven.variator.outputs().work.behind);
        work.push(meter.read(&driven.variator) * a_millisecond);
        // From the first step on: before it is the start.
        let from: Option<ThreadTime> = clock.replace(ThreadTime::now());
        times.extend(from.map(|from| from.elapsed().as_secs_f64() * a_millisecond));
    });
    let slowest = quantiles(&times, [0.5, 0.99, 1.0]);
    let units = quantiles(&work, [0.5, 0.99, 1.0]);
    let latest = behind.iter().copied().fold(0.0, f64::max);
    let (text, off) = errors(&found, exact);
    let first = |trace: &Trace| trace.first_slip().map(|step| 1e3 * load.step() * (step + 1) as f64);
    table.row(
        &format!("{} {load:?}, ratio {ratio}, {ring}, effort {effort}", load.letter()),
        format!(
            "{} units and {} ms a millisecond; behind by {:.1} ms at most; {text}; macro-slip from {:?} ms, {:?} ms; {:.3} % of the energy unaccounted; defect {:.1e}",
            units.map(|units| format!("{units:.0}")).join(", "),
            slowest.map(|time| format!("{:.2}", 1e3 * time)).join(", "),
            1e3 * latest,
            first(&found),
            first(exact),
            100.0 * found.unaccounted,
            found.defect
        ),
        json!({
            "load": load.letter().to_string(),
            "ratio": ratio,
            "ring": ring,
            "effort": effort,
            "units_a_millisecond": units,
            "seconds_a_millisecond": slowest,
            "behind": latest,
            "errors": off,
            "first_macro_slip_ms": [first(&found), first(exact)],
            "unaccounted": found.unaccounted,
            "defect": found.defect,
        }),
    );
    let shares = found.off(exact).into_iter().zip(exact.ranges());
    sum.within += shares
        .zip(LIMITS)
        .filter(|((off, range), limit)| *off <= limit * range)
        .count();
    sum.all += LIMITS.len();
    sum.work.extend(work);
    sum.times.extend(times);
    sum.behind.extend(behind);
    sum.unaccounted = sum.unaccounted.max(found.unaccounted.abs());
}

/// What all loads together show.
fn summary(table: &mut Table, name: &str, effort: i32, sum: &Found) {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let [high, peak] = quantiles(&sum.work, [0.999, 1.0]);
    let unit = sum.times.iter().sum::<f64>() / sum.work.iter().sum::<f64>();
    let late = sum.behind.iter().filter(|behind| **behind > 0.0).count() as f64 / sum.behind.len() as f64;
    let latest = sum.behind.iter().copied().fold(0.0, f64::max);
    table.row(
        name,
        format!(
            "{} of {} outputs within their limits; {:.1} units in the mean, {high:.0} at 99.9 %, {peak:.0} at most; {:.1} us a unit; \
             behind in {:.1} % of the steps, by {:.1} ms at most; {:.3} % of the energy unaccounted",
            sum.within,
            sum.all,
            mean(&sum.work),
            1e6 * unit,
            100.0 * late,
            1e3 * latest,
            100.0 * sum.unaccounted
        ),
        json!({
            "effort": effort,
            "within": sum.within,
            "all": sum.all,
            "units": {"mean": mean(&sum.work), "99.9 %": high, "peak": peak},
            "seconds_a_unit": unit,
            "behind": {"share": late, "longest": latest},
            "unaccounted": sum.unaccounted,
        }),
    );
}
