//! The ring (paper 3, 4): mesh, kinematics with its virtual power, the beam law, and the ring alone as a system. Three
//! models stand behind [`model::RingFormulation`]: [`ale_ring::AleRing`], [`ancf::Ancf`] and [`rcm::Rcm`].

#![forbid(unsafe_code)]

#[doc(hidden)]
pub mod ale;
pub mod ale_ring;
pub mod ancf;
pub(crate) mod beam;
pub mod kinematics;
pub mod lagrangian;
pub mod layers;
pub mod mesh;
pub mod model;
mod parameters;
pub mod particle;
pub mod rcm;
pub(crate) mod rotated;
pub mod system;

pub use parameters::Ring;
