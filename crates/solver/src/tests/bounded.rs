//! Steps of bounded work: order, the same work in each, and going on where the work ended.

use super::super::bounded::{Bounded, Budget, RESIDUALS, Scheme, Tick};
use super::super::{State, System};

use super::super::newton::Counts;
use super::problems::{Decay, ProtheroRobinson, Quadrature, Solved, Test, VanDerPol};
use pushbelt_tape::Tape;

/// Numbers of ticks of a ladder over 1 s.
const LADDER: [u32; 4] = [20, 40, 80, 160];
/// Jacobians in a tick.
const JACOBIANS: usize = 3;

/// Largest errors of y and q at 1 s after so many ticks with a scheme, and the work.
fn run<E: Solved<N>, const N: usize>(equations: E, scheme: Scheme, ticks: u32) -> ([f64; 2], Counts) {
    let mut system = Test::new(equations);
    let mut state = system.state(0.0);
    let mut bounded = Bounded::new(&system);
    let length = 1.0 / f64::from(ticks);
    for k in 1..=ticks {
        let span = [k - 1, k].map(|k| f64::from(k) * length);
        let mut outcome = None;
        for mut part in Budget::millisecond(JACOBIANS) {
            assert!(outcome.is_none(), "{scheme:?} {k} leaves work");
            outcome = bounded.tick(&mut system, &mut state, &task(span, scheme), &mut part);
        }
        assert!(outcome.is_some(), "{scheme:?} {k} is open");
    }
    (system.error(&state, 1.0), bounded.counts)
}

fn task(span: [f64; 2], scheme: Scheme) -> Tick {
    Tick {
        span,
        scheme,
        takes: JACOBIANS,
        is_forced: false,
    }
}

const SCHEMES: [Scheme; 2] = [Scheme::Sdirk, Scheme::Euler];

fn assert_order<E: Solved<N>, const N: usize>(expected: f64, equations: impl Fn() -> E, scheme: Scheme, of: usize) {
    let errors = LADDER.map(|ticks| run(equations(), scheme, ticks).0[of]);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - expected).abs() < 0.1, "{scheme:?}: {errors:?}");
    }
}

#[test]
fn order_is_two_with_sdirk_and_one_with_euler() {
    for (scheme, order) in [(Scheme::Sdirk, 2.0), (Scheme::Euler, 1.0)] {
        assert_order(order, || Decay, scheme, 0);
        assert_order(order, || Quadrature, scheme, 1);
    }
}

#[test]
fn a_stiff_solution_is_followed() {
    for scheme in SCHEMES {
        let (errors, _) = run(ProtheroRobinson { rate: 1e6 }, scheme, 20);
        assert!(errors[0] < 1e-6, "{scheme:?}: {errors:?}");
    }
}

#[test]
fn each_step_takes_the_same_work() {
    for scheme in SCHEMES {
        let (_, counts) = run(Decay, scheme, 20);
        let expected = Counts {
            steps: 20,
            residuals: 20 * (JACOBIANS * RESIDUALS) as u64,
            factorizations: 20 * JACOBIANS as u64,
            ..Counts::default()
        };
        assert_eq!(counts, expected, "{scheme:?}");
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

/// Where a step of an oscillator leads with so many residuals at a time, how often it was open, and the work.
fn in_parts(scheme: Scheme, residuals: usize, stored: bool) -> (f64, u32, Counts) {
    let (mut system, mut state) = oscillator();
    let mut bounded = Bounded::new(&system);
    let start = state.clone();
    for open in 0..100 {
        let mut budget = Budget::of(residuals);
        while !budget.is_used_up() {
            let outcome = bounded.tick(&mut system, &mut state, &task([0.0, 0.05], scheme), &mut budget);
            if outcome.is_some() {
                assert!(!bounded.is_open());
                return (system.values(&state.y)[0], open, bounded.counts);
            }
            assert!(bounded.is_open());
            assert_eq!(state, start, "an open step leaves the state");
        }
        if stored {
            let mut tape = Tape::writer();
            bounded.serialize(&mut tape);
            bounded = Bounded::new(&system);
            bounded.serialize(&mut Tape::reader(&tape.into_bytes()));
        }
    }
    panic!("{scheme:?}: never over");
}

/// With one residual at a time the result is that of eight at a time, also if the state is stored and read in between.
#[test]
fn a_step_goes_on_where_its_work_ended() {
    for scheme in SCHEMES {
        let (whole, ..) = in_parts(scheme, 8, false);
        let (parts, open, counts) = in_parts(scheme, 1, false);
        assert!(open > 0, "{scheme:?}");
        assert_eq!(counts.residuals, u64::from(open) + 1, "{scheme:?}");
        assert_eq!(
            counts.factorizations, counts.residuals,
            "{scheme:?}: a Jacobian each time"
        );
        assert!(
            (parts - whole).abs() < 1e-3 * whole.abs(),
            "{scheme:?}: {parts}, {whole}"
        );
        assert_eq!(in_parts(scheme, 1, true).0, parts, "{scheme:?}");
    }
}

#[test]
fn a_forced_step_ends_with_its_work() {
    let (mut system, mut state) = oscillator();
    let forced = Tick {
        is_forced: true,
        ..task([0.0, 0.05], Scheme::Euler)
    };
    let mut bounded = Bounded::new(&system);
    let outcome = bounded.tick(&mut system, &mut state, &forced, &mut Budget::of(1));
    assert!(outcome.is_some());
}
