//! The mesh along the belt, and where each unknown stands.

pub mod belt_mesh;
pub mod layout;
pub(crate) mod order;
