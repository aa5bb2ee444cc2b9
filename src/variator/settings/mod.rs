//! Parameters with their ranges, inputs, outputs.

pub(crate) mod capacity;
pub(crate) mod choices;
pub(crate) mod parameters;
pub(crate) mod signals;
pub(crate) mod table;
pub(crate) mod validation;

pub use parameters::*;
pub use signals::*;
pub use table::{Setting, inputs, parameters, range_of};
pub use validation::{ParameterError, bisected};

// Limits of refusals, starts and messages. No law has them.

/// Factor by which an initial ratio may exceed an end stop: a loaded belt rests up to 5 % beyond it, and a run may continue from there.
pub const BEYOND_STOP: f64 = 1.06;
/// Ring steel: Young's modulus (Pa) and density (kg/m³) of maraging steel, the means of the published variators; their relative scatter, one
/// layer in ten is above it; and a stretch under the centrifugal tension that none bears.
const RING_STEEL: (f64, f64, f64, f64) = (1.86e11, 7850.0, 0.06, 0.02);
/// Torque over that of full slip that a belt may carry: friction along the flanks may raise the capacity by some percent. A start does not try
/// more.
const BEYOND: f64 = 1.15;
/// Torque over the capacity from which a wrong unit explains it better than a slipping belt.
const FAR: f64 = 20.0;
/// Clamping force below which kN may be meant, N, and torque from which N·mm may be meant, N·m.
const PLAUSIBLE: (f64, f64) = (1.0e3, 2.0e3);
