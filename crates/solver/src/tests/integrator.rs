//! The integrator's order, its error estimate and control, and the work it takes.

use super::super::State;
use super::super::sdirk::{GAMMA, Sdirk};
use super::problems::{
    Accepted, Both, Constrained, Decay, Equations, Forced, ProtheroRobinson, Quadrature, Real, Solved, Test,
    VanDerPol, advance, copy, equations, fixed, run,
};
use super::{assert_work, work};

const LADDER: [u32; 5] = [20, 40, 80, 160, 320];

fn assert_order(errors: &[f64], expected: f64, what: &str) {
    let found = (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64;
    assert!(
        (found - expected).abs() < 0.2,
        "{what}: order {found}, errors {errors:?}"
    );
}

/// Errors at the end of 1 s.
fn ladder<E: Solved<N>, const N: usize>(equations: E) -> Both<Vec<f64>> {
    let mut system = Test::new(equations);
    let errors = LADDER.map(|steps| {
        let (mut state, mut integrator) = (system.state(0.0), fixed(&system, 1.0 / f64::from(steps)));
        advance(&mut integrator, &mut system, &mut state, [0.0, 1.0]).unwrap();
        assert_eq!(integrator.newton.counts.steps, u64::from(steps));
        system.error(&state, 1.0)
    });
    Both {
        y: errors.map(|error| error.y).into(),
        q: errors.map(|error| error.q).into(),
    }
}

/// A method that is stiffly accurate keeps its order where a row has no rate, in both unknowns
/// (Hairer and Wanner, Solving Ordinary Differential Equations II, section VI.1).
#[test]
fn order_is_two() {
    fn check<E: Solved<N>, const N: usize>(equations: E, what: &str) {
        let errors = ladder(equations);
        assert_order(&errors.y, 2.0, what);
        if E::HAS_POSITION {
            assert_order(&errors.q, 2.0, what);
        }
    }
    check(Decay {}, "decay");
    check(Quadrature {}, "quadrature");
    check(Forced {}, "forced");
    check(ProtheroRobinson { rate: 1.0 }, "Prothero-Robinson, not stiff");
    check(Constrained {}, "constrained");
}

/// Van der Pol's oscillator let go at q = 2.
fn resting(system: &Test<VanDerPol, 1>) -> State {
    system.state_of([0.0], [-2.0], [2.0])
}

/// Under h λ → ∞ a stiffly accurate method with stages of order 1 has an error of h²/(hλ) = h/λ
/// (Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.15): of first order
/// in the step, but it vanishes with the stiffness.
#[test]
fn stiff_errors_are_those_of_theory() {
    let [soft, hard] = [1e6, 1e7].map(|rate| ladder(ProtheroRobinson { rate }).y);
    assert_order(&soft, 1.0, "Prothero-Robinson, stiff");
    for ((soft, hard), steps) in soft.iter().zip(&hard).zip(LADDER) {
        assert!((soft / hard / 10.0 - 1.0).abs() < 0.01, "{soft:e} {hard:e}");
        assert!(*soft < 1.0 / f64::from(steps) / 1e6, "{soft:e}");
    }
}

/// Errors after one step from the exact state at 0.3 s: as estimated, and exact.
fn one_step<E: Solved<N>, const N: usize>(system: &mut Test<E, N>, h: f64) -> [Both<f64>; 2] {
    let start = 0.3;
    let mut state = system.state(start);
    advance(&mut fixed(system, h), system, &mut state, [start, start + h]).unwrap();
    [system.estimate.get(), system.error(&state, start + h)]
}

/// An error of a step is of the third order, and so is its estimate, in y and in q.
#[test]
fn estimate_is_of_third_order() {
    let mut system = Test::new(Forced {});
    let found = [0.02, 0.01, 0.005, 0.0025].map(|h| one_step(&mut system, h));
    for (name, errors) in [
        ("estimate", found.map(|[estimate, _]| estimate)),
        ("error", found.map(|[_, exact]| exact)),
    ] {
        assert_order(&errors.map(|error| error.y), 3.0, name);
        assert_order(&errors.map(|error| error.q), 3.0, name);
    }
}

/// The weights of the estimate are of third order for quadrature. Of the four conditions for third
/// order they violate Σ b̂ᵢ aᵢⱼ cⱼ = 1/6. So for ẏ = −y the estimate is the part Σ (b̂ᵢ − bᵢ) aᵢⱼ
/// cⱼ of an error of 1/6 − Σ bᵢ aᵢⱼ cⱼ, times h³.
#[test]
fn estimate_is_the_error_of_quadrature() {
    let [estimate, exact] = one_step(&mut Test::new(Quadrature {}), 1e-3);
    assert!((estimate.y / exact.y - 1.0).abs() < 0.01, "{estimate:?} {exact:?}");
    let [estimate, exact] = one_step(&mut Test::new(Decay {}), 1e-2);
    let slopes = [GAMMA * GAMMA, 2.0 * GAMMA - GAMMA * GAMMA];
    let first = 1.0 / (6.0 * GAMMA * (1.0 - GAMMA));
    let better = first * slopes[0] + (0.5 - GAMMA * first) * slopes[1];
    let own = (1.0 - GAMMA) * slopes[0] + GAMMA * slopes[1];
    let expected = (better - own) / (1.0 / 6.0 - own);
    assert!((expected - 0.147).abs() < 1e-3, "{expected}");
    assert!(
        (estimate.y / exact.y / expected - 1.0).abs() < 0.03,
        "{estimate:?} {exact:?}"
    );
}

/// Steps are accepted where an estimate c h³ meets the tolerance, and the error at the end is of
/// h²: with a tenth of the tolerance 10^(−2/3) = 0.22 of it.
#[test]
fn error_falls_with_the_tolerance() {
    fn check<E: Solved<N>, const N: usize>(equations: E, to: f64, pinned: [u64; 5], what: &str) {
        let mut system = Test::new(equations);
        let mut done = [0; 5];
        let errors = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9].map(|tolerance| {
            let mut state = system.state(0.0);
            done = work(run(&mut system, &mut state, to, tolerance).unwrap().newton.counts);
            let error = system.error(&state, to);
            error.y.max(error.q)
        });
        for pair in errors.windows(2) {
            assert!(pair[1] < 0.5 * pair[0], "{what}: {errors:?}");
        }
        let found = (errors[0] / errors[errors.len() - 1]).log10() / (errors.len() - 1) as f64;
        assert!((found - 2.0 / 3.0).abs() < 0.1, "{what}: {found}, {errors:?}");
        assert_work(done, pinned, what);
    }
    check(Forced {}, 5.0, [2235, 6, 0, 8510, 90], "forced");
    check(Constrained {}, 2.0, [303, 0, 0, 1496, 34], "constrained");
}

/// A limit cycle with jumps in it: steps grow and fall by a factor of some thousand.
#[test]
fn relaxation_oscillation() {
    // By the classical Runge-Kutta method in 600 000 steps.
    let exact = -1.890_134_913_942;
    let mut system = Test::new(VanDerPol { damping: 30.0 });
    let mut errors = Vec::new();
    for (tolerance, pinned) in [(1e-4, [110, 24, 0, 868, 47]), (1e-6, [436, 34, 0, 2746, 58])] {
        let mut state = resting(&system);
        system.accepted.clear();
        let counts = run(&mut system, &mut state, 30.0, tolerance).unwrap().newton.counts;
        errors.push((system.values(&state.q)[0] - exact).abs());
        assert_work(work(counts), pinned, "");
    }
    assert!(errors[0] < 1e-2 && errors[1] < 0.1 * errors[0], "{errors:?}");
    let lengths = || system.accepted.iter().map(|step| step.length);
    let (least, most) = (lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max));
    assert!(most > 300.0 * least, "{least} {most}");
}

/// The work does not depend on a large stiffness. It is some times that of a soft problem: slopes
/// of stiff unknowns are of the stages' first order, so the estimate is of second order in the
/// step.
#[test]
fn work_is_bounded_in_the_stiffness() {
    let [soft, stiff, stiffer] = [1.0, 1e5, 1e8].map(|rate| {
        let mut system = Test::new(ProtheroRobinson { rate });
        let mut state = system.state(0.0);
        let counts = run(&mut system, &mut state, 10.0, 1e-5).unwrap().newton.counts;
        assert!(system.error(&state, 10.0).y < 1e-3);
        work(counts)
    });
    assert_work(soft, [105, 9, 0, 553, 23], "soft");
    assert_work(stiff, [508, 15, 0, 1807, 30], "stiff");
    // The number of steps depends on where a step is rejected; a Jacobian counts as twelve
    // residuals.
    let [most, found] = [stiff, stiffer].map(|[.., residuals, jacobians]| residuals + 12 * jacobians);
    assert!(found <= most + most / 50, "{stiff:?} {stiffer:?}");
}

equations! {
    /// A body that falls on a wall of 1e8 times its weight a metre. q is the gap.
    Bouncing {}: 1, true, |self, _, [y], [y_dot], [q]| {
        let wall = if q.re() < 0.0 { -(q * 1e8 + y * 1e4) } else { T::zero() };
        [y_dot + 10.0 - wall]
    }
}

/// Where Newton's method fails in one step, the control of the step size takes shorter ones.
#[test]
fn a_stiff_contact_is_met_in_shorter_steps() {
    let mut system = Test::new(Bouncing {});
    let mut state = system.state_of([0.0], [-10.0], [1.0]);
    let counts = run(&mut system, &mut state, 10.0, 1e-5).unwrap().newton.counts;
    // At rest it weighs 10 N.
    assert!((system.values(&state.q)[0] + 1e-7).abs() < 1e-9, "{state:?}");
    assert!(system.values(&state.y)[0].abs() < 1e-6);
    assert_work(work(counts), [235, 82, 15, 2350, 319], "");
}

/// Accepted steps fill the time, the last ends exactly at the given time, and none is longer than
/// the longest.
#[test]
fn steps_fill_the_time() {
    let mut system = Test::new(Forced {});
    system.tolerance = 1e-3;
    let mut state = system.state(0.0);
    let mut integrator = Sdirk::new(&system, 0.03, 0.03);
    // 0.002 + (0.02 − 0.002) is not 0.02.
    for pair in [0.0, 0.002, 0.02, 0.1, 0.1 + 1e-7, 0.5, 1.0].windows(2) {
        advance(&mut integrator, &mut system, &mut state, [pair[0], pair[1]]).unwrap();
        assert_eq!(system.accepted[system.accepted.len() - 1].end, pair[1]);
    }
    let mut time = 0.0;
    for Accepted { end, length } in &system.accepted {
        assert!((end - length - time).abs() < 1e-15 && (0.99e-7..=0.03).contains(length));
        time = *end;
    }
    assert!((system.integral[0] - 2.0_f64.sin()).abs() < 1e-3);
}

/// A run goes on bit by bit from what an archive holds of it.
#[test]
fn a_run_goes_on_from_an_archive() {
    let mut system = Test::new(VanDerPol { damping: 30.0 });
    let mut state = resting(&system);
    let mut integrator = run(&mut system, &mut state, 10.0, 1e-4).unwrap();
    let mut other = Sdirk::new(&system, 1.0, f64::INFINITY);
    copy(&mut integrator, &mut other);
    let mut ends = [state.clone(), state];
    for (integrator, state) in [&mut integrator, &mut other].into_iter().zip(&mut ends) {
        advance(integrator, &mut system, state, [10.0, 30.0]).unwrap();
    }
    assert_eq!(ends[0], ends[1]);
    assert_eq!(integrator.newton.counts, other.newton.counts);
}

/// The second derivative at the end of a step, of first order.
#[test]
fn slope_rate_is_the_second_derivative() {
    let errors = [0.04, 0.02, 0.01, 0.005].map(|h| {
        let mut system = Test::new(Quadrature {});
        let mut state = system.state(0.0);
        let mut integrator = fixed(&system, h);
        assert_eq!(integrator.slope_rate(system.first()), 0.0);
        advance(&mut integrator, &mut system, &mut state, [0.0, 1.0]).unwrap();
        (integrator.slope_rate(system.first()) + 1.0_f64.sin()).abs()
    });
    assert_order(&errors, 1.0, "slope rate");
}

equations! {
    /// No solution beyond 1 s: ẏ = y² from y = 1.
    BlowUp {}: 1, false, |self, _, [y], [y_dot], _| [y_dot - y * y]
}

/// A step below the smallest is an error with the time reached, and the state is that of then.
#[test]
fn a_stalled_step_is_reported() {
    let mut system = Test::new(BlowUp {});
    let mut state = system.state_of([1.0], [1.0], [0.0]);
    let stalled = run(&mut system, &mut state, 2.0, 1e-6).unwrap_err();
    assert!((stalled.time - 1.0).abs() < 1e-3, "{stalled:?}");
    assert!(stalled.step < 1e-10);
    assert_eq!(system.accepted.last().unwrap().end, stalled.time);
    let y = system.values(&state.y)[0];
    assert!(y > 1e3 && y.is_finite(), "{y}");
}

/// A time that is not a number, or an infinite one, ends in the same error.
#[test]
fn a_step_to_no_time_stalls() {
    for (from, to) in [
        (f64::NAN, 1.0),
        (0.0, f64::NAN),
        (0.0, f64::INFINITY),
        (f64::NEG_INFINITY, 1.0),
    ] {
        let mut system = Test::new(Decay {});
        let (mut state, mut time) = (system.state(0.0), from);
        let stalled = fixed(&system, 0.1).step(&mut system, &mut state, &mut time, to);
        assert!(stalled.is_err(), "from {from} to {to}");
    }
}
