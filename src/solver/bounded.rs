//! Time integration in ticks of bounded work, for real time: with one Jacobian, one factorization and a fixed number of residuals
//! in each tick, whatever happens. No tick fails. There are two kinds of the same work, both one-step and L-stable:
//!
//! - A calm tick ([`Tick::Calm`]) is a step of [`Sdirk`](super::sdirk::Sdirk), of order two: two stages share the Jacobian and the
//!   residuals.
//! - A rough tick ([`Tick::Rough`]) is implicit Euler, of order one: a swing of 70 Hz lags by 0.2 rad in ticks of 1 ms. Its Jacobian is
//!   that of the secants ([`Evolution::secant_jacobian`]): where a law saturates, as friction does, its tangent underestimates the
//!   slopes ahead, and iterations jump from one sliding direction to the other. The secant from rest never does, so each
//!   iteration dissipates.
//!
//! A stage solves F(t, y, (y − y_0)/τ, q_0 + τ y) = 0 as far as its residuals get:
//!
//! - A step is accepted when the simplified correction after it is smaller, else halved: the restricted monotonicity test
//!   of Deuflhard, Newton Methods for Nonlinear Problems (2011), section 3.3. After a whole step Broyden's update goes on.
//! - The stage ends at the last point that was accepted. What the next correction would change is its defect.
//!
//! What a tick leaves unsolved acts in the next one as a force out of balance.

use super::arrow::{Arrow, ArrowLu};
use super::broyden::Broyden;
use super::newton::Counts;
use super::sdirk::{Evolution, GAMMA, Interval, Quadrature, move_by};
use super::{State, System};
use crate::tape::Tape;

/// Longest tick of a run that keeps up with the clock, s.
pub const TICK: f64 = 1.0e-3;
/// Residuals in a tick. With six, ticks in which a torque flips are left with ten times the defect.
pub const RESIDUALS: usize = 8;
/// By how much the correction after a step must be below the one before: 1 − λ/4 at damping λ.
const RESTRICTION: f64 = 0.25;
/// Change of the damping after a step that was refused; one that was accepted changes it back.
const DAMPED: f64 = 0.5;
/// Damping from which on a step may also grow the correction, and by how much: a saddle is left.
const LEAST: f64 = 0.03;
const GROWTH: f64 = 2.0;
/// Defect that stands for an evaluation that was no number.
const WORST: f64 = 1.0e9;

/// How a tick is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tick {
    /// Two stages of order two with tangents: where a few iterations find the solution.
    Calm,
    /// One stage of order one with secants: where they don't.
    Rough,
}

/// Where a stage stands: it ends at `time` and is τ = `length` long, s.
#[derive(Clone, Copy, Debug)]
struct Stage {
    time: f64,
    length: f64,
    residuals: usize,
}

/// Ticks of bounded work.
#[derive(Clone, Debug)]
pub struct Bounded {
    matrix: Arrow,
    factors: ArrowLu,
    scale: Vec<f64>,
    correction: Vec<f64>,
    /// The point that was accepted last, and the step from it, scaled.
    accepted: Vec<f64>,
    step: Vec<f64>,
    broyden: Broyden,
    /// State at the start of the tick.
    start: State,
    /// y_0 and q_0 of a stage.
    base: State,
    /// Work counts.
    pub counts: Counts,
    /// Largest defect of the ticks since it was set to zero: root mean square of the correction that is left, in units of
    /// Newton's scale.
    pub defect: f64,
}

impl Bounded {
    /// Memory for `system`.
    #[must_use]
    pub fn new(system: &impl System) -> Self {
        let shape = system.shape();
        let zeros = vec![0.0; shape.len()];
        Self {
            matrix: Arrow::new(shape),
            factors: ArrowLu::new(shape),
            scale: zeros.clone(),
            correction: zeros.clone(),
            accepted: zeros.clone(),
            step: zeros,
            broyden: Broyden::new(RESIDUALS, shape.len()),
            start: State::zero(shape.len()),
            base: State::zero(shape.len()),
            counts: Counts::default(),
            defect: 0.0,
        }
    }

    /// Passes by a tape all that later ticks depend on beside the state: nothing but the counts.
    pub fn pass(&mut self, tape: &mut Tape<'_>) {
        let Counts {
            steps,
            residuals,
            factorizations,
            ..
        } = &mut self.counts;
        for count in [steps, residuals, factorizations] {
            tape.counter(count);
        }
    }

    /// Advances a state by a tick from one time to another, s. Returns its defect.
    pub fn tick<S: Evolution>(&mut self, system: &mut S, state: &mut State, [from, to]: [f64; 2], kind: Tick) -> f64 {
        let length = to - from;
        let part = match kind {
            Tick::Calm => GAMMA * length,
            Tick::Rough => length,
        };
        self.start.copy_from(state);
        self.base.copy_from(state);
        system.newton_scale(part, &mut self.scale);
        let (first, alpha) = (from + part, 1.0 / part);
        match kind {
            Tick::Calm => system.jacobian(first, state.view(), alpha, part, &mut self.matrix),
            Tick::Rough => system.secant_jacobian(first, state.view(), alpha, part, &mut self.matrix),
        }
        self.counts.factorizations += 1;
        let regular = self.factors.factor(&self.matrix).is_ok();
        let stage = |time, residuals| Stage {
            time,
            length: part,
            residuals,
        };
        let (defect, rule) = match kind {
            Tick::Calm => {
                let of_first = self.iterate(system, state, stage(first, RESIDUALS / 2), regular);
                self.move_on(state, length - part, part);
                let of_second = self.iterate(system, state, stage(to, RESIDUALS - RESIDUALS / 2), regular);
                (of_first.max(of_second), Quadrature::Trapezoid)
            }
            Tick::Rough => (
                self.iterate(system, state, stage(to, RESIDUALS), regular),
                Quadrature::End,
            ),
        };
        let defect = defect.min(WORST);
        self.defect = self.defect.max(defect);
        let interval = Interval { end: to, length, rule };
        system.accumulate(self.start.view(), state.view(), interval);
        self.counts.steps += 1;
        defect
    }

    /// From the first stage to the second: its base lies by `rest` along the slopes of the first, and its first guess by `part` more.
    fn move_on(&mut self, state: &mut State, rest: f64, part: f64) {
        move_by(rest, &mut self.base.y, &self.start.y, &state.y_dot);
        move_by(rest, &mut self.base.q, &self.start.q, &state.y);
        move_by(part, &mut state.y, &self.base.y, &state.y_dot);
    }

    /// Iterates on a stage with the factors at hand; returns its defect. Without any (`regular`), y stays, and positions move on
    /// with it.
    fn iterate<S: Evolution>(&mut self, system: &mut S, state: &mut State, stage: Stage, regular: bool) -> f64 {
        let Stage {
            time,
            length,
            residuals,
        } = stage;
        let mut damping = 1.0_f64;
        let mut norm = f64::INFINITY;
        self.accepted.copy_from_slice(&state.y);
        self.step.fill(0.0);
        self.broyden.restart();
        for iteration in 0..residuals {
            for ((y, from), (u, s)) in state
                .y
                .iter_mut()
                .zip(&self.accepted)
                .zip(self.step.iter().zip(&self.scale))
            {
                *y = from + damping * (u * s);
            }
            self.complete(system, state, length);
            system.residual(time, state.view(), &mut self.correction);
            self.counts.residuals += 1;
            let after = if regular { self.correct() } else { f64::INFINITY };
            let allowed = if damping > LEAST {
                (1.0 - RESTRICTION * damping) * norm
            } else {
                GROWTH * norm
            };
            if after.is_finite() && (iteration == 0 || after <= allowed) {
                norm = after;
                self.accept(state, damping);
                if iteration > 0 {
                    damping = (damping / DAMPED).min(1.0);
                }
            } else {
                damping = (damping * DAMPED).max(LEAST);
            }
        }
        state.y.copy_from_slice(&self.accepted);
        self.complete(system, state, length);
        norm
    }

    /// The correction at the present point; its root mean square in units of Newton's scale.
    fn correct(&mut self) -> f64 {
        self.factors.solve(&mut self.correction);
        let squares = self.correction.iter().zip(&self.scale).map(|(d, s)| (d / s) * (d / s));
        (squares.sum::<f64>() / self.scale.len() as f64).sqrt()
    }

    /// Accepts the present point, which the damped step led to, and makes the step from it.
    fn accept(&mut self, state: &State, damping: f64) {
        self.accepted.copy_from_slice(&state.y);
        if damping < 1.0 {
            self.broyden.restart();
        }
        let step = self.broyden.step(&self.correction, &self.scale);
        self.step.copy_from_slice(step);
        if !self.broyden.is_finite() {
            // Two corrections alike to the last bit, or none at all: Broyden's update divides by nothing.
            self.broyden.restart();
            self.step.fill(0.0);
        }
    }

    /// Sets ẏ and q of a state to those that follow from y in a stage of this length.
    fn complete(&self, system: &impl System, state: &mut State, length: f64) {
        let alpha = 1.0 / length;
        for ((rate, y), base) in state.y_dot.iter_mut().zip(&state.y).zip(&self.base.y) {
            *rate = alpha * (y - base);
        }
        let moved = self.base.q.iter().zip(&state.y).map(|(q, y)| q + length * y);
        for ((q, has), moved) in state.q.iter_mut().zip(system.has_position()).zip(moved) {
            *q = if *has { moved } else { *q };
        }
    }
}
