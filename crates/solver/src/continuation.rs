//! Steady states by pseudo-transient continuation: implicit Euler whose step grows without bound.

use super::newton::{Newton, Stage, Unsolved};
use super::sdirk::MIN_STEP;
use super::{State, System, View};

// "Half, twice": change of the work, residuals and 12 for each Jacobian, of the nine load cases
// with ALE and ALE0, with half and twice the constant.

/// Newton tolerance of earlier steps over that of the last, whose state is the result.
/// Half, twice: +2, −3 %; 1: +5 %.
const COARSE: f64 = 100.0;
/// Factor of a step whose stage was not solved, or that `control` refused: none in these cases.
/// Half, twice: −2, +2 %.
const SHORTER: f64 = 0.3;

/// Growth of a step after a stage with this number of Jacobians. Kelley and Keyes (1998) let the
/// step grow as the residual falls. Here the residual jumps where the system is controlled, so the
/// work of Newton's method replaces it. Half and twice the powers of growth: −3, +24 %.
fn growth(jacobians: u64) -> f64 {
    match jacobians {
        0..=3 => 4.0,
        4 | 5 => 2.5,
        6 | 7 => 1.7,
        _ => 1.2,
    }
}

/// Settings of [`continue_to_steady`].
#[derive(Clone, Copy, Debug)]
pub struct ContinuationSettings {
    /// Time at which the system is evaluated throughout, s.
    pub time: f64,
    /// First pseudo-time step, s.
    pub first_step: f64,
    /// Step at which the state counts as steady, s: far above every time constant.
    pub last_step: f64,
    /// Most Newton solves.
    pub max_solves: usize,
}

/// No steady state was found: the step stalled, or solves or work ([`Newton::bound`]) were used up.
#[derive(Clone, Copy, Debug, Default, PartialEq, thiserror::Error)]
#[error("no steady state was found (pseudo-time step {step:.1e} s after {solves} solves)")]
pub struct NotSteady {
    /// Newton solves.
    pub solves: usize,
    /// Last pseudo-time step, s.
    pub step: f64,
}

/// A trial state of [`continue_to_steady`]: before and after a pseudo-time step.
#[derive(Debug)]
pub struct Trial<'a> {
    /// State before.
    pub before: View<'a>,
    /// State after.
    pub after: View<'a>,
    /// Pseudo-time step, s.
    pub step: f64,
}

impl<'a> Trial<'a> {
    fn new(before: &'a State, stage: &'a Stage, step: f64) -> Self {
        Self {
            before: before.view(),
            after: stage.state.view(),
            step,
        }
    }
}

impl Stage {
    /// A step of implicit Euler from a state, s, with it as the predictor.
    fn begin(&mut self, from: &State, step: f64) {
        self.alpha = 1.0 / step;
        self.base.copy_from_slice(&from.y);
        self.position.copy_from_slice(&from.q);
        self.state.copy_from(from);
    }
}

/// Moves a state to the steady one. `control` is called after each solved step. It may correct the
/// system, and returns the longest next step, or none to refuse the step as too large. Another step
/// after the last solves the last correction of `control`.
///
/// # Errors
/// [`NotSteady`]; the state is then the last one solved.
pub fn continue_to_steady<S: System>(
    system: &mut S,
    newton: &mut Newton,
    state: &mut State,
    settings: &ContinuationSettings,
    mut control: impl FnMut(&mut S, &Trial<'_>) -> Option<f64>,
) -> Result<(), NotSteady> {
    let mut stage = Stage::new(state.y.len());
    stage.time = settings.time;
    let mut report = NotSteady {
        step: settings.first_step,
        ..NotSteady::default()
    };
    let mut settled = false;
    while report.solves < settings.max_solves && report.step >= MIN_STEP {
        report.solves += 1;
        let last = report.step >= settings.last_step;
        stage.begin(state, report.step);
        stage.tolerance = if last { 1.0 } else { COARSE };
        let longest = match newton.solve(system, &mut stage, false) {
            Ok(()) => control(system, &Trial::new(state, &stage, report.step)),
            Err(Unsolved::OutOfWork) => break,
            Err(Unsolved::NoSolution) => None,
        };
        let Some(longest) = longest else {
            report.step *= SHORTER;
            continue;
        };
        state.copy_from(&stage.state);
        if settled && last {
            return Ok(());
        }
        settled = last;
        report.step *= growth(newton.jacobians);
        report.step = report.step.min(longest).min(settings.last_step);
    }
    newton.abandon();
    Err(report)
}

/// Moves a state to a steady one near by: at most `solves` steps of length `step`, s, with the same
/// factors. `control` is called after each. It may correct the system, and returns whether the
/// correction is negligible, or none to refuse the state.
///
/// # Errors
/// [`NotSteady`]: the state is not near enough. It is then meaningless.
pub fn settle<S: System>(
    system: &mut S,
    newton: &mut Newton,
    state: &mut State,
    step: f64,
    solves: usize,
    mut control: impl FnMut(&mut S, &Trial<'_>) -> Option<bool>,
) -> Result<(), NotSteady> {
    let mut stage = Stage::new(state.y.len());
    // Otherwise corrections by the size of Newton's error would not end.
    stage.tolerance = 1.0 / COARSE;
    for solves in 1..=solves {
        stage.begin(state, step);
        let solved = newton.solve(system, &mut stage, true);
        let settled = solved
            .ok()
            .and_then(|()| control(system, &Trial::new(state, &stage, step)));
        let Some(settled) = settled else {
            newton.abandon();
            return Err(NotSteady { solves, step });
        };
        state.copy_from(&stage.state);
        if settled {
            return Ok(());
        }
    }
    Err(NotSteady { solves, step })
}
