//! A linear model about a steady working point, for controller design (`docs/theory.md`, section
//! 11).
//!
//! At a steady state the residual F(y, ẏ, q) − G u = 0 with q̇ = y is a descriptor system
//! E ẋ = A x + B u with x = (y, q). Its eigenvalues below a chosen frequency are found by shift and
//! inversion, after balancing, because the unknowns have many units. Right and left eigenvectors
//! project on them (Antoulas, Approximation of Large-Scale Dynamical Systems, 2005, sections 9.1
//! and 9.2). Faster modes are a direct part D, so that the static gain is exact. Outputs are
//! differentiated along each mode by central differences.

mod descriptor;
mod loads;
mod model;
mod modes;
mod working_point;

pub use loads::Load;
pub use model::{LinearModel, linearise, linearise_at};
pub use modes::modes;
pub use working_point::LinearError;

/// Shift as a fraction of the cut-off: eigenvalues near the shift have the least rounding errors.
/// The static gain is evaluated there too, because of the neutral modes at 0. Ten times as much: up
/// to 7e-7 of the poles, but a tenth of D, which then no longer has the static gain.
const SHIFT: f64 = 1.0e-3;
/// Modes slower than this, 1/s, are conserved quantities that no load changes: the gauge of the
/// overlay. The slowest mode that loads excite crosses zero between working points and is then some
/// 1e-3. Half or double: nothing.
const NEUTRAL: f64 = 1.0e-5;
/// Largest Θ̇ of a working point, 1/s.
const STEADY: f64 = 1.0e-4;
/// Largest relative difference between a specified load and the required one that causes no remark.
const SAME: f64 = 0.01;
