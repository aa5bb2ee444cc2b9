//! Runs of the variator: the manoeuvre's books, tolerance, communication steps, repeatability, counts.

mod common;

use common::{MODELS, Manoeuvre, Run, assert_close, assert_pinned, coarse, inputs, variator};
use pushbelt::variator::parameters::{Parameters, RingModel};
use pushbelt::variator::signals::{Inputs, Outputs};

/// Communication step of the manoeuvre, s.
const STEP: f64 = 1e-2;

/// A run of the manoeuvre over the given spans of its clock. Between spans the clock jumps.
fn drive(parameters: Parameters, spans: &[(f64, f64)], mut see: impl FnMut(f64, &Outputs)) -> Run {
    let manoeuvre = Manoeuvre::read();
    let mut run = Run::new(Manoeuvre::variator(parameters), manoeuvre.at(spans[0].0));
    for &(from, to) in spans {
        let steps = ((to - from) / STEP).round() as u32;
        for k in 0..steps {
            let clock = from + f64::from(k) * STEP;
            run.inputs = manoeuvre.at(clock);
            let outputs = run.go(STEP, STEP);
            see(clock + STEP, &outputs);
        }
    }
    run
}

/// Launch from standstill, shift to overdrive, torque steps, over-torque, recovery: at every output point energy is
/// accounted for, |residual| ≤ 2e-3·∫|power| dt + 1e-3·(largest stored energy), and no element is lost.
#[test]
fn the_whole_manoeuvre_keeps_its_books_ale0() {
    let (mut fastest, mut slipped, mut last) = (0.0_f64, false, Outputs::default());
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    let run = drive(variator(RingModel::Ale0), &[(0.0, 10.0)], |clock, o| {
        fastest = fastest.max(o.primary.speed);
        slipped |= o.macro_slip && clock > 8.5;
        low = low.min(o.ratio_geometric);
        high = high.max(o.ratio_geometric);
        last = o.clone();
    });
    println!(
        "ratio {low:.3} to {high:.3}, {fastest:.0} rad/s at most; residual {:.3} of what is allowed, amount {:.1e}; {:?}",
        run.residual,
        run.amount_change,
        run.variator.counts()
    );
    assert!(fastest > 100.0 && slipped);
    assert!(
        !last.macro_slip && last.slip.abs() < 0.03,
        "slip {} at the end",
        last.slip
    );
    run.assert_books();
}

/// The same for the deflecting ring over launch and over-torque.
#[test]
fn launch_and_over_torque_keep_their_books_ale() {
    let (mut slipped, mut last) = (false, Outputs::default());
    let run = drive(variator(RingModel::Ale), &[(0.0, 0.6), (8.4, 9.2)], |clock, o| {
        slipped |= o.macro_slip && clock > 8.5;
        last = o.clone();
    });
    println!(
        "{:.0} rad/s, slip {:.4} at the end; residual {:.3} of what is allowed, amount {:.1e}; {:?}",
        last.primary.speed,
        last.slip,
        run.residual,
        run.amount_change,
        run.variator.counts()
    );
    assert!(slipped && !last.macro_slip && last.slip.abs() < 0.03);
    run.assert_books();
}

/// Outputs whose change a user would see.
fn watched(o: &Outputs) -> [f64; 7] {
    [
        o.ratio_geometric,
        o.primary.speed,
        o.secondary.speed,
        o.belt_speed,
        o.thrust_ratio,
        o.primary.axial_force,
        o.push_force_max,
    ]
}

const NAMES: [&str; 7] = [
    "ratio",
    "primary speed",
    "secondary speed",
    "belt speed",
    "thrust ratio",
    "primary axial force",
    "push force",
];

/// Differences of two records as shares of each output's range: root mean square, and the largest.
fn differences(a: &[[f64; 7]], b: &[[f64; 7]]) -> [(f64, f64); 7] {
    std::array::from_fn(|k| {
        let range = |f: fn(f64, f64) -> f64| a.iter().map(|row| row[k]).reduce(f).expect("rows");
        let span = range(f64::max) - range(f64::min);
        let off = a.iter().zip(b).map(|(x, y)| (x[k] - y[k]).abs() / span);
        let square: f64 = off.clone().map(|d| d * d).sum();
        ((square / a.len() as f64).sqrt(), off.fold(0.0, f64::max))
    })
}

/// A tolerance ten times tighter changes outputs of launch and shift by less than 0.2 % of their range.
fn tighter_tolerance(model: RingModel, spans: &[(f64, f64)]) {
    let [a, b] = [1.0, 0.1].map(|factor| {
        let mut parameters = coarse(model);
        parameters.solver.tolerance *= factor;
        let mut rows = Vec::new();
        let run = drive(parameters, spans, |_, o| rows.push(watched(o)));
        println!("{model:?} tolerance × {factor}: {:?}", run.variator.counts());
        rows
    });
    for (name, (mean, most)) in NAMES.iter().zip(differences(&a, &b)) {
        println!(
            "{model:?} {name}: {:.3} % in the mean, {:.3} % at most",
            100.0 * mean,
            100.0 * most
        );
        assert!(mean < 2e-3, "{model:?} {name}: {mean}");
    }
}

#[test]
fn a_tighter_tolerance_changes_little_ale0() {
    tighter_tolerance(RingModel::Ale0, &[(0.0, 3.0)]);
}

#[test]
fn a_tighter_tolerance_changes_little_ale() {
    tighter_tolerance(RingModel::Ale, &[(0.0, 0.5), (2.0, 2.8)]);
}

/// The end of a run does not depend on how it is cut into communication steps.
#[test]
fn communication_steps_of_any_size() {
    for model in MODELS {
        let run = |step: f64| {
            let mut run = Run::new(coarse(model), Inputs::default());
            run.inputs.primary.clamping_force = 15e3;
            run.go(0.03, step)
        };
        let reference = run(1e-3);
        for step in [1e-4, 7.5e-3, 0.03] {
            let o = run(step);
            assert!((o.ratio_geometric - reference.ratio_geometric).abs() < 1e-4);
            assert_close(o.primary.speed, reference.primary.speed, 1e-4, "primary speed");
            assert_close(o.thrust_ratio, reference.thrust_ratio, 2e-3, "thrust ratio");
        }
    }
}

/// Two runs alike are alike to the last bit, and so is a snapshot that goes on.
#[test]
fn runs_and_snapshots_repeat_bit_for_bit() {
    for model in MODELS {
        let mut one = Run::new(coarse(model), Inputs::default());
        let mut two = Run::new(coarse(model), Inputs::default());
        one.go(0.01, 1e-3);
        two.go(0.01, 1e-3);
        let mut snapshot = one.clone();
        for run in [&mut one, &mut two, &mut snapshot] {
            run.go(0.01, 1e-3);
        }
        assert_eq!(one.variator.state(), two.variator.state());
        assert_eq!(one.variator.state(), snapshot.variator.state());
        assert_eq!(one.variator.outputs(), snapshot.variator.outputs());
    }
}

/// What a short run takes, so that a solver that got slower shows without a clock: a step of F_P on the default variator.
#[test]
fn a_run_takes_its_usual_work() {
    for (model, steps, residuals, factorizations) in [(RingModel::Ale0, 100, 100, 100), (RingModel::Ale, 100, 100, 100)]
    {
        let mut run = Run::new(variator(model), inputs((50.0, 13e3), (-49.0, 10e3)));
        run.go(0.05, 1e-3);
        run.inputs.primary.clamping_force = 15e3;
        run.go(0.05, 1e-3);
        let counts = run.variator.counts();
        println!("{model:?}: {counts:?}");
        assert_pinned(counts.steps, steps, "steps");
        assert_pinned(counts.residuals, residuals, "residuals");
        assert_pinned(counts.factorizations, factorizations, "factorizations");
    }
}
