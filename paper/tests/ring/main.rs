//! The ring alone: kinematics, inertia and elasticity against differences, and motions with known
//! answers. [`models`] runs its checks for every ring model; [`ale`] is specific to the Eulerian
//! ring. The measurements are those of `pushbelt_paper_lab`, which the report on the paper also
//! uses.

mod ale;
mod drive;
mod drive_curve;
mod models;
mod printed;
mod spatial;
mod system;
