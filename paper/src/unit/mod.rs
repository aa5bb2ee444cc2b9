//! `PushbeltPaper.fmu`: the variator with the belts of the paper's comparison.

#[cfg(feature = "fmu")]
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi;
#[forbid(unsafe_code)]
mod rings;

pub use rings::{PaperRings, PaperUnit, model_description};
