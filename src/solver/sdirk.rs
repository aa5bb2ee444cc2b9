//! Time integration: SDIRK of two stages and order two, L-stable and stiffly accurate (Alexander 1977, γ = 1 − 1/√2).
//!
//! One-step and without an explicit stage, so a jump of the inputs needs no restart and a snapshot is y, ẏ, q and the
//! step size. The error is measured against a third-order formula with weights on c = 0, γ, 1, where the slope at
//! c = 0 is the last one of the step before.

use super::newton::{Newton, Stage};
use super::{State, System, View};
use crate::tape::Tape;

/// γ = 1 − 1/√2.
pub const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Third-order weights less those of the method, on the slopes at c = 0, γ, 1.
fn error_weights() -> [f64; 3] {
    let b1 = 1.0 / (6.0 * GAMMA * (1.0 - GAMMA));
    let b2 = 0.5 - GAMMA * b1;
    [1.0 - b1 - b2, b1 - (1.0 - GAMMA), b2 - GAMMA]
}

/// What a system adds for time integration.
pub trait Evolution: System {
    /// Error of a step relative to what is tolerated: accepted up to 1.
    fn error_norm(&self, view: View<'_>, y_error: &[f64], q_error: &[f64]) -> f64;

    /// Longest step that the system takes from here, s.
    fn longest_step(&self, _view: View<'_>) -> f64 {
        f64::INFINITY
    }

    /// Called for each accepted step: to integrate what is not part of the state.
    fn accumulate(&mut self, before: View<'_>, after: View<'_>, interval: Interval);
}

/// The time that an accepted step took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Time at the end, s.
    pub end: f64,
    /// Size of the step, s.
    pub length: f64,
}

/// The step size fell below the smallest.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{} at a step of {step:.1e} s, {time} s", if *newton { "Newton's method found no solution" } else { "the error stayed too large" })]
pub struct Stalled {
    /// Time reached, s.
    pub time: f64,
    /// Step size at which it gave up, s.
    pub step: f64,
    /// Whether Newton's method failed (else the error control).
    pub newton: bool,
}

/// Integrator with its history.
#[derive(Clone, Debug)]
pub struct Sdirk {
    /// Newton iteration, with work counts.
    pub newton: Newton,
    /// Preferred next step, s.
    pub step: f64,
    /// Longest step, s.
    pub max_step: f64,
    /// Newton tolerance as a fraction of the system's Newton scale.
    pub newton_tolerance: f64,
    /// Size of the step whose stages are kept; none after an attempt that failed, s.
    kept: Option<f64>,
    stages: [State; 2],
    /// ẏ at the end of the last step, before loads jumped: what the first stage is guessed with. A sheave follows its
    /// force in less than a step, so its jump would lead far off.
    slope: Vec<f64>,
    base: Vec<f64>,
    position: Vec<f64>,
    y_error: Vec<f64>,
    q_error: Vec<f64>,
}

/// Smallest step, s.
const MIN_STEP: f64 = 1.0e-10;

/// `out` = `from` + `time`·`rate`.
fn move_by(time: f64, out: &mut [f64], from: &[f64], rate: &[f64]) {
    for ((out, from), rate) in out.iter_mut().zip(from).zip(rate) {
        *out = from + time * rate;
    }
}

impl Sdirk {
    /// Integrator for `system`.
    #[must_use]
    pub fn new(system: &impl System, first_step: f64, max_step: f64) -> Self {
        let n = system.shape().len();
        Self {
            newton: Newton::new(system),
            step: first_step,
            max_step,
            newton_tolerance: 1.0,
            kept: None,
            stages: [State::zero(n), State::zero(n)],
            slope: vec![0.0; n],
            base: vec![0.0; n],
            position: vec![0.0; n],
            y_error: vec![0.0; n],
            q_error: vec![0.0; n],
        }
    }

    /// ÿ of an unknown at the end of the last step, of first order: from the slopes of its two stages. 0 if there is no
    /// last step.
    #[must_use]
    pub fn slope_rate(&self, unknown: usize) -> f64 {
        let [first, second] = &self.stages;
        self.kept.map_or(0.0, |h| {
            (second.y_dot[unknown] - first.y_dot[unknown]) / ((1.0 - GAMMA) * h)
        })
    }

    /// Passes by a tape all that later steps depend on.
    pub fn pass(&mut self, tape: &mut Tape<'_>) {
        self.newton.pass(tape);
        tape.real(&mut self.step);
        tape.option(&mut self.kept);
        tape.reals(&mut self.slope);
        for stage in &mut self.stages {
            tape.reals(&mut stage.y_dot);
        }
    }

    /// Tries one step of size `h` from (y, ẏ, q) at `time`; the result stands in the second stage.
    fn attempt<S: Evolution>(&mut self, system: &mut S, view: View<'_>, time: f64, h: f64) -> Option<f64> {
        let View { y, y_dot, q } = view;
        self.kept = None;
        let alpha = 1.0 / (h * GAMMA);
        self.newton.weigh(system, alpha);
        let [first, second] = &mut self.stages;
        move_by(GAMMA * h, &mut first.y, y, &self.slope);
        first.q.copy_from_slice(q);
        let mut stage = Stage {
            time: time + GAMMA * h,
            alpha,
            base: y,
            position: q,
            y: &mut first.y,
            y_dot: &mut first.y_dot,
            q: &mut first.q,
        };
        self.newton
            .solve(system, &mut stage, self.newton_tolerance, true)
            .ok()?;
        move_by(h * (1.0 - GAMMA), &mut self.base, y, &first.y_dot);
        move_by(h * (1.0 - GAMMA), &mut self.position, q, &first.y);
        move_by(h * GAMMA, &mut second.y, &self.base, &first.y_dot);
        second.q.copy_from_slice(q);
        let mut stage = Stage {
            time: time + h,
            alpha,
            base: &self.base,
            position: &self.position,
            y: &mut second.y,
            y_dot: &mut second.y_dot,
            q: &mut second.q,
        };
        self.newton
            .solve(system, &mut stage, self.newton_tolerance, true)
            .ok()?;
        let [w0, w1, w2] = error_weights().map(|w| h * w);
        let weigh = |out: &mut [f64], slopes: [&[f64]; 3]| {
            for (((out, a), b), c) in out.iter_mut().zip(slopes[0]).zip(slopes[1]).zip(slopes[2]) {
                *out = w0 * a + w1 * b + w2 * c;
            }
        };
        weigh(&mut self.y_error, [y_dot, &first.y_dot, &second.y_dot]);
        weigh(&mut self.q_error, [y, &first.y, &second.y]);
        Some(system.error_norm(second.view(), &self.y_error, &self.q_error))
    }

    /// Advances a state from `time` to exactly `to`.
    ///
    /// # Errors
    /// The step size fell below 0.1 ns; the state is that of the last accepted step, whose time the error tells.
    pub fn advance<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        time: f64,
        to: f64,
    ) -> Result<(), Stalled> {
        let span = to - time;
        let mut done = 0.0;
        while done < span {
            let rest = span - done;
            let longest = self.max_step.min(system.longest_step(state.view()));
            let preferred = self.step.min(longest);
            // Whole steps to the end: never a sliver.
            let h = rest / (rest / preferred * (1.0 - 1e-9)).ceil().max(1.0);
            let last = h >= rest;
            let outcome = self.attempt(system, state.view(), time + done, h);
            match outcome {
                Some(error) if error <= 1.0 => {
                    let end = &self.stages[1];
                    let interval = Interval {
                        end: time + done + h,
                        length: h,
                    };
                    system.accumulate(state.view(), end.view(), interval);
                    state.copy_from(end);
                    self.slope.copy_from_slice(&end.y_dot);
                    self.newton.counts.steps += 1;
                    // Slopes over less than this differ by rounding only.
                    self.kept = (h >= MIN_STEP).then_some(h);
                    done = if last { span } else { done + h };
                    let factor = (0.85 * error.max(1e-9).powf(-1.0 / 3.0)).clamp(0.3, 3.0);
                    // A step shortened to meet `to` says nothing against the longer one.
                    let next = h * factor;
                    if next > self.step || h >= 0.99 * preferred || factor < 1.0 {
                        self.step = next.min(longest);
                    }
                }
                other => {
                    let factor = if let Some(error) = other {
                        self.newton.counts.rejected += 1;
                        (0.8 * error.powf(-1.0 / 3.0)).clamp(0.1, 0.7)
                    } else {
                        self.newton.counts.failed += 1;
                        0.25
                    };
                    let factor = if factor.is_finite() { factor } else { 0.1 };
                    self.step = h * factor;
                    if self.step < MIN_STEP {
                        return Err(Stalled {
                            time: time + done,
                            step: self.step,
                            newton: other.is_none(),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}
