//! What the paper compares with the deflecting ring of the FMU, and no part of it.
//!
//! | module | content |
//! |---|---|
//! | [`ring`] | ring models behind one trait: `ALE`, `RCM`, `ANCF`; the ring alone as a system |
//! | [`reference_curve`] | a curve that the mesh does not follow, and a circle |
//! | [`belts`] | the seven belts that the paper compares, as rings of a variator |
//! | [`mod@unit`] | `PushbeltPaper.fmu`: the FMU's variables and those that choose among these belts |
//!
//! Numbers in parentheses are those of Grundl, Schindler, Ulbrich, Rixen, *ALE beam using reference dynamics* (2019).
#![warn(missing_docs)]

#[forbid(unsafe_code)]
pub mod belts;
#[forbid(unsafe_code)]
mod even;
#[forbid(unsafe_code)]
pub mod reference_curve;
#[forbid(unsafe_code)]
pub mod ring;
#[forbid(unsafe_code)]
mod rotating;
#[forbid(unsafe_code)]
mod travelling;
pub mod unit;

use pushbelt::{scalar, solver};
