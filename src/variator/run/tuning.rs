//! Tuning numbers of runs and their starts. "Half" and "twice": changes of Jacobians and residuals,
//! %, with half and twice the number and `ALE0`: of runs over 0.15 s of each of the ten rough
//! loads, accurate or in real time; of eight starts at a standstill, or of forty steady ones at
//! random. Up to 2 % is noise. Other numbers change no counts.

/// First step of a run, s, from a steady state and from another one. Half: +1, 0 and 0, 0; twice:
/// -1, -1 and 0, 0. With one step between them, short runs take more Jacobians, and a chain that
/// sticks three times as many in its first milliseconds.
pub const FIRST_STEP: f64 = 1.0e-4;
pub const COLD_STEP: f64 = 1.0e-6;
/// Half the distance in time over which outputs are differentiated, s: the loads of the flanks are
/// linear over it, and it leaves nine digits of a difference.
pub const MOMENT: f64 = 1.0e-6;

/// Newton's tolerance at the default solver tolerance, in units of the Newton scale: tenfold
/// changes no output of the manoeuvre in the fourth digit. Half: 0, +5; twice: -2, -7.
pub const NEWTON_TOLERANCE: f64 = 20.0;
/// Its relative growth where steps err as much as is tolerated: an iteration then leaves a tenth of
/// such an error, as in CVODE (Hindmarsh et al. 2005). It is less at tighter tolerances, which
/// serve to compare small differences. Half: +2, +3; twice: +2, -3.
pub const NEWTON_WIDENING: f64 = 60.0;
/// Limits of Newton's tolerance at other solver tolerances.
pub const NEWTON_LIMITS: [f64; 2] = [0.05, 100.0];

/// Most residuals of an accurate communication step or of a belt that settles before a start, and
/// more for each second of it: twenty times those under loads that jump.
pub const STEP_RESIDUALS: f64 = 1.0e4;
pub const STEP_RESIDUALS_PER_SECOND: f64 = 5.0e5;
/// Most work of the search for a steady state, in residuals. Of some 220 starts, two thirds of them
/// at random with both rings and chains, a steady state took at most 49 000, one at reduced torque
/// 77 000.
pub const STEADY_WORK: f64 = 2.5e5;

/// Tuning of real time. Work is in units of a residual with its correction.
pub struct RealTimeTuning {
    /// Work of a millisecond for each `solver.effort`, units. Half: -38, -24 and fifty times as
    /// long behind the clock; twice: +5, +6 and never behind.
    pub effort: f64,
    /// Most unused work of a millisecond that the next one may use, units, so that the mean is
    /// nearer to the bound; and work that an iteration that has begun may take beyond the bound:
    /// the next millisecond has less. Half of both: +2, 0; twice: +2, 0.
    pub spare: f64,
    pub overdraft: f64,
    /// Work of a Jacobian with its factors and reused geometry, units (measured 5.3 to 5.7); and
    /// further work for all geometry (11 with `ALE`, 17 with `ALE0`).
    pub jacobian: f64,
    pub geometry: f64,
    /// Length of steps, s. Longer ones take more Jacobians under flips and hunting; with 0.125 ms
    /// smooth loads take half as much work again. Half: -13, +38; twice: +5, -21.
    pub step: f64,
    /// Shortest steps as a fraction of that length: a step without a solution halves the length, a
    /// solved one doubles it. Random jumps need it.
    pub shortest: f64,
    /// Newton's tolerance, in units of the Newton scale: with 40 the ratio drifts under ripple. And
    /// its factor while the run is behind the clock, which saves a tenth of the work. Half: +7, +5
    /// and -1, +1; twice: -4, -4 and +2, -1.
    pub tolerance: f64,
    pub widening: f64,
    /// Longest time behind the clock, s. Time beyond it is left out: a controller can't use older
    /// outputs.
    pub behind: f64,
}

pub const REAL_TIME: RealTimeTuning = RealTimeTuning {
    effort: 15.5,
    spare: 12.0,
    overdraft: 12.0,
    jacobian: 6.0,
    geometry: 14.0,
    step: 0.2e-3,
    shortest: 1.0 / 32.0,
    tolerance: 10.0,
    widening: 8.0,
    behind: 0.02,
};

/// A start without load. Over 24 starts without load or at a standstill, with 0.15 s after each,
/// half: -4, -1; -22, -17 (`ALE0` alone -6, +2); -2, -2. Twice: +4, +1; +3, +2 (`ALE0` +28, +17);
/// -3, +1.
pub struct SoftStart {
    /// Friction velocity at first, m/s, unless that of the parameters is larger.
    pub velocity: f64,
    /// Time in which it falls to that of the parameters, s; and number of its parts, in each of
    /// which the velocity is constant.
    pub duration: f64,
    pub parts: f64,
}

pub const SOFT_START: SoftStart = SoftStart {
    velocity: 0.02,
    duration: 1.0e-2,
    parts: 32.0,
};

/// Speed of a pulley at standstill, at most, rad/s.
pub const STANDSTILL: f64 = 1.0e-3;

/// Speed of the primary pulley, rad/s, and friction velocity, m/s, of the belt that creeps into a
/// standstill. The axial force is within 2 % of that at half and at double the speed. Half: +3, +4
/// and +2, +3; twice: -3, -3 and -4, -2.
pub const CREEP_SPEED: f64 = 20.0;
pub const CREEP_VELOCITY: f64 = 5.0e-5;

/// Time in which a belt that is clamped at a standstill settles, s, and tolerance of its steps, of
/// which only the end counts. Half: -2, -4; +8, +5. Twice: +1, +6; +2, +2.
pub const SETTLING: f64 = 0.2;
pub const SETTLING_TOLERANCE: f64 = 1.0e-2;

/// The largest fraction of the torques that has a steady state is found to within the first factor;
/// while there is none, the second factor leads to the next fraction. Half (1.02, 0.5): +15, +12;
/// +1, +1. Twice (1.1, 0.85): -10, -8; +11, +11.
pub const CLOSE_FRACTION: f64 = 1.05;
pub const NEXT_FRACTION: f64 = 0.7;
/// Fraction of the torques below which no smaller one is tried.
pub const LEAST_FRACTION: f64 = 0.05;
/// First guess of the slip at capacity: measured pushbelts begin to slip through between 1 and 3 %.
/// Half and twice: 0, 0; without: +2, +4.
pub const SLIP_AT_CAPACITY: f64 = 0.015;

/// Judgement of the work of a run.
pub struct Judgement {
    /// Simulated time over which the work is added up, s.
    pub time: f64,
    /// Time for a residual and the correction from it, for each unknown, s: with ten loads on three
    /// meshes of two rings it was 33 to 38 ns on one core of an AMD EPYC with AVX2.
    pub residual: f64,
    /// Work of a Jacobian with its factors, in residuals: under rough loads 12 to 17 in the mean.
    pub jacobian: f64,
}

pub const JUDGEMENT: Judgement = Judgement {
    time: 1.0,
    residual: 36.0e-9,
    jacobian: 14.0,
};
/// Time after which slip or net compression of a strand is logged again, s, and for which a load
/// must seem to be in another unit before a warning: forces start small.
pub const MESSAGE_TIME: f64 = 0.1;
/// Speed above that of belts of cars, up to about 50 m/s.
pub const FASTEST: f64 = 60.0;
/// Relative deviation from balance up to which one torque seems to have the wrong sign.
pub const BALANCED: f64 = 0.25;
