//! Newton's method on hard problems of one or two unknowns, with the work it takes.

use super::super::System;
use super::super::newton::{Newton, Stage, Unsolved};
use super::assert_work;
use super::problems::{Equations, Real, Test, equations};

/// Solves a stage in which ẏ = y and q = y from a guess, with the factors and rates of before.
fn solve<E: Equations<N>, const N: usize>(
    newton: &mut Newton,
    system: &mut Test<E, N>,
    guess: [f64; N],
    reuse: bool,
) -> Result<[f64; N], Unsolved> {
    let mut stage = Stage::new(system.shape().len());
    stage.state = system.state_of(guess, [0.0; N], [0.0; N]);
    newton.solve(system, &mut stage, reuse)?;
    Ok(system.values(&stage.state.y))
}

fn work(newton: &Newton) -> [u64; 2] {
    [newton.counts.residuals, newton.counts.factorizations]
}

/// Solves anew; the solution, residual evaluations and factorizations.
fn fresh<E: Equations<N>, const N: usize>(
    equations: E,
    guess: [f64; N],
) -> (Result<[f64; N], Unsolved>, [u64; 2]) {
    let mut system = Test::new(equations);
    let mut newton = Newton::new(&system);
    let found = solve(&mut newton, &mut system, guess, false);
    (found, work(&newton))
}

/// Solves one equation anew; the solution must be `expected`, the residual evaluations and
/// factorizations `work`.
fn assert_solves<E: Equations<1>>(equations: E, guess: f64, expected: f64, work: [u64; 2]) {
    let (found, done) = fresh(equations, [guess]);
    let [found] = found.unwrap();
    assert!(
        (found - expected).abs() < 1e-11 * (1.0 + expected.abs()),
        "{found} {expected}"
    );
    assert_work(done, work, &format!("from {guess}"));
}

equations! {
    /// A force on a body of unit mass that meets a wall of this stiffness at y = 0.
    Wall { stiffness: f64, force: f64 }: 1, false,
    |self, _, [y], _, _| [if y.re() > 0.0 { y * self.stiffness + y - self.force } else { y - self.force }]
}
equations! {
    /// A force on a body of this mass under friction that saturates at 1, y/√(y² + v²).
    Friction { mass: f64, velocity: f64, force: f64 }: 1, false,
    |self, _, [y], _, _| [y * self.mass + y / (y * y + self.velocity.powi(2)).sqrt() - self.force]
}
equations! {
    /// ln y = 0: not a number where y < 0.
    Logarithm {}: 1, false, |self, _, [y], _, _| [y.ln()]
}
equations! {
    /// y² + c.
    Parabola { constant: f64 }: 1, false, |self, _, [y], _, _| [y * y + self.constant]
}
equations! {
    /// Two unknowns that differ by 1e18 in size, coupled.
    IllScaled {}: 2, false, |self, _, [a, b], _, _| {
        let (a, b) = (a * 1e9, b * 1e-9);
        [(a * a + b - 3.0) * 1e12, (b * b * a - 4.0) * 1e-12]
    }
}
equations! {
    /// Springs that harden, each by itself, under one force.
    Springs { stiffness: [f64; 24], force: f64 }: 24, false,
    |self, _, y, _, _| std::array::from_fn(|i| y[i] * self.stiffness[i] + y[i].powi(3) - self.force)
}

#[test]
fn a_stiff_wall_is_met_and_left() {
    let wall = |force| Wall { stiffness: 1e8, force };
    assert_solves(wall(5.0), 1e3, 5.0 / (1.0 + 1e8), [2, 1]);
    assert_solves(wall(-5.0), 1e-3, -5.0, [4, 2]);
    let soft = Wall {
        stiffness: 5.0,
        force: 5.0,
    };
    assert_solves(soft, -1.0, 5.0 / 6.0, [7, 2]);
    // Before a stiff wall no damped step shortens the correction: the step must be shorter.
    let (found, done) = fresh(wall(5.0), [-1.0]);
    assert_eq!(found, Err(Unsolved::NoSolution));
    assert_work(done, [48, 5], "");
}

#[test]
fn friction_that_saturates() {
    let friction = |mass, force| Friction {
        mass,
        velocity: 1e-3,
        force,
    };
    for (force, guess, pinned) in [
        (0.5, 10.0, [34, 5]),
        (0.5, -10.0, [31, 5]),
        (0.5, 1.0, [21, 4]),
        (-0.5, 1e-4, [6, 1]),
    ] {
        let equations = friction(1.0, force);
        let (found, done) = fresh(friction(1.0, force), [guess]);
        let y = found.unwrap();
        let [rest] = equations.residual(0.0, y, [0.0], [0.0]);
        assert!(rest.abs() < 1e-9, "{rest}");
        assert_work(done, pinned, &format!("{force} from {guess}"));
    }
    // Beyond the friction the body slides.
    let (found, done) = fresh(friction(1.0, 1.5), [0.0]);
    assert!((found.unwrap()[0] - 0.5).abs() < 1e-5);
    assert_work(done, [10, 4], "sliding");
    // With little mass every step overshoots where it sticks: a search without a better point
    // continues.
    let light = friction(1e-3, 0.5);
    let (found, done) = fresh(friction(1e-3, 0.5), [10.0]);
    let [rest] = light.residual(0.0, found.unwrap(), [0.0], [0.0]);
    assert!(rest.abs() < 1e-9, "{rest}");
    assert_work(done, [41, 6], "without mass");
}

#[test]
fn a_step_into_what_is_not_a_number_is_shortened() {
    assert_solves(Logarithm {}, 10.0, 1.0, [11, 2]);
}

#[test]
fn what_has_no_solution_is_an_error() {
    // Not a number from the start, a singular Jacobian, no root.
    assert_eq!(fresh(Logarithm {}, [-1.0]), (Err(Unsolved::NoSolution), [1, 1]));
    assert_eq!(
        fresh(Parabola { constant: 1.0 }, [0.0]),
        (Err(Unsolved::NoSolution), [1, 1])
    );
    let (found, [_, factorizations]) = fresh(Parabola { constant: 1.0 }, [2.0]);
    assert_eq!(found, Err(Unsolved::NoSolution));
    assert!(factorizations <= 15);
}

#[test]
fn solves_after_a_failure() {
    let mut system = Test::new(Parabola { constant: 1.0 });
    let mut newton = Newton::new(&system);
    assert!(solve(&mut newton, &mut system, [0.0], true).is_err());
    system.equations.constant = -4.0;
    let [found] = solve(&mut newton, &mut system, [3.0], true).unwrap();
    assert!((found - 2.0).abs() < 1e-12);
}

/// A double root: convergence is linear, by a half each iteration.
#[test]
fn a_double_root() {
    let (found, work) = fresh(Parabola { constant: 0.0 }, [1.0]);
    assert!(found.unwrap()[0].abs() < 1e-9);
    assert_work(work, [61, 3], "");
}

#[test]
fn ill_scaled_unknowns_and_rows() {
    let mut system = Test::new(IllScaled {});
    system.newton_scale = [1e-21, 1e-3];
    let mut newton = Newton::new(&system);
    let [a, b] = solve(&mut newton, &mut system, [1.2e-9, 1.5e9], false).unwrap();
    assert!(
        (a * 1e9 - 1.0).abs() < 1e-10 && (b * 1e-9 - 2.0).abs() < 1e-10,
        "{a} {b}"
    );
    assert_work(work(&newton), [9, 1], "");
}

impl Springs {
    fn largest_residual(&self, y: [f64; 24]) -> f64 {
        let rows = self.residual(0.0, y, [0.0; 24], [0.0; 24]);
        rows.iter().fold(0.0, |most, row| most.max(row.abs()))
    }
}

/// A Jacobian is used again while it contracts and may be.
#[test]
fn a_stale_jacobian_is_renewed() {
    let mut system = Test::new(Springs {
        stiffness: [10.0; 24],
        force: 1.0,
    });
    let mut newton = Newton::new(&system);
    let first = solve(&mut newton, &mut system, [0.0; 24], true).unwrap();
    assert!(system.equations.largest_residual(first) < 1e-10);
    assert_eq!(newton.counts.factorizations, 1);
    system.equations.force = 1.1;
    let second = solve(&mut newton, &mut system, first, true).unwrap();
    assert!(system.equations.largest_residual(second) < 1e-10);
    assert_eq!(newton.counts.factorizations, 1, "it was still good");
    system.equations.stiffness = std::array::from_fn(|i| 10.0 * 1.5_f64.powi(i as i32));
    let third = solve(&mut newton, &mut system, second, true).unwrap();
    assert!(system.equations.largest_residual(third) < 1e-7);
    assert_eq!(newton.counts.factorizations, 2);
    solve(&mut newton, &mut system, third, false).unwrap();
    assert_eq!(newton.counts.factorizations, 3);
}

/// Stages that needed many iterations add up to a new Jacobian although each converged.
#[test]
fn iterations_add_up_to_a_new_jacobian() {
    let mut system = Test::new(Friction {
        mass: 1.0,
        velocity: 1.0,
        force: 0.0,
    });
    let mut newton = Newton::new(&system);
    let mut y = [0.0];
    let mut made = Vec::new();
    for i in 0..40 {
        system.equations.force = if i % 2 == 0 { 1.0 } else { -1.0 };
        y = solve(&mut newton, &mut system, y, true).unwrap();
        made.push(newton.counts.factorizations);
    }
    let total = made[made.len() - 1];
    assert!((2..=20).contains(&total), "{total} for 40 stages");
    assert_work(work(&newton), [240, 4], "");
}
