//! Steady states by pseudo-transient continuation: implicit Euler whose step grows without bound.

use super::newton::{Newton, Stage};
use super::{State, System, View};

/// Settings of [`settle`].
#[derive(Clone, Copy, Debug)]
pub struct Settling {
    /// Time at which the system is evaluated throughout, s.
    pub time: f64,
    /// First pseudo-time step, s.
    pub first_step: f64,
    /// Step at which the state counts as steady, s: far above every time constant.
    pub last_step: f64,
    /// Most Newton solves.
    pub max_solves: usize,
}

/// How it went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settled {
    /// Newton solves.
    pub solves: usize,
    /// Last pseudo-time step, s.
    pub step: f64,
}

/// A trial state of [`settle`]: before and after a pseudo-time step.
#[derive(Debug)]
pub struct Trial<'a> {
    /// State before.
    pub before: View<'a>,
    /// State after.
    pub after: View<'a>,
    /// Pseudo-time step, s.
    pub step: f64,
}

/// Drives a state to the steady one. `judge` sees each solved step, may correct the system (a control of the steady
/// state), and answers with the longest step to try next, or with none to refuse the step as too large. After the last
/// step comes another, which answers what `judge` corrected last.
///
/// # Errors
/// [`Settled`] so far, if the step stalled or the solves ran out. The state is then the last one solved.
pub fn settle<S: System>(
    system: &mut S,
    newton: &mut Newton,
    state: &mut State,
    settings: &Settling,
    mut judge: impl FnMut(&mut S, &Trial<'_>) -> Option<f64>,
) -> Result<Settled, Settled> {
    let mut trial = state.clone();
    let mut report = Settled {
        step: settings.first_step,
        ..Settled::default()
    };
    let mut settled = false;
    loop {
        if report.solves >= settings.max_solves || report.step < 1e-12 {
            return Err(report);
        }
        report.solves += 1;
        let last = report.step >= settings.last_step;
        trial.copy_from(state);
        let mut stage = Stage {
            time: settings.time,
            alpha: 1.0 / report.step,
            base: &state.y,
            position: &state.q,
            y: &mut trial.y,
            y_dot: &mut trial.y_dot,
            q: &mut trial.q,
        };
        let tolerance = if last { 1.0 } else { 100.0 };
        newton.weigh(system, stage.alpha);
        let outcome = newton.solve(system, &mut stage, tolerance, false);
        match outcome {
            Ok(iterations) => {
                let seen = Trial {
                    before: state.view(),
                    after: trial.view(),
                    step: report.step,
                };
                let Some(longest) = judge(system, &seen) else {
                    report.step *= 0.4;
                    continue;
                };
                state.copy_from(&trial);
                if settled && last {
                    return Ok(report);
                }
                settled = last;
                report.step *= match iterations {
                    0..=3 => 4.0,
                    4 | 5 => 2.5,
                    6 | 7 => 1.7,
                    _ => 1.2,
                };
                report.step = report.step.min(longest).min(settings.last_step);
            }
            Err(_) => report.step *= 0.3,
        }
    }
}
