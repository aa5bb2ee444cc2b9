//! Ring models that the paper compares with the deflecting ring of the FMU. They are not part of
//! that FMU.
//!
//! | module | content |
//! |---|---|
//! | [`ring`] | ring models behind one trait: `ALE`, `RCM`, `ANCF` |
//! | [`reference_curve`] | a curve whose arcs the mesh does not follow |
//! | [`centred`] | `ALE0` with arcs about the axes |
//! | [`belts`] | the other seven belts of the paper's comparison, as rings of a variator |
//! | [`mod@unit`] | `PushbeltPaper.fmu`: the variables of the FMU and those that select a belt |
//!
//! Numbers in parentheses are those of Grundl, Schindler, Ulbrich, Rixen, *ALE beam using reference
//! dynamics* (2019).
#![warn(missing_docs)]

pub mod belts;
pub mod centred;
mod even;
pub mod reference_curve;
pub mod ring;
mod rotating;
mod travelling;
pub mod unit;

use pushbelt::{scalar, solver};
