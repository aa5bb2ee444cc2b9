//! A pushbelt element by element: an independent model that judges the belt of `pushbelt`.
//!
//! It takes parameters, radii, and the laws of flanks, tilt and shafts from there, and nothing of ring, stack, cells, mesh or solver.
//! Elements are unilateral contacts in the plane of the drive, the ring has a node an element that slides along the steel, and a step is
//! linearly implicit along the belt. Each law is at the head of its file.
//!
//! | module | content |
//! |---|---|
//! | [`case`] | what a run is about: ratio, force, share of the torque of full slip, speed; its start and its controller |
//! | [`law`] | constants from the parameters of the FMU, and what this model has beside them |
//! | [`frames`] | chords and frames of the elements |
//! | [`stack`], [`ring`], [`flanks`], [`pulleys`] | forces between elements, of the ring, at the sheaves; shafts, cones and tilt |
//! | [`cyclic`] | the equations along the belt |
//! | [`machine`] | the step, energies and losses, checks |
//! | [`run`] | means, fields along the belt, stored states |
//!
//! Not modelled: heads, pegs and turning elements of their own, friction between the layers of the ring, cylinders, end stops.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

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
