//! Ticks of bounded work: order two and one, the same work in each, and going on where the work ended.

use super::super::bounded::{Bounded, Budget, RESIDUALS, Task, Tick};
use super::super::{State, System};

use super::super::newton::Counts;
use super::problems::{Decay, ProtheroRobinson, Quadrature, Solved, Test, VanDerPol};
use pushbelt_tape::Tape;

/// Numbers of ticks of a ladder over 1 s.
const LADDER: [u32; 4] = [20, 40, 80, 160];
/// Jacobians in a tick.
const JACOBIANS: usize = 3;

/// Largest errors of y and q at 1 s after so many ticks of a kind, and the work.
fn run<E: Solved<N>, const N: usize>(equations: E, kind: Tick, ticks: u32) -> ([f64; 2], Counts) {
    let mut system = Test::new(equations);
    let mut state = system.state(0.0);
    let mut bounded = Bounded::new(&system);
    let length = 1.0 / f64::from(ticks);
    for k in 1..=ticks {
        let span = [k - 1, k].map(|k| f64::from(k) * length);
        let mut outcome = None;
        for mut part in Budget::millisecond(JACOBIANS) {
            assert!(outcome.is_none(), "{kind:?} {k} leaves work");
            outcome = bounded.tick(&mut system, &mut state, &task(span, kind), &mut part);
        }
        assert!(outcome.is_some(), "{kind:?} {k} is open");
    }
    (system.error(&state, 1.0), bounded.counts)
}

fn task(span: [f64; 2], kind: Tick) -> Task {
    Task {
        span,
        kind,
        takes: JACOBIANS,
        is_forced: false,
    }
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
            residuals: 20 * (JACOBIANS * RESIDUALS) as u64,
            factorizations: 20 * JACOBIANS as u64,
            ..Counts::default()
        };
        assert_eq!(counts, expected, "{kind:?}");
    }
}

/// An oscillator that is far from its limit cycle.
fn oscillator() -> (Test<VanDerPol, 1>, State) {
    let mut system = Test::new(VanDerPol { damping: 1.0 });
    system.newton_scale = [1e-5];
    let mut state = State::zero(system.shape().len());
    state.y = system.unknowns([30.0]);
    state.q = system.unknowns([2.0]);
    (system, state)
}

/// Where a tick of an oscillator leads with so many residuals at a time, how often it was open, and the work.
fn in_parts(kind: Tick, residuals: usize, stored: bool) -> (f64, u32, Counts) {
    let (mut system, mut state) = oscillator();
    let mut bounded = Bounded::new(&system);
    let start = state.clone();
    for open in 0..100 {
        let mut budget = Budget::of(residuals);
        while !budget.is_used_up() {
            let outcome = bounded.tick(&mut system, &mut state, &task([0.0, 0.05], kind), &mut budget);
            if outcome.is_some() {
                assert!(!bounded.is_open());
                return (system.values(&state.y)[0], open, bounded.counts);
            }
            assert!(bounded.is_open());
            assert_eq!(state, start, "an open tick leaves the state");
        }
        if stored {
            let mut tape = Tape::writer();
            bounded.serialize(&mut tape);
            bounded = Bounded::new(&system);
            bounded.serialize(&mut Tape::reader(&tape.into_bytes()));
        }
    }
    panic!("{kind:?}: never over");
}

/// One residual at a time leads where eight lead, by way of states that are stored.
#[test]
fn a_tick_goes_on_where_its_work_ended() {
    for kind in KINDS {
        let (whole, ..) = in_parts(kind, 8, false);
        let (parts, open, counts) = in_parts(kind, 1, false);
        assert!(open > 0, "{kind:?}");
        assert_eq!(counts.residuals, u64::from(open) + 1, "{kind:?}");
        assert_eq!(
            counts.factorizations, counts.residuals,
            "{kind:?}: a Jacobian each time"
        );
        assert!((parts - whole).abs() < 1e-3 * whole.abs(), "{kind:?}: {parts}, {whole}");
        assert_eq!(in_parts(kind, 1, true).0, parts, "{kind:?}");
    }
}

#[test]
fn a_tick_that_is_forced_ends_with_its_work() {
    let (mut system, mut state) = oscillator();
    let forced = Task {
        is_forced: true,
        ..task([0.0, 0.05], Tick::Rough)
    };
    let mut bounded = Bounded::new(&system);
    let outcome = bounded.tick(&mut system, &mut state, &forced, &mut Budget::of(1));
    assert!(outcome.is_some());
}
