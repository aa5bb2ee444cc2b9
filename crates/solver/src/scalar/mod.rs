//! The scalar type that every law is generic over: a plain number, a pack of them, or either with derivatives.

mod lanes;
mod real;
mod smooth;
mod soft_tail;
mod tangent;
mod vectors;

pub use lanes::{LANES, Lanes};
pub use real::Real;
pub use smooth::soft_plus_energy_at;
pub use smooth::{smooth_plus, smooth_plus_energy, soft_plus_energy};
pub use tangent::Tangent;
pub use tangent::along;
pub use vectors::{turn_right, zero_vector};
