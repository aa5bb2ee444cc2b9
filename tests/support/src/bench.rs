//! What the benchmarks share: rows of their tables, and times of manoeuvres and of the parts of a
//! step. Times are processor time of the thread.

use crate::load_cases::pair;
use crate::variators::SPEED;
use cpu_time::ThreadTime;
use pushbelt::solver::System;
use pushbelt::solver::arrow::{Arrow, ArrowLu};
use pushbelt::solver::newton::Counts;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Inputs;
use pushbelt::variator::steady::start::{Start, kinematic_state};
use pushbelt::variator::system::VariatorSystem;
use std::hint::black_box;

/// Communication step of the manoeuvre, s.
pub const STEP: f64 = 1e-3;

pub fn print_row(name: &str, figure: &str) {
    println!("{name:<58} {figure}");
}

/// Name and figure of the row for a manoeuvre that took `time`, s.
pub fn manoeuvre_row(name: &str, trace: &[Inputs], time: f64, counts: &Counts) -> (String, String) {
    let span = trace.len() as f64 * STEP;
    (
        format!("manoeuvre of {span:.0} s in steps of 1 ms, {name}"),
        format!("{time:.2} s, {:.1} x real time, {}", span / time, text(counts)),
    )
}

/// Name and figure of the row for [`step_parts`].
pub fn step_parts_row(name: &str, seconds: [f64; 4]) -> (String, String) {
    (
        format!("{name}: residual, Jacobian, factors, solve"),
        seconds.map(|t| format!("{:.1} us", 1e6 * t)).join(", "),
    )
}

/// Work of a run in words.
pub fn text(counts: &Counts) -> String {
    let [steps, residuals, factors] = [counts.steps, counts.residuals, counts.factorizations];
    format!("{steps} steps, {residuals} residuals, {factors} factorizations")
}

/// Time and work of a manoeuvre with the variator of `build`; `around` is called with each
/// communication step.
pub fn manoeuvre(
    build: impl FnOnce() -> Variator,
    trace: &[Inputs],
    mut around: impl FnMut(&mut dyn FnMut()),
) -> (f64, Counts) {
    let start = ThreadTime::now();
    let mut variator = build();
    variator.initialise(0.0, &trace[0]).expect("a start");
    for (k, inputs) in trace.iter().enumerate() {
        around(&mut || {
            variator.advance((k + 1) as f64 * STEP, inputs).expect("a step");
            black_box(variator.outputs());
        });
    }
    (start.elapsed().as_secs_f64(), variator.counts())
}

/// Time of residual, Jacobian, factorization and solve at a kinematic state, s.
pub fn step_parts(system: &mut VariatorSystem) -> [f64; 4] {
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
