//! Parameters with their ranges, inputs, outputs.

pub(crate) mod capacity;
pub(crate) mod choices;
pub(crate) mod error;
pub(crate) mod parameters;
pub(crate) mod signals;
pub(crate) mod table;
pub(crate) mod validation;

pub use error::ParameterError;
pub use parameters::*;
pub use signals::*;
pub use table::{Setting, inputs, parameters, range_of};
pub use validation::bisected;

// Limits of refusals, starts and messages. No law has them.

/// Factor by which an initial ratio may exceed an end stop: a loaded belt rests up to 5 % beyond it, and a run may continue from there.
pub const BEYOND_STOP: f64 = 1.06;
/// Young's modulus (Pa) and density (kg/m³) of maraging steel, the means of the published variators, and their relative scatter: one
/// layer in ten is above it.
const RING_STEEL: (f64, f64) = (1.86e11, 7850.0);
const STEEL_SCATTER: f64 = 0.06;
/// Torque over that of full slip that a belt may carry: friction along the flanks may raise the capacity by some percent. A start does not try
/// more.
const BEYOND: f64 = 1.15;
/// Torque over the capacity from which a wrong unit explains it better than a slipping belt.
const FAR: f64 = 20.0;
/// Clamping force below which kN may be meant, N, and torque from which N·mm may be meant, N·m.
const PLAUSIBLE_FORCE: f64 = 1.0e3;
const PLAUSIBLE_TORQUE: f64 = 2.0e3;
/// Stretch of a ring under its centrifugal tension that no steel bears.
const BROKEN: f64 = 0.02;
