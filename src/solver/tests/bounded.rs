//! Ticks of bounded work: order one, the same work in each, damping without bound, and no failure.

use super::super::bounded::{Bounded, RESIDUALS};
use super::super::newton::Counts;
use super::problems::{Decay, ProtheroRobinson, Quadrature, Solved, Test};

/// Numbers of ticks of a ladder over 1 s.
const LADDER: [u32; 4] = [20, 40, 80, 160];

/// Largest errors of y and q at 1 s after so many ticks, and the work.
fn run<E: Solved<N>, const N: usize>(equations: E, ticks: u32) -> ([f64; 2], Counts) {
    let mut system = Test::new(equations);
    let mut state = system.state(0.0);
    let mut bounded = Bounded::new(&system);
    let length = 1.0 / f64::from(ticks);
    for k in 1..=ticks {
        bounded.tick(&mut system, &mut state, f64::from(k) * length, length);
    }
    (system.error(&state, 1.0), bounded.counts)
}

fn assert_order_one<E: Solved<N>, const N: usize>(equations: impl Fn() -> E, of: usize) {
    let errors = LADDER.map(|ticks| run(equations(), ticks).0[of]);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 1.0).abs() < 0.1, "{errors:?}");
    }
}

#[test]
fn order_is_one() {
    assert_order_one(|| Decay, 0);
    assert_order_one(|| Quadrature, 1);
}

#[test]
fn a_stiff_solution_is_followed() {
    let (errors, _) = run(ProtheroRobinson { rate: 1e6 }, 20);
    assert!(errors[0] < 1e-6, "{errors:?}");
}

#[test]
fn each_tick_takes_the_same_work() {
    let (_, counts) = run(Decay, 20);
    let expected = Counts {
        steps: 20,
        residuals: 20 * RESIDUALS as u64,
        factorizations: 20,
        ..Counts::default()
    };
    assert_eq!(counts, expected);
}
