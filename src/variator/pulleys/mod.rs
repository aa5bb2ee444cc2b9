//! Shafts and sheaves: what drives them, and their equations of motion.

pub mod loads;
pub(crate) mod rows;
