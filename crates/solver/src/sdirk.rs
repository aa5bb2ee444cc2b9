//! Time integration: SDIRK of two stages and order two, L-stable and stiffly accurate (Alexander
//! 1977, γ = 1 − 1/√2).
//!
//! It has no explicit stage, so a jump of the inputs needs no restart and a snapshot is y, ẏ, q and
//! the step size. The error is measured against a formula with weights on c = 0, γ, 1, where the
//! slope at c = 0 is the last one of the step before. It is of third order where the state doesn't
//! act on its slope; for ẏ = −y the estimate is a seventh of the error.

use super::newton::{Newton, Stage, Unsolved, move_by};
use super::{State, System, View};
use pushbelt_archive::Archive;

/// γ = 1 − 1/√2.
pub const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Weights of third order for quadrature (Σ b̂ = 1, Σ b̂c = 1/2, Σ b̂c² = 1/3) less those of the
/// method, on the slopes at c = 0, γ, 1.
fn error_weights() -> [f64; 3] {
    let b1 = 1.0 / (6.0 * GAMMA * (1.0 - GAMMA));
    let b2 = 0.5 - GAMMA * b1;
    [1.0 - b1 - b2, b1 - (1.0 - GAMMA), b2 - GAMMA]
}

/// What time integration needs of a system, beside [`System`].
pub trait Evolution: System {
    /// Error of a step relative to what is tolerated: accepted up to 1.
    fn error_norm(&self, view: View<'_>, y_error: &[f64], q_error: &[f64]) -> f64;

    /// Longest step that the system takes from here, s.
    fn longest_step(&self, _view: View<'_>) -> f64 {
        f64::INFINITY
    }

    /// Integrates what is not part of the state over an accepted step of `length`, s, that ends at
    /// the time `end`, s.
    fn accumulate(&mut self, before: View<'_>, after: View<'_>, end: f64, length: f64);
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
    /// Its relative growth where steps err as much as is tolerated: sharper solutions don't make
    /// them better.
    pub newton_widening: f64,
    /// Size of the step of the stages, s; none after an attempt that failed.
    last_step: Option<f64>,
    /// Squared error of the last step, of 1 at most: small as long as motions are smooth.
    error: f64,
    /// Number of the unsolved stage, from 1 on; 0 if no step is open.
    open: usize,
    stages: [Stage; 2],
    /// ẏ at the end of the last step, before loads jumped, for the predictor of the first stage: an
    /// unknown may follow its load in less than a step, so the slope after a jump would lead far
    /// off.
    slope: Vec<f64>,
    /// Estimated errors of y and of q.
    y_error: Vec<f64>,
    q_error: Vec<f64>,
}

/// Smallest step, s, also of a search for a steady state; a shorter rest joins the step before it.
pub(crate) const MIN_STEP: f64 = 1.0e-10;
/// Step as a fraction of the longest one within the tolerance by the estimated error: as Hairer,
/// Nørsett and Wanner, Solving Ordinary Differential Equations I, II.4. Half, and 0.9: +11,
/// 0 % of the work of the manoeuvre with ALE; −11, +4 % of torque flips.
const SAFETY: f64 = 0.8;

/// Change of the step size after this error: SAFETY · error^(−1/3) for an estimate of third order,
/// within the smooth limits of Söderlind and Wang, Adaptive time-stepping and computational
/// stability (2006): 0.21 where the error is infinite or not a number, 2.57 where there is none.
fn step_factor(error: f64) -> f64 {
    1.0 + (SAFETY / error.cbrt() - 1.0).max(-1.0).atan()
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
            newton_widening: 0.0,
            last_step: None,
            error: 0.0,
            open: 0,
            stages: [Stage::new(n), Stage::new(n)],
            slope: vec![0.0; n],
            y_error: vec![0.0; n],
            q_error: vec![0.0; n],
        }
    }

    /// ÿ of an unknown at the end of the last step, of first order: from the slopes of its two
    /// stages. 0 if there is no last step.
    #[must_use]
    pub fn slope_rate(&self, unknown: usize) -> f64 {
        let [first, second] = self.stages.each_ref().map(|stage| stage.state.y_dot[unknown]);
        self.last_step.map_or(0.0, |h| (second - first) / ((1.0 - GAMMA) * h))
    }

    /// Writes to an archive, or reads from it, what later steps depend on without [the factored
    /// Jacobian](Newton::serialize_factors).
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.newton.serialize(archive);
        archive.bounded_real(&mut self.step, 0.0, f64::MAX);
        archive.option(&mut self.last_step);
        archive.bounded_real(&mut self.error, 0.0, 1.0);
        archive.reals(&mut self.slope);
        if self.last_step.is_some() {
            for stage in &mut self.stages {
                archive.reals(&mut stage.state.y_dot);
            }
        }
        archive.indices(std::slice::from_mut(&mut self.open), 3);
        if self.open > 0 {
            let Stage {
                base, position, state, ..
            } = &mut self.stages[self.open - 1];
            state.serialize(archive);
            archive.reals(base);
            archive.reals(position);
        }
    }

    /// Solves both stages of a step of size `h` from (y, ẏ, q) at `time`, or continues where the
    /// work was used up. The result is in the second.
    fn solve(&mut self, system: &mut impl System, view: View<'_>, time: f64, h: f64) -> Result<(), Unsolved> {
        self.last_step = None;
        for number in self.open.max(1)..=2 {
            if self.open != number {
                self.predict(number, view, h);
                self.open = number;
            }
            let stage = &mut self.stages[number - 1];
            stage.time = time + if number == 1 { GAMMA } else { 1.0 } * h;
            stage.alpha = 1.0 / (h * GAMMA);
            stage.tolerance = self.newton_tolerance * (1.0 + self.newton_widening * self.error);
            self.newton.solve(system, stage, true)?;
        }
        self.open = 0;
        Ok(())
    }

    /// Sets base, position and predictor of a stage.
    fn predict(&mut self, number: usize, view: View<'_>, h: f64) {
        let [first, second] = &mut self.stages;
        if number == 1 {
            first.base.copy_from_slice(view.y);
            first.position.copy_from_slice(view.q);
            move_by(GAMMA * h, &mut first.state.y, view.y, &self.slope);
            first.state.q.copy_from_slice(view.q);
        } else {
            let State { y, y_dot, .. } = &first.state;
            move_by(h * (1.0 - GAMMA), &mut second.base, view.y, y_dot);
            move_by(h * (1.0 - GAMMA), &mut second.position, view.q, y);
            move_by(h * GAMMA, &mut second.state.y, &second.base, y_dot);
            second.state.q.copy_from_slice(view.q);
        }
    }

    /// Abandons an unsolved step.
    pub fn abandon(&mut self) {
        self.open = 0;
        self.newton.abandon();
    }

    /// Takes one step of size `h` at `time` without error control, or continues it, within the work
    /// of [`Newton::bound`].
    ///
    /// # Errors
    /// A stage is not solved; the state stays at the start of the step. After
    /// [`Unsolved::OutOfWork`] call it again with the same arguments, or [`Sdirk::abandon`] the
    /// step; after [`Unsolved::NoSolution`] it is abandoned.
    pub fn fixed_step<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        time: f64,
        h: f64,
    ) -> Result<(), Unsolved> {
        let solved = self.solve(system, state.view(), time, h);
        match solved {
            Ok(()) => self.accept(system, state, time + h, h),
            Err(Unsolved::NoSolution) => self.abandon(),
            Err(Unsolved::OutOfWork) => {}
        }
        solved
    }

    /// Estimates the errors of y and q from the slopes at c = 0, γ, 1; returns their norm.
    fn error(&mut self, system: &impl Evolution, before: View<'_>, h: f64) -> f64 {
        let [w0, w1, w2] = error_weights().map(|w| h * w);
        let [first, second] = self.stages.each_ref().map(|stage| stage.state.view());
        let weigh = |out: &mut [f64], slopes: [&[f64]; 3]| {
            for (((out, a), b), c) in out.iter_mut().zip(slopes[0]).zip(slopes[1]).zip(slopes[2]) {
                *out = w0 * a + w1 * b + w2 * c;
            }
        };
        weigh(&mut self.y_error, [before.y_dot, first.y_dot, second.y_dot]);
        weigh(&mut self.q_error, [before.y, first.y, second.y]);
        let error = system.error_norm(second, &self.y_error, &self.q_error);
        self.error = error.min(1.0).powi(2);
        error
    }

    /// Takes one step from `time`, which is before `to`, s, to at most that; afterwards `time` is
    /// where it ends.
    ///
    /// # Errors
    /// The step size fell below 0.1 ns, or a time is not a number; the state is that of the last
    /// accepted step, at `time`.
    pub fn step<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        time: &mut f64,
        to: f64,
    ) -> Result<(), Stalled> {
        let rest = to - *time;
        let mut repeats = false;
        loop {
            let longest = self.max_step.min(system.longest_step(state.view()));
            // Equal steps to the end leave no short rest.
            let h = rest / ((rest - MIN_STEP) / self.step.min(longest)).ceil().max(1.0);
            let outcome = self.solve(system, state.view(), *time, h);
            let error = outcome.map_or(f64::INFINITY, |()| self.error(system, state.view(), h));
            let factor = step_factor(error);
            if error <= 1.0 {
                *time = if h >= rest { to } else { *time + h };
                self.accept(system, state, *time, h);
                // An accepted step is not shortened, as in CVODE: a communication step split in two
                // takes new factors. Nor does the step grow right after a failure (Hairer, Nørsett
                // and Wanner, II.4).
                self.step = if repeats {
                    self.step.min(h)
                } else if factor < 1.0 {
                    h
                } else {
                    // A step that was shortened to meet the end does not shorten the next ones.
                    self.step.max(h * factor)
                }
                .min(longest);
                return Ok(());
            }
            repeats = true;
            self.abandon();
            self.step = h * factor;
            let newton = outcome.is_err();
            let counts = &mut self.newton.counts;
            *if newton {
                &mut counts.failed
            } else {
                &mut counts.rejected
            } += 1;
            if self.step.is_nan() || self.step < MIN_STEP {
                let (time, step) = (*time, self.step);
                return Err(Stalled { time, step, newton });
            }
        }
    }

    fn accept(&mut self, system: &mut impl Evolution, state: &mut State, end: f64, length: f64) {
        let solved = &self.stages[1].state;
        system.accumulate(state.view(), solved.view(), end, length);
        state.copy_from(solved);
        self.slope.copy_from_slice(&solved.y_dot);
        self.newton.counts.steps += 1;
        // Slopes over less than this differ by rounding only.
        self.last_step = (length >= MIN_STEP).then_some(length);
    }
}
