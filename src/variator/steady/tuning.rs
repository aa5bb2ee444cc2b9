//! The numbers that the search for a steady state is tuned with.

/// First pseudo-time step, s: 5 to 13 % less work than with 1e-2 from a steady state and 1e-6 from the kinematic one.
pub const FIRST_STEP: f64 = 1.0e-3;
/// Pseudo-time step from which on the friction velocity is reduced, and which is kept meanwhile, s. With [`FIRST_STEP`] instead, one start in
/// a hundred is not found.
pub const HOMOTOPY_STEP: f64 = 5.0e-3;
/// Time from which the state counts as steady, s: a belt revolution lasts 0.05 s, a ratio change some seconds.
pub const STEADY_TIME: f64 = 200.0;
/// Most Newton solves of a continuation.
pub const MOST_SOLVES: usize = 400;

/// Regularisation homotopy: friction velocity that the solution starts with, m/s, and the factor of each reduction, down to the specified one.
/// At first, stick and slip are one smooth law, and Newton's method does not alternate between them.
pub const HOMOTOPY_VELOCITY: f64 = 0.05;
pub const VELOCITY_REDUCTION: f64 = 0.4;

/// Clamping force below which a belt may be too loose to be found from a kinematic state, N, and the factor of the force whose steady state
/// is then solved for first: without, three of nine stiff belts are not found.
pub const FIRM: f64 = 1.0e4;
pub const FIRMER: f64 = 3.0;

/// Distance in ln(ratio) of a neighbouring state, from which the specified friction velocity is tried first: without, 5 to 15 % more work.
pub const NEAR: f64 = 0.02;

/// Slip of a shaft whose speed is solved for, beyond which its pulley has run away: only drag would limit its speed, at many
/// times the specified one. Without it, half of the starts beyond capacity end in such a state.
pub const RUN_AWAY: f64 = 0.3;

/// Times in which the reaction force and the set point of Θ are corrected, s: 1 to 9 % more work with 0.05 s for both.
pub const FORCE_TIME: f64 = 0.02;
pub const RATIO_TIME: f64 = 0.2;

/// Fewest elements of an arc and of a strand on a coarse mesh.
pub const FEWEST: [i32; 2] = [6, 3];

/// Relative force error of an equilibrium.
pub const FORCE_ERROR: f64 = 1.0e-6;
/// Largest change of ln(ratio) from one state to the next, both solved for from the kinematic one: a small change needs as many solves
/// as a large one. Where there is no such state, it is [`NEAR`], from the last state.
pub const LONGEST_WAY: f64 = 0.5;
/// Number of stages in which the force is applied to a sheave that comes to rest at its end stop.
pub const STOP_STAGES: i32 = 8;
