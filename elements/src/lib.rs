//! A pushbelt element by element: an independent model that judges the belt of `pushbelt`.
//!
//! It takes parameters, radii and the law of a flank's friction from there, and nothing of ring, stack, cells, mesh or solver.
pub mod case;
pub mod cyclic;
pub mod flanks;
pub mod frames;
pub mod law;
pub mod machine;
pub mod pulleys;
pub mod ring;
pub mod run;
pub mod stack;
