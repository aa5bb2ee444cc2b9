//! A linear model about a steady working point, for controller design.
//!
//! At a steady state the residual F(y, ẏ, q) − G u = 0 with q̇ = y has exact derivatives (the solver's Jacobian for
//! three choices of its factors α and β). With x = (y, q) this is a descriptor system E ẋ = A x + B u. Its eigenvalues
//! below a chosen frequency are found by shift and inversion, after balancing, because the unknowns have many units. Right
//! and left eigenvectors project on them (modal truncation). Faster modes are kept as a direct part D, so that the static
//! gain is exact. Outputs are differentiated along each mode by central differences.
//!
//! Method: Antoulas, Approximation of Large-Scale Dynamical Systems (2005), sections 9.1 and 9.2.

mod descriptor;
mod loads;
mod model;
mod modes;
mod working_point;

pub use loads::Load;
pub use model::{LinearModel, linearise, linearise_at};
pub use modes::modes;
pub use working_point::LinearError;
