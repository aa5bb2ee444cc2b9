//! Steps of bounded work, and their continuation.

use super::super::newton::{Unsolved, WorkBound};
use super::super::sdirk::Sdirk;
use super::super::{State, System};
use super::problems::{Equations, Quadrature, Real, Test, VanDerPol, copy, equations};

fn bounded(system: &impl System, bound: WorkBound) -> Sdirk {
    let mut sdirk = Sdirk::new(system, 1.0, 1.0);
    sdirk.newton.bound = bound;
    sdirk
}

/// So much work; a Jacobian takes that of 3 residuals, and 2 more where its geometry is new.
fn work(remaining: f64) -> WorkBound {
    WorkBound {
        remaining,
        jacobian: 3.0,
        geometry: 2.0,
        overdraft: 8.0,
        ..WorkBound::NONE
    }
}

#[test]
fn a_step_without_error_control_is_one_with_it() {
    let mut system = Test::new(Quadrature {});
    let mut ends = [system.state(0.0), system.state(0.0)];
    let [fixed, controlled] = &mut ends;
    bounded(&system, WorkBound::NONE)
        .step(&mut system, controlled, &mut 0.0, 0.1)
        .unwrap();
    bounded(&system, work(1e6))
        .fixed_step(&mut system, fixed, 0.0, 0.1)
        .unwrap();
    assert_eq!(ends[0], ends[1]);
    let [first, second] = &system.accepted[..] else {
        panic!("{:?}", system.accepted)
    };
    assert_eq!(first, second);
}

/// End of a step of an oscillator far from its limit cycle with `more` work at a time, and how
/// often the step was open.
fn in_parts(more: f64, stored: bool) -> (State, u32) {
    let mut system = Test::new(VanDerPol { damping: 1.0 });
    system.newton_scale = [1e-5];
    let mut state = system.state_of([30.0], [0.0], [2.0]);
    let mut sdirk = bounded(&system, work(0.0));
    let start = state.clone();
    for open in 0..100 {
        sdirk.newton.bound.remaining += more;
        let solved = sdirk.fixed_step(&mut system, &mut state, 0.0, 0.2);
        // The geometry of a Jacobian may exceed the bound too.
        assert!(
            sdirk.newton.bound.remaining >= -8.0 - 2.0,
            "{}",
            sdirk.newton.bound.remaining
        );
        match solved {
            Ok(()) => return (state, open),
            Err(unsolved) => assert_eq!(unsolved, Unsolved::OutOfWork),
        }
        assert_eq!(state, start, "an open step leaves the state");
        if stored {
            let mut other = bounded(&system, work(0.0));
            copy(&mut sdirk, &mut other);
            sdirk = other;
        }
    }
    panic!("never over");
}

/// A step that was open several times has the same end, also if it is stored and read in between.
#[test]
fn a_step_continues_where_its_work_was_used_up() {
    let (whole, once) = in_parts(1e3, false);
    assert_eq!(once, 0);
    for more in [2.0, 6.0] {
        let (parts, open) = in_parts(more, false);
        assert!(open > 0, "{more}");
        let [found, expected] = [&parts, &whole].map(|state| state.y[state.y.len() - 1]);
        assert!((found - expected).abs() < 1e-4 * expected.abs(), "{found}, {expected}");
        assert_eq!(in_parts(more, true), (parts, open), "{more}");
    }
}

equations! {
    /// y² = −1: no solution.
    Nowhere {}: 1, false, |self, _, [y], _, _| [y * y + 1.0]
}

/// The number of Jacobians of a stage is bounded, however often it was open.
#[test]
fn a_step_without_a_solution_is_abandoned() {
    let mut system = Test::new(Nowhere {});
    let mut state = system.state_of([3.0], [0.0], [0.0]);
    let start = state.clone();
    let bound = WorkBound {
        jacobians: 4,
        ..work(0.0)
    };
    let mut sdirk = bounded(&system, bound);
    for _ in 0..100 {
        sdirk.newton.bound.remaining += 2.0;
        match sdirk.fixed_step(&mut system, &mut state, 0.0, 0.2) {
            Err(Unsolved::OutOfWork) => {}
            outcome => {
                assert_eq!(outcome, Err(Unsolved::NoSolution));
                assert!(sdirk.newton.counts.factorizations <= 4);
                assert_eq!(state, start);
                return;
            }
        }
    }
    panic!("never abandoned");
}
