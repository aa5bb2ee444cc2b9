//! Ticks of bounded work: order two and one, the same work in each, damping without bound, and no failure.

use super::super::bounded::{Bounded, RESIDUALS, Tick};
use super::super::newton::Counts;
use super::problems::{Decay, ProtheroRobinson, Quadrature, Solved, Test};

/// Numbers of ticks of a ladder over 1 s.
const LADDER: [u32; 4] = [20, 40, 80, 160];

/// Largest errors of y and q at 1 s after so many ticks of a kind, and the work.
fn run<E: Solved<N>, const N: usize>(equations: E, kind: Tick, ticks: u32) -> ([f64; 2], Counts) {
    let mut system = Test::new(equations);
    let mut state = system.state(0.0);
    let mut bounded = Bounded::new(&system);
    let length = 1.0 / f64::from(ticks);
    for k in 1..=ticks {
        let [from, to] = [k - 1, k].map(|k| f64::from(k) * length);
        bounded.tick(&mut system, &mut state, [from, to], kind);
    }
    (system.error(&state, 1.0), bounded.counts)
}

const KINDS: [Tick; 2] = [Tick::Calm, Tick::Rough];

fn assert_order<E: Solved<N>, const N: usize>(expected: f64, equations: impl Fn() -> E, kind: Tick, of: usize) {
    let errors = LADDER.map(|ticks| run(equations(), kind, ticks).0[of]);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - expected).abs() < 0.1, "{kind:?}: {errors:?}");
    }
}

#[test]
fn order_is_two_in_calm_ticks_and_one_in_rough_ones() {
    for (kind, order) in [(Tick::Calm, 2.0), (Tick::Rough, 1.0)] {
        assert_order(order, || Decay, kind, 0);
        assert_order(order, || Quadrature, kind, 1);
    }
}

#[test]
fn a_stiff_solution_is_followed() {
    for kind in KINDS {
        let (errors, _) = run(ProtheroRobinson { rate: 1e6 }, kind, 20);
        assert!(errors[0] < 1e-6, "{kind:?}: {errors:?}");
    }
}

#[test]
fn each_tick_takes_the_same_work() {
    for kind in KINDS {
        let (_, counts) = run(Decay, kind, 20);
        let expected = Counts {
            steps: 20,
            residuals: 20 * RESIDUALS as u64,
            factorizations: 20,
            ..Counts::default()
        };
        assert_eq!(counts, expected, "{kind:?}");
    }
}
