//! Implicit solution of stiff systems around a loop, independent of any belt: F(t, y, ẏ, q) = 0
//! with q̇ = y for the unknowns that have a position: velocities of a mechanical system and
//! first-order states stand side by side, positions are eliminated, and the Jacobian is an
//! [`arrow::Arrow`].

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod arrow;
mod broyden;
pub mod continuation;
mod kernels;
pub mod newton;
pub mod scalar;
pub mod sdirk;
#[cfg(test)]
mod tests;

use arrow::{Arrow, Shape};
use pushbelt_archive::Archive;

/// Arguments of a residual.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Unknowns.
    pub y: &'a [f64],
    /// Their rates.
    pub y_dot: &'a [f64],
    /// Positions; entries of unknowns without a position are unused.
    pub q: &'a [f64],
}

/// A state: unknowns, their rates, and positions in the order of the unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// y.
    pub y: Vec<f64>,
    /// ẏ.
    pub y_dot: Vec<f64>,
    /// q, with q̇ = y; entries of unknowns without a position are unused.
    pub q: Vec<f64>,
}

impl State {
    /// Zeros, for so many unknowns.
    #[must_use]
    pub fn zero(unknowns: usize) -> Self {
        let zeros = vec![0.0; unknowns];
        Self {
            y: zeros.clone(),
            y_dot: zeros.clone(),
            q: zeros,
        }
    }

    /// View for a residual.
    #[must_use]
    pub fn view(&self) -> View<'_> {
        View {
            y: &self.y,
            y_dot: &self.y_dot,
            q: &self.q,
        }
    }

    /// Becomes a copy of `other`, without an allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.y.copy_from_slice(&other.y);
        self.y_dot.copy_from_slice(&other.y_dot);
        self.q.copy_from_slice(&other.q);
    }

    /// Writes to an archive, or reads from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let Self { y, y_dot, q } = self;
        for values in [y, y_dot, q] {
            archive.reals(values);
        }
    }
}

/// Factors of ∂F/∂ẏ and ∂F/∂q in the Jacobian ∂F/∂y + α ∂F/∂ẏ + β ∂F/∂q: the derivatives of ẏ and q
/// with respect to y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// α, 1/s.
    pub alpha: f64,
    /// β, s.
    pub beta: f64,
}

impl Factors {
    /// Those of ∂F/∂y alone.
    pub const ZERO: Self = Self { alpha: 0.0, beta: 0.0 };
}

/// An implicit system.
pub trait System {
    /// Shape of the Jacobian; its length is the number of unknowns.
    fn shape(&self) -> Shape;

    /// Whether each unknown is the rate of a position.
    fn has_position(&self) -> &[bool];

    /// F(t, y, ẏ, q) at `time`, s.
    fn residual(&mut self, time: f64, view: View<'_>, out: &mut [f64]);

    /// ∂F/∂y + α ∂F/∂ẏ + β ∂F/∂q at `time`, s.
    fn jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow);

    /// The Jacobian for Newton's method: derivatives that have hardly changed may be those of an
    /// earlier one. Returns the fraction of the derivatives that was evaluated anew, beside
    /// constitutive tangents.
    fn renew_jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) -> f64 {
        self.jacobian(time, view, alpha, beta, out);
        1.0
    }

    /// Absolute size of a change of each unknown that does not matter, in a step with dq/dy = β.
    fn newton_scale(&self, beta: f64, out: &mut [f64]);
}
