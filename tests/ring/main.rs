//! The ring alone: kinematics, inertia and elasticity against differences, and motions with known answers. Every check
//! runs for every ring model ([`models`]); what only one of them has is in [`ale`]. [`measure`] holds what the report
//! on the paper measures too.

mod ale;
mod common;
mod drive;
#[allow(dead_code, reason = "the report on the paper uses the rest")]
mod measure;
mod models;
mod spatial;
