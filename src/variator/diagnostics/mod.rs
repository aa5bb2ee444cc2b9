//! Evaluation of a state: losses and energies, the energy balance of a run, outputs.

pub mod belt;
pub(crate) mod energy_balance;
mod idle_arc;
pub mod observe;

// Limits that define outputs and are not in the equations of motion. Only the flag of macro-slip
// decides whether a steady state may be a start.

/// Rim speed below which slip and the ratio of the speeds are 0, m/s.
const NO_SPEED: f64 = 1.0e-3;
/// Normal force per flank and length up to which a profile shows no sliding, N/m: a hundredth of an
/// arc's under 1 kN.
const UNLOADED: f64 = 100.0;
/// Least mean sliding speed of a pulley that slips through, as the sum of these fractions of the
/// regularisation velocity and of the rim speed: micro-slip is below a hundredth of the rim speed.
const SLIPPING_VELOCITY: f64 = 10.0;
const SLIPPING_RIM: f64 = 0.02;
/// Least fraction of the load that then slides in one direction.
const ONE_WAY: f64 = 0.99;
/// Fraction of that sliding speed from which a pulley that slipped through still does.
const STILL_SLIPPING: f64 = 0.5;
/// Change of the push force along the idle arc over the difference between the strands.
const IDLE_CHANGE: f64 = 0.1;
/// Difference between the push forces of the strands below which the whole wrap is idle, N.
const NO_DIFFERENCE: f64 = 20.0;
