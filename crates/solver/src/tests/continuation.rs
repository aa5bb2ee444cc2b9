//! Steady states near a fold and beyond it.

use super::super::continuation::{ContinuationSettings, NotSteady, continue_to_steady};
use super::super::newton::Newton;
use super::super::sdirk::MIN_STEP;
use super::problems::{Equations, Real, Test, equations};

const SETTINGS: ContinuationSettings = ContinuationSettings {
    time: 0.0,
    first_step: 1e-2,
    last_step: 1e6,
    max_solves: 1000,
};

equations! {
    /// ẏ = λ + t − y²: y = √λ is stable, y = −√λ is not, and they meet at λ = 0.
    Fold { parameter: f64 }: 1, false, |self, t, [y], [y_dot], _| [y_dot + y * y - self.parameter - t]
}
equations! {
    /// A shallow arch, q̈ + 2q̇ + q³ − q = λ: it snaps through where λ² = 4/27.
    Arch { load: f64 }: 1, true, |self, _, [y], [y_dot], [q]| [y_dot + y * 2.0 + q.powi(3) - q - self.load]
}

/// End of a search, and how many steps were refused.
struct Found {
    y: f64,
    q: f64,
    outcome: Result<(), NotSteady>,
    refused: usize,
}

/// Searches for a steady state from y and q. Steps with a larger change are refused.
fn settled<E: Equations<1>>(
    equations: E,
    y: f64,
    q: f64,
    settings: &ContinuationSettings,
    largest_change: f64,
    longest_step: f64,
) -> Found {
    let mut system = Test::new(equations);
    let mut newton = Newton::new(&system);
    let first = system.first();
    let mut state = system.state_of([y], [0.0], [q]);
    let mut refused = 0;
    let mut before_refusal = f64::INFINITY;
    let outcome = continue_to_steady(&mut system, &mut newton, &mut state, settings, |_, trial| {
        let change = |a: &[f64], b: &[f64]| (a[first] - b[first]).abs();
        // After a step that was refused comes a shorter one.
        assert!(trial.step < before_refusal && trial.step <= longest_step);
        if change(trial.after.y, trial.before.y).max(change(trial.after.q, trial.before.q)) > largest_change {
            refused += 1;
            before_refusal = trial.step;
            return None;
        }
        before_refusal = f64::INFINITY;
        Some(longest_step)
    });
    let (y, q) = (state.y[first], state.q[first]);
    Found {
        y,
        q,
        outcome,
        refused,
    }
}

#[test]
fn the_stable_branch_is_found_from_either_side() {
    for parameter in [1.0_f64, 1e-2, 1e-4] {
        let root = parameter.sqrt();
        for start in [30.0 * root, 2.0 * root, 0.5 * root, -0.5 * root] {
            let found = settled(Fold { parameter }, start, 0.0, &SETTINGS, 0.5 * root, f64::INFINITY);
            let y = found.y;
            found.outcome.unwrap();
            assert!((y - root).abs() < 1e-9 * root, "λ = {parameter}, from {start}: {y}");
        }
    }
}

#[test]
fn nothing_is_found_beyond_the_fold() {
    for parameter in [-1e-4, -1.0] {
        for start in [2.0, -2.0] {
            let found = settled(Fold { parameter }, start, 0.0, &SETTINGS, 0.1, f64::INFINITY);
            let report = found.outcome.unwrap_err();
            assert!(
                report.solves == SETTINGS.max_solves || report.step < MIN_STEP,
                "{report:?}"
            );
        }
    }
}

#[test]
fn an_arch_stands_until_it_snaps() {
    // Just below the fold it comes to rest on the near branch: q³ − q = λ with q < −1/√3.
    let edge = -1.0 / 3.0_f64.sqrt();
    let snap = (4.0 / 27.0_f64).sqrt();
    let load = 0.999 * snap;
    let arch = |load| settled(Arch { load }, 0.0, -1.0, &SETTINGS, 0.05, f64::INFINITY);
    let Found { y, q, outcome, .. } = arch(load);
    outcome.unwrap();
    assert!(y.abs() < 1e-9 && q < edge, "{y} {q}");
    assert!((q.powi(3) - q - load).abs() < 1e-9);
    // Just beyond it is found on the far one.
    let Found { y, q, outcome, .. } = arch(1.001 * snap);
    outcome.unwrap();
    assert!(y.abs() < 1e-9 && q > 1.0, "{y} {q}");
}

#[test]
fn a_search_ends_when_every_step_is_refused() {
    let found = settled(Fold { parameter: 1.0 }, 30.0, 0.0, &SETTINGS, 0.0, f64::INFINITY);
    let report = found.outcome.unwrap_err();
    assert_eq!(found.y, 30.0);
    assert!(report.step < MIN_STEP && found.refused == report.solves, "{report:?}");
}

#[test]
fn the_system_is_evaluated_at_the_time_that_was_set() {
    let settings = ContinuationSettings { time: 3.0, ..SETTINGS };
    let found = settled(Fold { parameter: 1.0 }, 1.0, 0.0, &settings, 0.5, f64::INFINITY);
    found.outcome.unwrap();
    assert!((found.y - 2.0).abs() < 1e-9, "{}", found.y);
}

#[test]
fn the_longest_step_is_kept_to() {
    let settings = ContinuationSettings {
        max_solves: 20,
        ..SETTINGS
    };
    let found = settled(Fold { parameter: 1.0 }, 0.0, 0.0, &settings, f64::INFINITY, 0.1);
    // It never got as far as the step that counts as steady.
    assert_eq!(found.outcome, Err(NotSteady { solves: 20, step: 0.1 }));
}
