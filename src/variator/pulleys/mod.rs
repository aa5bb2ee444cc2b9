//! Shafts and sheaves: their loads and their equations of motion.

pub mod loads;
pub(crate) mod rows;
