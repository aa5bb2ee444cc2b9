//! The numbers that runs and their starts are tuned with. "Half" and "twice" are the changes of
//! Jacobians and residuals, %, with half and twice the number and `ALE0`: of runs over 0.15 s of
//! each of the ten rough loads, accurate or in real time; of starts over eight at a standstill, or
//! over forty steady ones at random. Up to 2 % is noise. A number without them bounds, measures or
//! reports, and changes no counts.

/// First step of a run, s: from a steady state, and from another one. Half: +1, 0 and 0, 0; twice:
/// -1, -1 and 0, 0. With a step between them for both, short runs take more Jacobians, and a chain
/// that sticks three times as many in its first milliseconds.
pub const FIRST_STEP: f64 = 1.0e-4;
pub const COLD_STEP: f64 = 1.0e-6;
/// Half the distance in time over which outputs are differentiated, s: the loads of the flanks are
/// linear over it, and it leaves nine digits of a difference.
pub const MOMENT: f64 = 1.0e-6;

/// Newton's tolerance at the default solver tolerance, in units of the Newton scale: tenfold
/// changes no output of the manoeuvre in the fourth digit. Half: 0, +5; twice: -2, -7.
pub const NEWTON_TOLERANCE: f64 = 20.0;
/// How many times wider it is where steps err as much as is tolerated. What an iteration then
/// leaves is some tenth of such an error, as in CVODE (Hindmarsh et al. 2005). Less so at tighter
/// tolerances: they serve to compare small differences. Half: +2, +3; twice: +2, -3.
pub const NEWTON_WIDENING: f64 = 60.0;
/// Limits of Newton's tolerance at other solver tolerances.
pub const NEWTON_LIMITS: [f64; 2] = [0.05, 100.0];

/// Residuals that an accurate communication step, or a belt that settles before a start, may take,
/// and more for each second of it: twenty times what loads that jump take.
pub const STEP_RESIDUALS: f64 = 1.0e4;
pub const STEP_RESIDUALS_PER_SECOND: f64 = 5.0e5;
/// Most work of the search for a steady state, in residuals. Of some 220 starts, two thirds of them
/// at random with both rings and chains, a steady state took at most 49 000, one at reduced torque
/// 77 000.
pub const STEADY_WORK: f64 = 2.5e5;

/// What real time is tuned with. Work is in units of a residual with its correction.
pub struct RealTimeTuning {
    /// Work of a millisecond for each `solver.effort`, units: as much as a Jacobian and eight
    /// residuals took in earlier versions. Half: -38, -24 and fifty times as long behind the clock;
    /// twice: +5, +6 and never behind.
    pub effort: f64,
    /// Work that is left over from a millisecond and that the next one may use, units, so that the
    /// mean is nearer to the bound; and what an iteration that has begun may take beyond the bound:
    /// the next millisecond has less. Half: +2, 0; twice: +2, 0.
    pub spare: f64,
    /// Work of a Jacobian with its factors, units: with reused geometry (measured 5.3 to 5.7), and
    /// what all geometry takes beside (11 with `ALE`, 17 with `ALE0`). The latter is also that of a
    /// Jacobian under rough loads in the mean, 12 to 17.
    pub jacobian: [f64; 2],
    /// Length of steps, s. Longer ones take more Jacobians under flips and hunting; with 0.125 ms
    /// smooth loads take half as much work again. Half: -13, +38; twice: +5, -21.
    pub step: f64,
    /// Share of that length of the shortest steps. Each one that has no solution halves the length,
    /// each solved one doubles it. Random jumps need it.
    pub shortest: f64,
    /// Newton's tolerance, in units of the Newton scale, in smooth motion: with 40 the ratio drifts
    /// under ripple. And how many times wider it is while the run is behind the clock, which saves
    /// a tenth of the work. Half: +7, +5 and -1, +1; twice: -4, -4 and +2, -1.
    pub tolerance: f64,
    pub widening: f64,
    /// Longest time behind the clock, s. What is beyond it is left out: a controller can't use
    /// older outputs.
    pub behind: f64,
}

pub const REAL_TIME: RealTimeTuning = RealTimeTuning {
    effort: 15.5,
    spare: 12.0,
    jacobian: [6.0, 14.0],
    step: 0.2e-3,
    shortest: 1.0 / 32.0,
    tolerance: 10.0,
    widening: 8.0,
    behind: 0.02,
};

/// Start without load: friction velocity that it begins with, m/s, unless its own is larger; time
/// over which that falls to its own, s, held over each of so many parts. Over 24 starts without
/// load or at a standstill, with 0.15 s after each, half: -4, -1; -22, -17 (`ALE0` alone -6, +2);
/// -2, -2. Twice: +4, +1; +3, +2 (`ALE0` +28, +17); -3, +1.
pub const RAMP_VELOCITY: f64 = 0.02;
pub const RAMP: f64 = 1.0e-2;
pub const RAMP_PARTS: f64 = 32.0;

/// Speed of a pulley below which it stands still, rad/s.
pub const STANDSTILL: f64 = 1.0e-3;

/// Speed of the primary pulley, rad/s, and friction velocity, m/s, of the belt that creeps into a
/// standstill. The axial force is within 2 % of that at half and at double the speed: sliding
/// speeds are far above the friction velocity, a centrifugal tension of some 2 N is far below the
/// ring's, and oil bears as much as between the elements of a belt that slows down. Half: +3, +4
/// and +2, +3; twice: -3, -3 and -4, -2.
pub const CREEP_SPEED: f64 = 20.0;
pub const CREEP_VELOCITY: f64 = 5.0e-5;

/// Time in which a belt that is clamped at a standstill settles, s, and the tolerance of the steps,
/// of which only the end counts. Half: -2, -4; +8, +5. Twice: +1, +6; +2, +2.
pub const SETTLING: f64 = 0.2;
pub const SETTLING_TOLERANCE: f64 = 1.0e-2;

/// Factor to which the largest fraction of the torques is found that is carried, and factor from
/// one fraction to the next while there is none. Half (1.02, 0.5): +15, +12; +1, +1. Twice (1.1,
/// 0.85): -10, -8; +11, +11.
pub const CLOSE_FRACTION: f64 = 1.05;
pub const NEXT_FRACTION: f64 = 0.7;
/// Slip of a pushbelt at capacity, as a first guess: measured variators begin to slip through
/// between 1 and 3 %. Half and twice: 0, 0; without: +2, +4.
pub const SLIP_AT_CAPACITY: f64 = 0.015;

/// Simulated time over which the work of a run is judged, s, and the time for a residual and the
/// correction from it, for each unknown, s: with ten loads on three meshes of two rings it was 33
/// to 38 ns on one core of an AMD EPYC with AVX2.
pub const JUDGED: f64 = 1.0;
pub const RESIDUAL: f64 = 36.0e-9;
/// What comes and goes within this time, s, is logged once: net compression of a strand, slip. A
/// load must seem to be in another unit for as long before that is said: a force that comes in
/// passes small values.
pub const BRIEF: f64 = 0.1;
/// Belt speed above which no belt of a car runs, m/s: they run at up to about 50 m/s.
pub const FASTEST: f64 = 60.0;
/// Deviation from balance up to which one torque seems to have the wrong sign, as a share.
pub const BALANCED: f64 = 0.25;
