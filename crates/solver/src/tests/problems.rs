//! Small problems with their solutions, as [`System`]s.

use std::cell::Cell;

use num_dual::{Dual64, DualNum};
use pushbelt_archive::Archive;

use super::super::arrow::{Arrow, Shape};
use super::super::sdirk::{Evolution, Sdirk, Stalled};
use super::super::{State, System, View};

/// A number, or one with a derivative.
pub trait Real: DualNum<Primitive = f64> + Copy {}

impl<T: DualNum<Primitive = f64> + Copy> Real for T {}

/// N equations F(t, y, ẏ, q) = 0.
pub trait Equations<const N: usize> {
    const HAS_POSITION: bool;

    fn residual<T: Real>(&self, time: f64, y: [T; N], y_dot: [T; N], q: [T; N]) -> [T; N];
}

/// Values of y and of q.
#[derive(Clone, Copy, Debug, Default)]
pub struct Both<T> {
    pub y: T,
    pub q: T,
}

/// A problem whose solution is known for all times.
pub trait Solved<const N: usize>: Equations<N> {
    fn exact<T: Real>(&self, time: T) -> Both<[T; N]>;
}

/// An accepted step, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accepted {
    pub end: f64,
    pub length: f64,
}

/// Equations as a system, in the border of the matrix, beside a loop of blocks without effect.
pub struct Test<E, const N: usize> {
    pub equations: E,
    has_position: Vec<bool>,
    /// Tolerance of Newton's method.
    pub newton_scale: [f64; N],
    /// Relative and absolute tolerance of a step; with infinity every step is accepted.
    pub tolerance: f64,
    /// Largest estimated errors of the last step.
    pub estimate: Cell<Both<f64>>,
    /// Steps that were accepted.
    pub accepted: Vec<Accepted>,
    /// ∫y dt by the trapezoidal rule.
    pub integral: [f64; N],
}

impl<E: Equations<N>, const N: usize> Test<E, N> {
    pub fn new(equations: E) -> Self {
        Self {
            equations,
            has_position: [&[false; 3][..], &[E::HAS_POSITION; N]].concat(),
            newton_scale: [1e-12; N],
            tolerance: f64::INFINITY,
            estimate: Cell::default(),
            accepted: Vec::new(),
            integral: [0.0; N],
        }
    }

    /// First of the unknowns of the equations. Those before it stay 0.
    pub fn first(&self) -> usize {
        self.has_position.len() - N
    }

    /// A state from the unknowns of the equations.
    pub fn state_of(&self, y: [f64; N], y_dot: [f64; N], q: [f64; N]) -> State {
        let [y, y_dot, q] = [y, y_dot, q].map(|values| [vec![0.0; self.first()], values.to_vec()].concat());
        State { y, y_dot, q }
    }

    /// Values of the equations' unknowns.
    pub fn values(&self, all: &[f64]) -> [f64; N] {
        std::array::from_fn(|i| all[self.first() + i])
    }

    fn evaluate<T: Real>(&self, time: f64, view: View<'_>, vary: impl Fn(f64, usize, usize) -> T) -> [T; N] {
        let varied = |all: &[f64], kind: usize| std::array::from_fn(|i| vary(self.values(all)[i], i, kind));
        self.equations
            .residual(time, varied(view.y, 0), varied(view.y_dot, 1), varied(view.q, 2))
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| most.max(value.abs()))
}

impl<E: Solved<N>, const N: usize> Test<E, N> {
    /// The solution.
    pub fn state(&self, time: f64) -> State {
        let Both { y, q } = self.equations.exact(Dual64::new(time, 1.0));
        self.state_of(y.map(|y| y.re), y.map(|y| y.eps), q.map(|q| q.re))
    }

    /// Largest errors.
    pub fn error(&self, state: &State, time: f64) -> Both<f64> {
        let exact = self.state(time);
        let off = |a: &[f64], b: &[f64]| largest(a.iter().zip(b).map(|(a, b)| a - b));
        Both {
            y: off(&state.y, &exact.y),
            q: off(&state.q, &exact.q),
        }
    }
}

/// Integrator with steps of one size.
pub fn fixed(system: &impl System, step: f64) -> Sdirk {
    Sdirk::new(system, step, step)
}

/// Advances a state from one time to exactly another.
pub fn advance(
    integrator: &mut Sdirk,
    system: &mut impl Evolution,
    state: &mut State,
    [from, to]: [f64; 2],
) -> Result<(), Stalled> {
    let mut time = from;
    while time < to {
        integrator.step(system, state, &mut time, to)?;
    }
    Ok(())
}

/// Passes what an archive holds of an integrator to another one.
pub fn copy(from: &mut Sdirk, to: &mut Sdirk) {
    let mut archive = Archive::writer();
    from.serialize(&mut archive);
    from.newton.serialize_factors(&mut archive);
    let bytes = archive.into_bytes();
    let mut archive = Archive::reader(&bytes);
    to.serialize(&mut archive);
    to.newton.serialize_factors(&mut archive);
    assert_eq!(archive.finish(), Ok(()));
}

/// Integrates with a controlled error.
pub fn run<E: Equations<N>, const N: usize>(
    system: &mut Test<E, N>,
    state: &mut State,
    to: f64,
    tolerance: f64,
) -> Result<Sdirk, Stalled> {
    system.tolerance = tolerance;
    let mut integrator = Sdirk::new(system, 1e-6, f64::INFINITY);
    advance(&mut integrator, system, state, [0.0, to])?;
    Ok(integrator)
}

impl<E: Equations<N>, const N: usize> System for Test<E, N> {
    fn shape(&self) -> Shape {
        Shape {
            blocks: self.first(),
            block: 1,
            border: N,
        }
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, time: f64, view: View<'_>, out: &mut [f64]) {
        out.copy_from_slice(view.y);
        out[self.first()..].copy_from_slice(&self.evaluate(time, view, |value, _, _| value));
    }

    fn jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        out.clear();
        let first = self.first();
        (0..first).for_each(|i| out.add(i, i, 1.0));
        for column in 0..N {
            let rows = self.evaluate(time, view, |value, i, kind| {
                let slope = if i == column { [1.0, alpha, beta][kind] } else { 0.0 };
                Dual64::new(value, slope)
            });
            for (row, value) in rows.iter().enumerate() {
                out.add(first + row, first + column, value.eps);
            }
        }
    }

    fn newton_scale(&self, _beta: f64, out: &mut [f64]) {
        out.fill(1.0);
        out[self.first()..].copy_from_slice(&self.newton_scale);
    }
}

impl<E: Equations<N>, const N: usize> Evolution for Test<E, N> {
    fn error_norm(&self, view: View<'_>, y_error: &[f64], q_error: &[f64]) -> f64 {
        let has = f64::from(u8::from(E::HAS_POSITION));
        let relative = |errors: &[f64], values: &[f64]| {
            largest(
                errors
                    .iter()
                    .zip(values)
                    .map(|(error, value)| error / (1.0 + value.abs())),
            )
        };
        let [y, q] = [y_error, q_error].map(|errors| largest(errors.iter().copied()));
        self.estimate.set(Both { y, q });
        relative(y_error, view.y).max(has * relative(q_error, view.q)) / self.tolerance
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, end: f64, length: f64) {
        let (first, last) = (self.values(before.y), self.values(after.y));
        for (i, sum) in self.integral.iter_mut().enumerate() {
            *sum += 0.5 * length * (first[i] + last[i]);
        }
        self.accepted.push(Accepted { end, length });
    }
}

/// N equations, whether their unknowns are rates of positions, and y and q of their solution if
/// that is known.
macro_rules! equations {
    (
        $(#[$doc:meta])* $name:ident { $($field:ident: $type:ty),* }: $n:literal, $has_position:literal,
        |$self:ident, $time:pat, $y:pat, $y_dot:pat, $q:pat_param| $residual:expr $(, |$t:ident| $y_exact:expr, $q_exact:expr)?
    ) => {
        $(#[$doc])*
        pub struct $name {
            $(pub $field: $type),*
        }

        impl Equations<$n> for $name {
            const HAS_POSITION: bool = $has_position;

            fn residual<T: Real>(&$self, $time: f64, $y: [T; $n], $y_dot: [T; $n], $q: [T; $n]) -> [T; $n] {
                $residual
            }
        }

        $(impl Solved<$n> for $name {
            fn exact<T: Real>(&$self, $t: T) -> Both<[T; $n]> {
                Both { y: $y_exact, q: $q_exact }
            }
        })?
    };
}
pub(super) use equations;

equations! {
    /// ẏ = −y: y = exp(−t).
    Decay {}: 1, false, |self, _, [y], [y_dot], _| [y_dot + y], |t| [(-t).exp()], [T::zero()]
}
equations! {
    /// ẏ = cos t with q̇ = y: nothing but quadrature. y = sin t, q = 1 − cos t.
    Quadrature {}: 1, true, |self, t, _, [y_dot], _| [y_dot - t.cos()], |t| [t.sin()], [-t.cos() + 1.0]
}
equations! {
    /// q̈ + q̇ + q = f(t), with the force that makes q = sin 2t of it.
    Forced {}: 1, true,
    |self, t, [y], [y_dot], [q]| [y_dot + y + q - (2.0 * (2.0 * t).cos() - 3.0 * (2.0 * t).sin())],
    |t| [(t * 2.0).cos() * 2.0], [(t * 2.0).sin()]
}
equations! {
    /// ẏ = −λ(y − cos t) − sin t, of Prothero and Robinson (1974): y = cos t however stiff.
    ProtheroRobinson { rate: f64 }: 1, false,
    |self, t, [y], [y_dot], _| [y_dot + (y - t.cos()) * self.rate + t.sin()], |t| [t.cos()], [T::zero()]
}
equations! {
    /// ẏ = −z with a row that has no rate, z + z³ = y + y³: y = z = exp(−t).
    Constrained {}: 2, false,
    |self, _, [y, z], [y_dot, _], _| [y_dot + z, z + z.powi(3) - y - y.powi(3)], |t| [(-t).exp(); 2], [T::zero(); 2]
}

equations! {
    /// q̈ − μ(1 − q²)q̇ + q = 0 (van der Pol). `damping` is μ.
    VanDerPol { damping: f64 }: 1, true,
    |self, _, [y], [y_dot], [q]| [y_dot - (T::one() - q * q) * y * self.damping + q]
}
