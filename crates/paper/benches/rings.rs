//! Computing time of the paper's rings compared with those of the FMU, on one core: `cargo bench --package pushbelt-paper`.
//!
//! Prints one table in about two minutes. Times are processor time of the thread, the least or the median of several runs.

use std::hint::black_box;
use std::sync::Arc;

use cpu_time::ThreadTime;
use pushbelt::solver::System;
use pushbelt::solver::arrow::{Arrow, ArrowLu};
use pushbelt::solver::newton::Counts;
use pushbelt::variator::belt_ring::{Ale, Ale0, BeltRing};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Outputs, Parameters, RingModel};
use pushbelt::variator::steady::start::{Start, kinematic_state};
use pushbelt::variator::system::VariatorSystem;
use pushbelt_lab::load_cases::{LoadCase, pair, ratio};
use pushbelt_lab::manoeuvre::Manoeuvre;
use pushbelt_lab::steady::load_case;
use pushbelt_lab::variators::{SPEED, inputs, variator};
use pushbelt_paper::belts::Rotated;
use pushbelt_paper_lab::{AbsoluteNodal, fixed_steps, rcm, run, swinging_band};

/// Communication step, s.
const STEP: f64 = 1e-3;
/// Simulated revolutions of the belt, as in `cargo fmu paper`.
const REVOLUTIONS: f64 = 0.05;

fn main() {
    nine_load_cases();
    directions("Ale", Arc::new(Ale::<2>));
    directions("Ale, A_i = [t, n]", Arc::new(Rotated::<2>));
    free_ring();
}

fn row(name: &str, figure: &str) {
    println!("{name:<58} {figure}");
}

/// Computing times of the nine load cases from their steady states, relative to `RCM`.
fn nine_load_cases() {
    let ale = variator(RingModel::Ale);
    let cases = [30.0, 50.0, 100.0].map(|torque| LoadCase::three(&ale, torque)).concat();
    let rings: [Arc<dyn BeltRing>; 3] = [rcm(), Arc::new(Ale::<2>), Arc::new(Ale0)];
    let times: Vec<[f64; 3]> = cases
        .iter()
        .map(|case| {
            let steady = load_case(&ale, case).outputs;
            rings.each_ref().map(|ring| stepping(case, &steady, ring))
        })
        .collect();
    for (name, k) in [("Ale", 1), ("Ale0", 2)] {
        let mut shares: Vec<f64> = times.iter().map(|times| times[k] / times[0]).collect();
        shares.sort_by(f64::total_cmp);
        let [least, median, most] = [0, shares.len() / 2, shares.len() - 1].map(|k| shares[k]);
        row(
            &format!("nine load cases, {REVOLUTIONS} revolutions, {name} / Rcm"),
            &format!("{median:.1e} in the median, {least:.1e} to {most:.1e}"),
        );
    }
}

/// Processor time of a load case from its steady state, median of three runs, s.
fn stepping(case: &LoadCase, steady: &Outputs, ring: &Arc<dyn BeltRing>) -> f64 {
    let mut parameters = variator(RingModel::Ale);
    parameters.initial.ratio = ratio(case.theta);
    parameters.initial.primary_speed = SPEED;
    parameters.primary.drive = Drive::Speed;
    parameters.primary.axial = Axial::Held;
    let inputs = inputs((0.0, 0.0), (-steady.secondary.shaft_torque, case.clamping));
    let span = REVOLUTIONS * parameters.geometry.belt_length / steady.belt_speed;
    let steps = (span / STEP).ceil();
    let mut times = [(); 3].map(|()| {
        let mut variator = Variator::with_ring(parameters.clone(), Arc::clone(ring)).expect("valid parameters");
        variator.initialise(0.0, &inputs).expect("a start");
        let start = ThreadTime::now();
        for k in 1..=steps as u32 {
            variator.advance(span * f64::from(k) / steps, &inputs).expect("a step");
        }
        start.elapsed().as_secs_f64()
    });
    times.sort_by(f64::total_cmp);
    times[1]
}

/// Computing time with other directions of the overlay: the manoeuvre and the parts of a step.
fn directions(name: &str, ring: Arc<dyn BeltRing>) {
    let trace = Manoeuvre::read().trace(STEP);
    let parameters = Manoeuvre::variator(variator(RingModel::Ale));
    let start = ThreadTime::now();
    let mut run = Variator::with_ring(parameters, Arc::clone(&ring)).expect("valid parameters");
    run.initialise(0.0, &trace[0]).expect("a start");
    for (k, inputs) in trace.iter().enumerate() {
        run.advance((k + 1) as f64 * STEP, inputs).expect("a step");
        black_box(run.outputs());
    }
    let time = start.elapsed().as_secs_f64();
    let span = trace.len() as f64 * STEP;
    row(
        &format!("manoeuvre of {span:.0} s in steps of 1 ms, {name}"),
        &format!("{time:.2} s, {:.1} x real time, {}", span / time, text(&run.counts())),
    );
    let pieces = pieces(&variator(RingModel::Ale), ring);
    row(
        &format!("{name}: residual, Jacobian, factors, solve"),
        &pieces.map(|t| format!("{:.1} us", 1e6 * t)).join(", "),
    );
}

/// Time of residual, Jacobian, factorization and solve, s.
fn pieces(parameters: &Parameters, ring: Arc<dyn BeltRing>) -> [f64; 4] {
    let mut system = VariatorSystem::with_ring(parameters, ring);
    let start = Start {
        ratio: 1.0,
        primary_speed: SPEED,
        clamping: pair(1e4, 1.3e4),
    };
    let state = kinematic_state(&system.belt, &start).expect("a start");
    let mut matrix = Arrow::new(system.shape());
    let mut factors = ArrowLu::new(system.shape());
    let mut residual = vec![0.0; state.y.len()];
    system.jacobian(0.0, state.view(), 1e4, 1e-4, &mut matrix);
    [
        least(|| system.residual(0.0, state.view(), black_box(&mut residual))),
        least(|| system.jacobian(0.0, state.view(), 1e4, 1e-4, black_box(&mut matrix))),
        least(|| factors.factor(black_box(&matrix)).expect("a regular matrix")),
        least(|| factors.solve(black_box(&mut residual))),
    ]
}

/// Shortest time of a call, from batches of about a millisecond, s.
fn least(mut call: impl FnMut()) -> f64 {
    let start = ThreadTime::now();
    call();
    let batch = (1e-3 / start.elapsed().as_secs_f64()).ceil().max(1.0) as usize;
    (0..50)
        .map(|_| {
            let start = ThreadTime::now();
            (0..batch).for_each(|_| call());
            start.elapsed().as_secs_f64() / batch as f64
        })
        .fold(f64::INFINITY, f64::min)
}

/// A steel band in its first bending mode. `examples/free_ring.rs` measures its frequency.
fn free_ring() {
    for step in [4e-3, 2e-3, 1e-3] {
        let runs = (0..7).map(|_| {
            let (mut system, mut state, _) = swinging_band::<AbsoluteNodal>(0.185e-3, 1e-3);
            let mut integrator = fixed_steps(&mut system, step);
            integrator.newton_tolerance = 1000.0;
            let start = ThreadTime::now();
            run(&mut system, &mut integrator, &mut state, 0.0, 0.5);
            (start.elapsed().as_secs_f64(), integrator.newton.counts)
        });
        let (seconds, counts) = runs.min_by(|a, b| a.0.total_cmp(&b.0)).expect("seven runs");
        row(
            &format!("free ring of 40 elements, Ancf, 0.5 s in steps of {} ms", 1e3 * step),
            &format!("{:.2} ms, {}", 1e3 * seconds, text(&counts)),
        );
    }
}

fn text(counts: &Counts) -> String {
    format!(
        "{} steps, {} residuals, {} factorizations",
        counts.steps, counts.residuals, counts.factorizations
    )
}
