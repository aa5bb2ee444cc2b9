//! The variator in runs and steady states. One binary, because compiling each of these files alone
//! takes longer than its tests.

mod at_rest;
mod boundaries;
mod chain;
mod cylinder;
mod film;
mod hints;
mod jacobian;
mod limits;
mod loads;
mod losses;
mod neighbours;
mod outputs;
mod runs;
mod spatial;
mod steady;
mod stress;
