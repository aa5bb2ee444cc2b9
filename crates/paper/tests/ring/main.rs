//! The ring alone: kinematics, inertia and elasticity against differences, and motions with known answers. Every check
//! runs for every ring model ([`models`]); what only one of them has is in [`ale`]. The measurements are those of
//! `pushbelt_paper_lab`, which the report on the paper shows too.

mod ale;
mod drive;
mod models;
mod spatial;
