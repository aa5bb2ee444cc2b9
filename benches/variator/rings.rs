//! The ring models beside each other: in the variator, and alone.

use cpu_time::ThreadTime;
use pushbelt::reference_curve::Circle;
use pushbelt::ring::Ring;
use pushbelt::ring::ancf::Ancf;
use pushbelt::ring::system::RingSystem;
use pushbelt::solver::sdirk::Sdirk;
use pushbelt::variator::instance::Variator;
use pushbelt::variator::parameters::{Axial, Drive, RingModel};
use serde_json::json;
use std::f64::consts::TAU;

use crate::common::{LoadCase, SPEED, inputs, load_case, ratio, variator};
use crate::{STEP, Table};

/// Revolutions of the belt that are run, as in `cargo fmu paper`.
const REVOLUTIONS: f64 = 0.05;
/// How often; the median counts.
const RUNS: usize = 3;

/// Rows of the table: nine load cases from their steady state, and a free ring.
pub fn measure(table: &mut Table) {
    let cases: Vec<Vec<f64>> = [30.0, 50.0, 100.0]
        .map(|torque| LoadCase::three(&variator(RingModel::Ale), torque))
        .concat()
        .iter()
        .map(|case| {
            [RingModel::Rcm, RingModel::Ale, RingModel::Ale0]
                .map(|model| stepping(case, model))
                .to_vec()
        })
        .collect();
    for (model, k) in [(RingModel::Ale, 1), (RingModel::Ale0, 2)] {
        let mut shares: Vec<f64> = cases.iter().map(|times| times[k] / times[0]).collect();
        shares.sort_by(f64::total_cmp);
        let [least, median, most] = [0, shares.len() / 2, shares.len() - 1].map(|k| shares[k]);
        table.row(
            &format!("nine load cases, {REVOLUTIONS} revolutions, {model:?} / Rcm"),
            format!("{median:.1e} in the median, {least:.1e} to {most:.1e}"),
            json!({"median": median, "least": least, "most": most}),
        );
    }
    free_ring(table);
}

/// Processor time of a load case's steps from its steady state, s.
fn stepping(case: &LoadCase, model: RingModel) -> f64 {
    let parameters = variator(model);
    let steady = load_case(&variator(RingModel::Ale), case).outputs;
    let inputs = inputs((0.0, 0.0), (-steady.secondary.shaft_torque, case.clamping));
    let span = REVOLUTIONS * parameters.geometry.belt_length / steady.belt_speed;
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let mut parameters = parameters.clone();
            parameters.initial.ratio = ratio(case.theta);
            parameters.initial.primary_speed = SPEED;
            parameters.primary.drive = Drive::Speed;
            parameters.primary.axial = Axial::Held;
            let mut variator = Variator::new(parameters).expect("valid parameters");
            variator.initialise(0.0, &inputs).expect("a start");
            let start = ThreadTime::now();
            let steps = (span / STEP).ceil();
            for k in 1..=steps as u32 {
                variator.advance(span * f64::from(k) / steps, &inputs).expect("a step");
            }
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

/// A steel band in its first bending mode, as in `examples/free_ring.rs`, which measures its frequency too.
fn free_ring(table: &mut Table) {
    const RADIUS: f64 = 0.70 / TAU;
    let (young, area) = (2.1e11, 9.5e-3 * 0.185e-3);
    let ring = Ring {
        mass_per_length: 7800.0 * area,
        axial_stiffness: young * area,
        bending_stiffness: young * area * 0.185e-3_f64.powi(2) / 12.0,
        lateral_bending_stiffness: 0.0,
        damping: 0.0,
    };
    for step in [4e-3, 2e-3, 1e-3] {
        let (seconds, counts) = (0..7)
            .map(|_| {
                let mut system = RingSystem::new(Ancf::new(ring.clone(), Circle { radius: RADIUS }, 40, 3));
                let mut state = system.rest(0.0);
                let speed = 1.0e-3 * RADIUS * TAU * 9.534;
                let swing = |xi: f64| {
                    let ((sin, cos), (sin2, cos2)) = ((xi / RADIUS).sin_cos(), (2.0 * xi / RADIUS).sin_cos());
                    [-cos * cos2 - 0.5 * sin * sin2, sin * cos2 - 0.5 * cos * sin2]
                        .map(|v| v * speed)
                        .into()
                };
                system.set_in_motion(&mut state, swing).expect("a ring with mass");
                let mut integrator = Sdirk::new(&system, step, step);
                integrator.newton_tolerance = 1000.0;
                let start = ThreadTime::now();
                for k in 0..(0.5 / step) as u32 {
                    let time = f64::from(k) * step;
                    integrator
                        .advance(&mut system, &mut state, time, time + step)
                        .expect("a step");
                }
                (start.elapsed().as_secs_f64(), integrator.newton.counts)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("several runs");
        table.row(
            &format!("free ring of 40 elements, Ancf, 0.5 s in steps of {} ms", 1e3 * step),
            format!("{:.2} ms, {}", 1e3 * seconds, crate::text(&counts)),
            json!({"seconds": seconds, "counts": crate::numbers(&counts)}),
        );
    }
}
