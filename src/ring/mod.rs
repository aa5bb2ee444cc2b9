//! The ring (paper 3, 4): mesh, kinematics with its virtual power, the beam law.

#![forbid(unsafe_code)]

pub mod ale;
mod energy;
pub mod kinematics;
pub mod layers;
pub mod mesh;
mod parameters;

pub use energy::Energy;
pub use parameters::Ring;
