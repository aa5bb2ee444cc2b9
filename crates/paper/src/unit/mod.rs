//! `PushbeltPaper.fmu`: the variator with the belts that the paper compares.

#[cfg(feature = "fmu")]
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi;
#[forbid(unsafe_code)]
mod rings;

pub use rings::{PaperRings, PaperUnit, model_description};
