//! Small problems, each with its solution, and what a [`System`] needs beyond their equations.

use std::cell::Cell;
use std::f64::consts::TAU;

use num_dual::{Dual64, DualNum};

use super::super::arrow::{Arrow, Shape};
use super::super::sdirk::{Evolution, Interval, Sdirk, Stalled};
use super::super::{State, System, View};

/// What the equations of a problem are made of: a number, or one with a derivative.
pub trait Real: DualNum<Primitive = f64> + Copy {}

impl<T: DualNum<Primitive = f64> + Copy> Real for T {}

/// N equations F(t, y, ẏ, q) = 0.
pub trait Equations<const N: usize> {
    /// Which unknowns are the rate of a position.
    const HAS_POSITION: [bool; N];

    /// F.
    fn residual<T: Real>(&self, time: f64, y: [T; N], y_dot: [T; N], q: [T; N]) -> [T; N];

    /// Where the equations stand in the matrix. By default all stand in the border, beside a loop of three blocks that
    /// do nothing.
    fn shape(&self) -> Shape {
        Shape {
            blocks: 3,
            block: 1,
            border: N,
        }
    }
}

/// A problem whose solution is known for all times.
pub trait Solved<const N: usize>: Equations<N> {
    /// y and q of the solution.
    fn exact<T: Real>(&self, time: T) -> [[T; N]; 2];
}

/// Equations as a system; unknowns of the loop that stand before them stay 0.
pub struct Test<E, const N: usize> {
    pub equations: E,
    has_position: Vec<bool>,
    /// First of the unknowns of the equations.
    first: usize,
    /// What Newton's method may leave of each unknown.
    pub newton_scale: [f64; N],
    /// Of a step's error, relative and absolute; with infinity every step is accepted.
    pub tolerance: f64,
    /// The last step's estimated errors of y and q, the largest of each.
    pub estimate: Cell<[f64; 2]>,
    /// Time of the steps that were accepted.
    pub accepted: Vec<Interval>,
    /// ∫y dt by the trapezoidal rule.
    pub integral: [f64; N],
}

impl<E: Equations<N>, const N: usize> Test<E, N> {
    pub fn new(equations: E) -> Self {
        let first = equations.shape().len() - N;
        let mut has_position = vec![false; first];
        has_position.extend(E::HAS_POSITION);
        Self {
            equations,
            has_position,
            first,
            newton_scale: [1e-12; N],
            tolerance: f64::INFINITY,
            estimate: Cell::default(),
            accepted: Vec::new(),
            integral: [0.0; N],
        }
    }

    /// All unknowns, from those of the equations.
    fn unknowns(&self, values: [f64; N]) -> Vec<f64> {
        let mut all = vec![0.0; self.first];
        all.extend(values);
        all
    }

    /// A state from the unknowns of the equations.
    pub fn at(&self, y: [f64; N], y_dot: [f64; N], q: [f64; N]) -> State {
        let [y, y_dot, q] = [y, y_dot, q].map(|values| self.unknowns(values));
        State { y, y_dot, q }
    }

    /// Values of the equations' unknowns.
    pub fn values(&self, all: &[f64]) -> [f64; N] {
        std::array::from_fn(|i| all[self.first + i])
    }

    fn evaluate<T: Real>(&self, time: f64, view: View<'_>, vary: impl Fn(f64, usize, usize) -> T) -> [T; N] {
        let varied = |all: &[f64], kind: usize| {
            let values = self.values(all);
            std::array::from_fn(|i| vary(values[i], i, kind))
        };
        self.equations
            .residual(time, varied(view.y, 0), varied(view.y_dot, 1), varied(view.q, 2))
    }
}

impl<E: Solved<N>, const N: usize> Test<E, N> {
    /// The solution.
    pub fn state(&self, time: f64) -> State {
        let [y, q] = self.equations.exact(Dual64::new(time, 1.0));
        self.at(y.map(|y| y.re), y.map(|y| y.eps), q.map(|q| q.re))
    }

    /// Largest error of y and of q.
    pub fn error(&self, state: &State, time: f64) -> [f64; 2] {
        let exact = self.state(time);
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        [largest(&state.y, &exact.y), largest(&state.q, &exact.q)]
    }
}

/// Integrator with steps of one size.
pub fn fixed(system: &impl System, step: f64) -> Sdirk {
    Sdirk::new(system, step, step)
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
    integrator.advance(system, state, 0.0, to)?;
    Ok(integrator)
}

impl<E: Equations<N>, const N: usize> System for Test<E, N> {
    fn shape(&self) -> Shape {
        self.equations.shape()
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, time: f64, view: View<'_>, out: &mut [f64]) {
        let (idle, rows) = out.split_at_mut(self.first);
        idle.copy_from_slice(&view.y[..self.first]);
        rows.copy_from_slice(&self.evaluate(time, view, |value, _, _| value));
    }

    fn jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        out.clear();
        (0..self.first).for_each(|i| out.add(i, i, 1.0));
        for column in 0..N {
            let rows = self.evaluate(time, view, |value, i, kind| {
                let slope = if i == column { [1.0, alpha, beta][kind] } else { 0.0 };
                Dual64::new(value, slope)
            });
            for (row, value) in rows.iter().enumerate().filter(|(_, value)| value.eps != 0.0) {
                out.add(self.first + row, self.first + column, value.eps);
            }
        }
    }

    fn newton_scale(&self, _beta: f64, out: &mut [f64]) {
        out.copy_from_slice(&self.unknowns(self.newton_scale));
        out[..self.first].fill(1.0);
    }
}

impl<E: Equations<N>, const N: usize> Evolution for Test<E, N> {
    fn error_norm(&self, view: View<'_>, y_error: &[f64], q_error: &[f64]) -> f64 {
        let largest = |errors: &[f64], used: fn(bool) -> bool| {
            let errors = errors.iter().zip(&self.has_position).filter(|(_, has)| used(**has));
            errors.fold(0.0_f64, |most, (error, _)| most.max(error.abs()))
        };
        self.estimate
            .set([largest(y_error, |_| true), largest(q_error, |has| has)]);
        let mut norm = 0.0_f64;
        for (i, &has) in self.has_position.iter().enumerate() {
            norm = norm.max(y_error[i].abs() / (1.0 + view.y[i].abs()));
            if has {
                norm = norm.max(q_error[i].abs() / (1.0 + view.q[i].abs()));
            }
        }
        norm / self.tolerance
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, interval: Interval) {
        let (first, last) = (self.values(before.y), self.values(after.y));
        for (i, sum) in self.integral.iter_mut().enumerate() {
            *sum += 0.5 * interval.length * (first[i] + last[i]);
        }
        self.accepted.push(interval);
    }
}

/// N equations, whether their unknowns are rates of positions, and y and q of their solution if that is known.
macro_rules! equations {
    (
        $(#[$doc:meta])* $name:ident { $($field:ident: $type:ty),* }: $n:literal, $has_position:literal,
        |$self:ident, $time:pat, $y:pat, $y_dot:pat, $q:pat_param| $residual:expr $(, |$at:ident| $exact:expr)?
    ) => {
        $(#[$doc])*
        pub struct $name {
            $(pub $field: $type),*
        }

        impl Equations<$n> for $name {
            const HAS_POSITION: [bool; $n] = [$has_position; $n];

            fn residual<T: Real>(&$self, $time: f64, $y: [T; $n], $y_dot: [T; $n], $q: [T; $n]) -> [T; $n] {
                $residual
            }
        }

        $(impl Solved<$n> for $name {
            fn exact<T: Real>(&$self, $at: T) -> [[T; $n]; 2] {
                $exact
            }
        })?
    };
}
pub(super) use equations;

equations! {
    /// ẏ = −y: y = exp(−t).
    Decay {}: 1, false, |self, _, [y], [y_dot], _| [y_dot + y], |t| [[(-t).exp()], [T::zero()]]
}
equations! {
    /// ẏ = cos t with q̇ = y: nothing but quadrature. y = sin t, q = 1 − cos t.
    Quadrature {}: 1, true, |self, t, _, [y_dot], _| [y_dot - t.cos()], |t| [[t.sin()], [-t.cos() + 1.0]]
}
equations! {
    /// ẏ = y cos t, not autonomous: y = exp(sin t).
    Swelling {}: 1, false, |self, t, [y], [y_dot], _| [y_dot - y * t.cos()], |t| [[t.sin().exp()], [T::zero()]]
}
equations! {
    /// q̈ + 9 q = 0: q = cos 3t.
    Oscillator {}: 1, true, |self, _, _, [y_dot], [q]| [y_dot + q * 9.0],
    |t| [[(t * 3.0).sin() * -3.0], [(t * 3.0).cos()]]
}
equations! {
    /// q̈ + q̇ + q = f(t), with the force that makes q = sin 2t of it.
    Forced {}: 1, true,
    |self, t, [y], [y_dot], [q]| [y_dot + y + q - (2.0 * (2.0 * t).cos() - 3.0 * (2.0 * t).sin())],
    |t| [[(t * 2.0).cos() * 2.0], [(t * 2.0).sin()]]
}
equations! {
    /// ẏ = −λ(y − cos t) − sin t, of Prothero and Robinson (1974): y = cos t however stiff.
    ProtheroRobinson { rate: f64 }: 1, false,
    |self, t, [y], [y_dot], _| [y_dot + (y - t.cos()) * self.rate + t.sin()], |t| [[t.cos()], [T::zero()]]
}
equations! {
    /// ẏ = −z with a row that has no rate, z + z³ = y + y³: y = z = exp(−t).
    Constrained {}: 2, false,
    |self, _, [y, z], [y_dot, _], _| [y_dot + z, z + z.powi(3) - y - y.powi(3)], |t| [[(-t).exp(); 2], [T::zero(); 2]]
}

/// Cells around the loop of the matrix.
pub const CELLS: usize = 8;

/// Waves around a loop, q̈ᵢ = qᵢ₋₁ − 2qᵢ + qᵢ₊₁: the square of its first mode's frequency is 2(1 − cos(2π/n)).
pub struct Wave;

impl Equations<CELLS> for Wave {
    const HAS_POSITION: [bool; CELLS] = [true; CELLS];

    fn residual<T: Real>(&self, _time: f64, _y: [T; CELLS], y_dot: [T; CELLS], q: [T; CELLS]) -> [T; CELLS] {
        let neighbours = |i: usize| q[(i + CELLS - 1) % CELLS] - q[i] * 2.0 + q[(i + 1) % CELLS];
        std::array::from_fn(|i| y_dot[i] - neighbours(i))
    }

    fn shape(&self) -> Shape {
        Shape {
            blocks: CELLS / 2,
            block: 2,
            border: 0,
        }
    }
}

impl Solved<CELLS> for Wave {
    fn exact<T: Real>(&self, time: T) -> [[T; CELLS]; 2] {
        let w = (2.0 * (1.0 - (TAU / CELLS as f64).cos())).sqrt();
        let mode = |i: usize| (TAU * i as f64 / CELLS as f64 + 0.3).cos();
        let (sin, cos) = (time * w).sin_cos();
        [
            std::array::from_fn(|i| sin * (-w * mode(i))),
            std::array::from_fn(|i| cos * mode(i)),
        ]
    }
}

equations! {
    /// q̈ − μ(1 − q²)q̇ + q = 0 (van der Pol). `damping` is μ.
    VanDerPol { damping: f64 }: 1, true,
    |self, _, [y], [y_dot], [q]| [y_dot - (T::one() - q * q) * y * self.damping + q]
}
