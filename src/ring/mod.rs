//! The ring (paper 3, 4): mesh, kinematics with its virtual power, the beam law.

pub mod ale;
pub mod joints;
pub mod kinematics;
pub mod layers;
pub mod mesh;
mod parameters;
pub mod stress;

pub use joints::Joints;
pub use layers::Layers;
pub use parameters::Ring;
