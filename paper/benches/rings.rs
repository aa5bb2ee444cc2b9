//! Computing time of the paper's rings compared with those of the FMU, on one core: `cargo bench
//! --package pushbelt-paper`.
//!
//! Prints one table in about two minutes. Times are processor time of the thread, the least or the
//! median of several runs.

use std::sync::Arc;

use cpu_time::ThreadTime;
use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Outputs, RingModel};
use pushbelt::variator::system::VariatorSystem;
use pushbelt_paper::belts::Rotated;
use pushbelt_paper_lab::{AbsoluteNodal, fixed_steps, rcm, run, swinging_band};
use pushbelt_support::bench::{STEP, manoeuvre, manoeuvre_row, print_row, step_parts, step_parts_row, text};
use pushbelt_support::load_cases::{LoadCase, ratio};
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::steady::load_case;
use pushbelt_support::variators::{SPEED, inputs, variator};

/// Simulated revolutions of the belt, as in `cargo fmu paper`.
const REVOLUTIONS: f64 = 0.05;

fn main() {
    nine_load_cases();
    directions("Ale", Arc::new(Ale::<2>));
    directions("Ale, A_i = [t, n]", Arc::new(Rotated::<2>));
    free_ring();
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
        print_row(
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
        let mut variator =
            Variator::with_ring(parameters.clone(), Arc::clone(ring)).expect("valid parameters");
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
    let build = || {
        let parameters = Manoeuvre::variator(variator(RingModel::Ale));
        Variator::with_ring(parameters, Arc::clone(&ring)).expect("valid parameters")
    };
    let (time, counts) = manoeuvre(build, &trace, |advance| advance());
    let (title, figure) = manoeuvre_row(name, &trace, time, &counts);
    print_row(&title, &figure);
    let mut system = VariatorSystem::with_ring(&variator(RingModel::Ale), ring);
    let (title, figure) = step_parts_row(name, step_parts(&mut system));
    print_row(&title, &figure);
}

/// A steel band in its first bending mode. `examples/free_ring.rs` measures its frequency.
fn free_ring() {
    for step in [4e-3, 2e-3, 1e-3] {
        let runs = (0..7).map(|_| {
            let band = swinging_band::<AbsoluteNodal>(0.185e-3, 1e-3);
            let (mut system, mut state) = (band.system, band.state);
            let mut integrator = fixed_steps(&mut system, step);
            integrator.newton_tolerance = 1000.0;
            let start = ThreadTime::now();
            run(&mut system, &mut integrator, &mut state, 0.0, 0.5);
            (start.elapsed().as_secs_f64(), integrator.newton.counts)
        });
        let (seconds, counts) = runs.min_by(|a, b| a.0.total_cmp(&b.0)).expect("seven runs");
        print_row(
            &format!("free ring of 40 elements, Ancf, 0.5 s in steps of {} ms", 1e3 * step),
            &format!("{:.2} ms, {}", 1e3 * seconds, text(&counts)),
        );
    }
}
