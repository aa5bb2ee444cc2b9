//! Evaluation of a state: losses and energies, the energy balance of a run, outputs.

pub mod belt;
pub(crate) mod energy_balance;
mod idle_arc;
pub mod observe;

// Limits that define outputs. The equations of motion have none of them, so none changes a run;
// only the flag of macro-slip decides whether a steady state may be a start.

/// Rim speed below which slip and the ratio of the speeds are 0, m/s.
const NO_SPEED: f64 = 1.0e-3;
/// Normal force per flank and length up to which a profile shows no sliding, N/m: a hundredth of
/// that of an arc under 1 kN.
const UNLOADED: f64 = 100.0;
/// Mean sliding speed from which a pulley slips through, as fractions of the regularisation
/// velocity and of the rim speed: micro-slip of a belt that grips is below a hundredth of the rim
/// speed.
const SLIPPING: [f64; 2] = [10.0, 0.02];
/// Least fraction of the load that slides one way then.
const ONE_WAY: f64 = 0.99;
/// Share of the mean sliding speed from which it still slips through then.
const STILL_SLIPPING: f64 = 0.5;
/// Share of the difference between the strands by which the push force changes at the end of the
/// idle arc.
const IDLE_CHANGE: f64 = 0.1;
/// Difference between the push forces of the strands below which the whole wrap is idle, N.
const NO_DIFFERENCE: f64 = 20.0;
