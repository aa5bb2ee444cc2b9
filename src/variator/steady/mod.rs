//! Steady states, solved for directly.
//!
//! "Half" and "twice": changes of Jacobians and residuals, %, with half and twice the number, over
//! forty random starts of `ALE0`, a third of them beyond capacity. Up to 2 % is noise. The same
//! states are found.

pub mod refine;
pub mod solve;
pub mod start;
pub mod tangent;

/// First pseudo-time step, s. Half: +3, +4; twice: -2, -2, over 110 random starts, nine load cases
/// and two maps.
const FIRST_PSEUDO_STEP: f64 = 1.0e-3;
/// Pseudo-time step during the reduction of the friction velocity, s. With [`FIRST_PSEUDO_STEP`]
/// instead, one start in a hundred is not found. Half: -1, -2; twice: +1, +1, over the same.
const HOMOTOPY_STEP: f64 = 5.0e-3;
/// Time from which the state counts as steady, s: a belt revolution lasts 0.05 s, a ratio change
/// some seconds. Half and twice: 0, 0.
const STEADY_TIME: f64 = 200.0;
/// Most Newton solves of a continuation. A quarter of it: -27, -27, but in limits of the parameters
/// (no play, stiff belts, no oil) most states are not found.
const MOST_SOLVES: usize = 400;
/// Most Newton solves with the same factors from a neighbouring state: each corrects the set points
/// of force and ratio. Two to nine are used.
const FEW_SOLVES: usize = MOST_SOLVES / 16;
/// Negligible correction of the set point of Θ, and of a force or a ratio relative to it, from a
/// neighbouring state.
const NEGLIGIBLE: f64 = 1.0e-8;

/// Regularisation homotopy: first friction velocity, m/s, and factor of each reduction, down to the
/// specified one. At first, stick and slip are one smooth law, and Newton's method does not
/// alternate between them. Half (0.2): -2, -2 (-2, -1); twice (0.63): -1, 0 (+1, 0).
const HOMOTOPY_VELOCITY: f64 = 0.05;
const VELOCITY_REDUCTION: f64 = 0.4;

/// Clamping force below which a belt may be too loose to be found from a kinematic state, N: its
/// steady state under this force is then solved for first. Without, three of nine stiff belts are
/// not found. Half: -5, -6; twice: +7, +8.
const FIRM: f64 = 1.0e4;

/// Slip of a shaft whose speed is solved for, beyond which its pulley has run away: only drag
/// limits its speed, at many times the specified one. Without it, half of the starts beyond
/// capacity end so. Half: -4, -3; twice: -1, +1.
const RUN_AWAY: f64 = 0.3;

/// Time in which the set point of Θ is corrected, s. Half: -2, -1; twice: -1, -1.
const RATIO_TIME: f64 = 0.2;

/// Fewest elements of an arc and of a strand on a coarse mesh.
const FEWEST_ON_ARC: i32 = 6;
const FEWEST_ON_STRAND: i32 = 3;

/// Relative force error of an equilibrium. Half and twice: 0, 0.
pub(crate) const FORCE_ERROR: f64 = 1.0e-6;
