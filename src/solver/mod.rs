//! Implicit solution of stiff systems around a loop. Knows no belt.
//!
//! A system is F(y, ẏ, q) = 0 with q̇ = y for the unknowns that have a position: velocities of a mechanical system
//! and first-order states stand side by side, positions are eliminated, and the Jacobian is an [`arrow::Arrow`].

pub mod arrow;
pub mod continuation;
mod kernels;
pub mod newton;
pub mod sdirk;

use arrow::{Arrow, Shape};

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

/// An implicit system.
pub trait System {
    /// Shape of the Jacobian; its length is the number of unknowns.
    fn shape(&self) -> Shape;

    /// Whether each unknown is the rate of a position.
    fn has_position(&self) -> &[bool];

    /// F(y, ẏ, q).
    fn residual(&mut self, view: View<'_>, out: &mut [f64]);

    /// ∂F/∂y + α ∂F/∂ẏ + β ∂F/∂q.
    fn jacobian(&mut self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow);

    /// The Jacobian for Newton's method: derivatives that have hardly changed may be those of an earlier one.
    fn renew_jacobian(&mut self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        self.jacobian(view, alpha, beta, out);
    }

    /// Absolute size of a change of each unknown that does not matter, in a step with dq/dy = β.
    fn newton_scale(&self, beta: f64, out: &mut [f64]);
}
