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

// Limits of refusals, starts and messages.

/// Factor by which an initial ratio may exceed an end stop: a loaded belt rests up to 5 % beyond
/// it, and a run may continue from there.
pub const BEYOND_STOP: f64 = 1.06;
/// Relative scatter of modulus and density of published rings' steel about the default; one layer
/// in ten is above it.
const STEEL_SCATTER: f64 = 0.06;
/// Stretch of a ring under the centrifugal tension that no steel bears.
const RUPTURE: f64 = 0.02;
/// Most torque that a start tries, over that of full slip: friction along the flanks may raise the
/// capacity by some percent.
const MOST_OVER_FULL_SLIP: f64 = 1.15;
/// Torque over the capacity from which a wrong unit explains it better than a slipping belt.
const WRONG_UNIT: f64 = 20.0;
