//! Rings whose nodes travel with the material, under the cells.

pub(crate) mod assembly;
mod evaluation;
mod passing;
pub(crate) mod start;
