//! Ring models behind one trait, [`model::RingFormulation`]: [`ale_ring::AleRing`], [`ancf::Ancf`]
//! and [`rcm::Rcm`].

pub mod ale_ring;
pub mod ancf;
pub(crate) mod beam;
mod energy;
pub mod lagrangian;
pub mod mesh;
pub mod model;
pub mod particle;
pub mod rcm;
pub(crate) mod rotated;

pub use energy::Energy;
pub use pushbelt::ring::{Ring, ale, kinematics};
