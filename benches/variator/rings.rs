//! The ring models beside each other: in the variator, and alone.

use cpu_time::ThreadTime;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Outputs;
use pushbelt::variator::settings::{Axial, Drive, RingModel};
use pushbelt_lab::load_cases::{LoadCase, ratio};
use pushbelt_lab::ring::{AbsoluteNodal, fixed_steps, run, swinging_band};
use pushbelt_lab::steady::load_case;
use pushbelt_lab::variators::{SPEED, inputs, variator};
use serde_json::json;

use crate::{STEP, Table, best, numbers, quantiles, text};

/// Revolutions of the belt that are run, as in `cargo fmu paper`.
const REVOLUTIONS: f64 = 0.05;

/// Rows of the table: nine load cases from their steady state, and a free ring.
pub fn measure(table: &mut Table) {
    let ale = variator(RingModel::Ale);
    let cases = [30.0, 50.0, 100.0].map(|torque| LoadCase::three(&ale, torque)).concat();
    let times: Vec<[f64; 3]> = cases
        .iter()
        .map(|case| {
            let steady = load_case(&ale, case).outputs;
            [RingModel::Rcm, RingModel::Ale, RingModel::Ale0].map(|model| stepping(case, &steady, model))
        })
        .collect();
    for (model, k) in [(RingModel::Ale, 1), (RingModel::Ale0, 2)] {
        let shares: Vec<f64> = times.iter().map(|times| times[k] / times[0]).collect();
        let [least, median, most] = quantiles(&shares, [0.0, 0.5, 1.0]);
        table.row(
            &format!("nine load cases, {REVOLUTIONS} revolutions, {model:?} / Rcm"),
            format!("{median:.1e} in the median, {least:.1e} to {most:.1e}"),
            json!({"median": median, "least": least, "most": most}),
        );
    }
    free_ring(table);
}

/// Processor time of a load case's steps from its steady state, the median of three, s.
fn stepping(case: &LoadCase, steady: &Outputs, model: RingModel) -> f64 {
    let mut parameters = variator(model);
    parameters.initial.ratio = ratio(case.theta);
    parameters.initial.primary_speed = SPEED;
    parameters.primary.drive = Drive::Speed;
    parameters.primary.axial = Axial::Held;
    let inputs = inputs((0.0, 0.0), (-steady.secondary.shaft_torque, case.clamping));
    let span = REVOLUTIONS * parameters.geometry.belt_length / steady.belt_speed;
    let steps = (span / STEP).ceil();
    let times = [(); 3].map(|()| {
        let mut variator = Variator::new(parameters.clone()).expect("valid parameters");
        variator.initialise(0.0, &inputs).expect("a start");
        let start = ThreadTime::now();
        for k in 1..=steps as u32 {
            variator.advance(span * f64::from(k) / steps, &inputs).expect("a step");
        }
        start.elapsed().as_secs_f64()
    });
    quantiles(&times, [0.5])[0]
}

/// A steel band in its first bending mode. `examples/free_ring.rs` measures its frequency.
fn free_ring(table: &mut Table) {
    for step in [4e-3, 2e-3, 1e-3] {
        let (seconds, counts) = best(7, || {
            let (mut system, mut state, _) = swinging_band::<AbsoluteNodal>(0.185e-3, 1e-3);
            let mut integrator = fixed_steps(&mut system, step);
            integrator.newton_tolerance = 1000.0;
            let start = ThreadTime::now();
            run(&mut system, &mut integrator, &mut state, 0.0, 0.5);
            (start.elapsed().as_secs_f64(), integrator.newton.counts)
        });
        table.row(
            &format!("free ring of 40 elements, Ancf, 0.5 s in steps of {} ms", 1e3 * step),
            format!("{:.2} ms, {}", 1e3 * seconds, text(&counts)),
            json!({"seconds": seconds, "counts": numbers(&counts)}),
        );
    }
}
