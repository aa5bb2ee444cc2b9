//! Accuracy against time, and bounds of iterations. Relative changes of slip, loss, speeds and
//! ratio with half and double the number were measured in 13 runs.

/// Longest step, s. Half or double: 2e-3 of the slip after a jump of a set point, else 2e-4.
pub const LONGEST: f64 = 1e-2;
/// Shortest step, s: a step that does not converge is divided down to it. Half or double: nothing.
pub const SHORTEST: f64 = 1e-7;
/// Most steps of a communication step, and more for each of the longest ones in it. Half or double:
/// nothing.
pub const MOST_STEPS: f64 = 1e5;
pub const MOST_PER_LONGEST: f64 = 100.0;
/// Largest speed and largest input in a stored state, SI units, far beyond what a shaft stands.
pub const MAX_STORED_SPEED: f64 = 1e9;
pub const MAX_STORED_INPUT: f64 = 1e9;

/// Regularisation speed v_0 of the slip, m/s. Half or double: 5e-2 of the slip at 2 rad/s, 2e-4 of
/// that at 150 rad/s.
pub const SLIP_SPEED: f64 = 0.1;
/// Smallest force in a quotient of forces, N. Half or double: nothing.
pub const LEAST_FORCE: f64 = 1.0;

/// Largest numbers of iterations of a stage, of those for its sliding speed within each of them,
/// and of those for the thrust ratio at the start. Half of all: 7e-6; double: nothing.
pub const STAGE_ITERATIONS: usize = 80;
pub const SLIDING_ITERATIONS: usize = 80;
pub const START_ITERATIONS: usize = 80;
/// Relative tolerance of speeds, and tolerance of ln i; tolerance of utilisation and thrust ratio
/// at the start. Half or double of both: 4e-6 in a launch, else 4e-7.
pub const TOLERANCE: f64 = 1e-9;
pub const START_TOLERANCE: f64 = 1e-9;
/// Bound of the coupling of the ratio, as a fraction of the coupling by the torque. Half or double:
/// nothing.
pub const LEAST_FRACTION: f64 = 0.5;

/// Numbers of points of the refined tables: ratios, torques of the belt, slips of the
/// traction, excesses of the shift rates. Half of one: 8e-4, 1.3e-3, 1.7e-3, 5e-4; double: 5e-4,
/// 4e-4, 6e-4, 2e-4.
pub const RATIOS: usize = 65;
pub const TORQUES: usize = 97;
pub const SHARES: usize = 257;
pub const EXCESSES: usize = 97;
/// Number of points of the table of radii, and its range of ln i beyond the end stops: a radius
/// errs by less than a micrometre. Half of one: 8e-6, 2e-6; double: 2e-6, 1e-6. Without the table a
/// run takes a quarter more time.
pub const RADII: usize = 257;
pub const BEYOND_STOPS: f64 = 0.05;
