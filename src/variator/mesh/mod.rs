//! The mesh along the belt, and the indices of the unknowns.

pub(crate) mod belt_mesh;
pub mod layout;
