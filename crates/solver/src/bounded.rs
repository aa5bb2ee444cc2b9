//! Time integration with bounded work, for real time. A millisecond has some Jacobians, most with reused geometry
//! ([`GeometryUpdate`]), and a fixed number of residuals after each ([`Budget`]). A step that is not solved when the work is used up
//! stays open. The next millisecond goes on from its best point, with a new Jacobian there. There are two schemes, both one-step and
//! L-stable:
//!
//! - [`Scheme::Sdirk`] is that of [`Sdirk`](super::sdirk::Sdirk): order two, two stages.
//! - [`Scheme::Euler`] is implicit Euler: order one, one stage, more damping. In steps of 1 ms a swing of 70 Hz lags by 0.2 rad.
//!
//! A stage is solved as far as its residuals last:
//!
//! - A step of the iteration is accepted if the simplified correction after it is smaller, else halved: the restricted monotonicity test
//!   of Deuflhard, Newton Methods for Nonlinear Problems (2011), section 3.3. After a whole step Broyden's update follows.
//! - The stage ends at the point that was accepted last. Its defect is the size of the next correction.
//!
//! What a step leaves unsolved acts in the next one as a force out of balance.

use super::broyden::Broyden;
use super::newton::Counts;
use super::sdirk::{Evolution, GAMMA, GeometryUpdate, Interval, Quadrature, move_by};
use super::stage::{Chord, Stage};
use super::{State, System};
use pushbelt_tape::Tape;

/// Unit of the clock, s: a millisecond.
pub const TICK: f64 = 1.0e-3;
/// Residuals after each Jacobian. All Jacobians have new constitutive tangents. The first one of a millisecond has new geometry too
/// ([`GeometryUpdate`]): in an SDIRK step that begins there of one of so many parts of the system, else of all.
pub const RESIDUALS: usize = 8;
const PARTS: usize = 2;
/// Share of them that the first stage of a step may take at once: the second one needs some.
const OF_FIRST: f64 = 0.75;
/// A stage that more work follows is solved where its correction is such a share of the first one, within limits. With an absolute
/// limit alone, a slow drift of smooth loads is lost.
const SOLVED: f64 = 3.0e-3;
const LIMITS: [f64; 2] = [1.0e-3, 10.0];
/// Defects up to which a stage is accepted, in SDIRK steps and in Euler steps: while work is left, and once that of the millisecond is
/// used up. After an Euler step that is hardly solved the next ones are no better.
const GOOD: [[f64; 2]; 2] = [[150.0, 3.0], [150.0, 1000.0]];
/// Euler steps that are shorter than this share of [`TICK`] follow a rollback: they get whole Jacobians.
const SHORT: f64 = 0.5;
/// So many refused steps in a row end a stage that is good enough.
const REFUSED: u32 = 3;
/// So many steps in a row have to be accepted before the damping changes back: with one, every second step is refused.
const ACCEPTED: u32 = 2;
/// By how much the correction after a step must be below the one before: 1 − λ/4 at damping λ.
const RESTRICTION: f64 = 0.25;
/// Change of the damping after a step that was refused.
const DAMPED: f64 = 0.5;
/// Damping at which a step may also grow the correction, and by how much: a saddle is left. Where gaps close all along the belt, a step may
/// lead hundreds of times too far: with 0.03 a run of `ALE` under a clutch that hunts never goes on.
const LEAST: f64 = 1.0e-3;
const GROWTH: f64 = 2.0;
/// Defect that stands for an evaluation that was no number.
const WORST: f64 = 1.0e9;
/// What the rounding of floating-point times may add to a share of the work.
const ROUND_OFF: f64 = 1.0e-6;

/// Work that is left of a part of a millisecond: a Jacobian and some residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Whether the Jacobian is left.
    jacobian: bool,
    residuals: usize,
    /// Which part of the millisecond it is, from 1 on, and how many there are.
    part: usize,
    parts: usize,
}

impl Budget {
    /// A whole Jacobian and so many residuals, and nothing after them.
    #[must_use]
    pub fn of(residuals: usize) -> Self {
        Self {
            jacobian: true,
            residuals,
            part: 1,
            parts: 1,
        }
    }

    /// The parts of a millisecond with so many Jacobians.
    pub fn millisecond(jacobians: usize) -> impl Iterator<Item = Self> {
        (1..=jacobians).map(move |part| Self {
            jacobian: true,
            residuals: RESIDUALS,
            part,
            parts: jacobians,
        })
    }

    /// Whether nothing is left of it.
    #[must_use]
    pub fn is_used_up(&self) -> bool {
        self.residuals == 0
    }

    /// The part with which such a share of the millisecond's work is used up; 0 if it is none.
    #[must_use]
    pub fn part_at(&self, share: f64) -> usize {
        (share * self.parts as f64 - ROUND_OFF).ceil().max(0.0) as usize
    }

    fn is_last(&self) -> bool {
        self.part == self.parts
    }
}

/// Formula of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Order two in two stages: while a few iterations find the solution.
    Sdirk,
    /// Order one in one stage: after a step that was not solved.
    Euler,
}

impl Scheme {
    fn stages(self) -> usize {
        match self {
            Self::Sdirk => 2,
            Self::Euler => 1,
        }
    }

    /// γ: length of a stage, as a share of that of the step.
    fn gamma(self) -> f64 {
        match self {
            Self::Sdirk => GAMMA,
            Self::Euler => 1.0,
        }
    }

    /// Defect up to which a stage is accepted, with work left or without.
    fn accepted_defect(self, is_used_up: bool) -> f64 {
        let [sdirk, euler] = GOOD[usize::from(is_used_up)];
        match self {
            Self::Sdirk => sdirk,
            Self::Euler => euler,
        }
    }
}

/// A step to solve.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// From when to when, s.
    pub span: [f64; 2],
    /// Formula.
    pub scheme: Scheme,
    /// It takes all work up to this part of the millisecond, though it needs less.
    pub takes: usize,
    /// Whether it ends when the work is used up, however far it got.
    pub is_forced: bool,
}

/// Where an open step goes on.
#[derive(Clone, Copy, Debug)]
struct OpenStep {
    /// Number of the stage.
    stage: usize,
    /// Whether the stage has a point already.
    begun: bool,
    /// Damping with which the last iterations were refused: it goes on from there, since a Jacobian at the same point is the same. Else 1.
    damping: f64,
    /// Largest defect of the stages before.
    defect: f64,
}

impl Default for OpenStep {
    fn default() -> Self {
        Self {
            stage: 0,
            begun: false,
            damping: 1.0,
            defect: 0.0,
        }
    }
}

/// When the iteration on a stage ends.
struct Limits {
    /// Residuals that it may take.
    residuals: usize,
    /// Defect from which on it may end before; without it all residuals are used.
    accepted_defect: Option<f64>,
}

/// Steps of bounded work.
#[derive(Clone, Debug)]
pub struct Bounded {
    chord: Chord,
    /// Whether there are factors.
    regular: bool,
    /// Part of the system whose geometry is next.
    turn: usize,
    /// The point that was accepted last, its residual, and the step from it, scaled.
    accepted: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    broyden: Broyden,
    /// State at the start of the step.
    start: State,
    /// y_0 and q_0 of a stage.
    base: State,
    /// The open step, y of its first stage, and y of its present one.
    open: Option<OpenStep>,
    first: Vec<f64>,
    point: Vec<f64>,
    /// Work counts.
    pub counts: Counts,
}

impl Bounded {
    /// Memory for `system`.
    #[must_use]
    pub fn new(system: &impl System) -> Self {
        let shape = system.shape();
        let zeros = || vec![0.0; shape.len()];
        Self {
            chord: Chord::new(system),
            regular: false,
            turn: 0,
            accepted: zeros(),
            residual: zeros(),
            step: zeros(),
            trial: zeros(),
            broyden: Broyden::new(RESIDUALS + 1, shape.len()),
            start: State::zero(shape.len()),
            base: State::zero(shape.len()),
            open: None,
            first: zeros(),
            point: zeros(),
            counts: Counts::default(),
        }
    }

    /// Writes to a tape, or reads from it, all that later steps depend on beside the state. A millisecond begins with a new Jacobian.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        let Counts {
            steps,
            rejected,
            residuals,
            factorizations,
            ..
        } = &mut self.counts;
        for count in [steps, rejected, residuals, factorizations] {
            tape.counter(count);
        }
        let mut is_open = self.open.is_some();
        let mut open = self.open.unwrap_or_default();
        let mut is_second = open.stage > 0;
        let mut is_second_part = self.turn > 0;
        for flag in [&mut is_open, &mut is_second, &mut open.begun, &mut is_second_part] {
            tape.flag(flag);
        }
        tape.real(&mut open.damping);
        tape.real(&mut open.defect);
        open.stage = usize::from(is_second);
        self.turn = usize::from(is_second_part);
        self.open = is_open.then_some(open);
        for values in [&mut self.first, &mut self.point, &mut self.residual] {
            tape.reals(values);
        }
    }

    /// Whether a step is open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Drops an open step.
    pub fn abandon(&mut self) {
        self.open = None;
    }

    /// Begins a step, or continues the open one, as far as the budget lasts. Returns its defect once it is over: root mean square
    /// of the correction that is left, in units of Newton's scale. Until then the state stays at its start.
    pub fn tick<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        tick: &Tick,
        budget: &mut Budget,
    ) -> Option<f64> {
        let Tick { span, scheme, .. } = *tick;
        let [from, to] = span;
        let length = to - from;
        let part = scheme.gamma() * length;
        self.start.copy_from(state);
        self.base.copy_from(state);
        system.newton_scale(part, &mut self.chord.scale);
        let mut open = self.open.take().unwrap_or_default();
        loop {
            if open.stage > 0 {
                state.y.copy_from_slice(&self.first);
                self.complete(system, state, part);
                self.begin_second(state, length - part, part);
            }
            let is_last = open.stage + 1 >= scheme.stages();
            let time = if is_last { to } else { from + part };
            if open.begun {
                state.y.copy_from_slice(&self.point);
            }
            if open.begun || open.stage > 0 {
                self.complete(system, state, part);
            }
            self.renew(system, state, (time, part), (scheme, open.begun), budget);
            let accepted_defect = scheme.accepted_defect(budget.is_last());
            let share = if is_last || open.begun { 1.0 } else { OF_FIRST };
            let may_end = !is_last || scheme == Scheme::Sdirk && budget.part > tick.takes;
            let limits = Limits {
                residuals: (share * budget.residuals as f64).ceil() as usize,
                accepted_defect: may_end.then_some(accepted_defect),
            };
            let defect = self.iterate(system, state, (time, part), &mut open, &limits, budget);
            let more = is_last && budget.part < tick.takes && !budget.is_last();
            let ends = defect <= accepted_defect || is_last && tick.is_forced && budget.is_last();
            if more || !ends {
                open.begun = defect.is_finite();
                self.point.copy_from_slice(&state.y);
                self.leave_open(state, open);
                return None;
            }
            open.defect = open.defect.max(defect);
            if is_last {
                break;
            }
            self.first.copy_from_slice(&state.y);
            open = OpenStep {
                stage: open.stage + 1,
                defect: open.defect,
                ..OpenStep::default()
            };
            if budget.is_used_up() {
                self.leave_open(state, open);
                return None;
            }
        }
        let rule = match scheme {
            Scheme::Sdirk => Quadrature::Trapezoid,
            Scheme::Euler => Quadrature::End,
        };
        let interval = Interval { end: to, length, rule };
        system.accumulate(self.start.view(), state.view(), interval);
        self.counts.steps += 1;
        Some(open.defect.min(WORST))
    }

    fn leave_open(&mut self, state: &mut State, open: OpenStep) {
        self.open = Some(open);
        state.copy_from(&self.start);
    }

    /// Spends the Jacobian, if it is left, at the present point of a stage that ends at `time` and is `length` long, s; `goes_on`: the
    /// stage was open.
    fn renew<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &State,
        (time, length): (f64, f64),
        (scheme, goes_on): (Scheme, bool),
        budget: &mut Budget,
    ) {
        if !std::mem::take(&mut budget.jacobian) {
            return;
        }
        let geometry = match scheme {
            Scheme::Euler if length < SHORT * TICK => GeometryUpdate::All,
            _ if budget.part > 1 => GeometryUpdate::None,
            Scheme::Sdirk if !goes_on => GeometryUpdate::Part {
                number: self.turn,
                parts: PARTS,
            },
            _ => GeometryUpdate::All,
        };
        if budget.part == 1 {
            self.turn = (self.turn + 1) % PARTS;
        }
        let slopes = [1.0 / length, length];
        self.counts.factorizations += 1;
        self.regular = self
            .chord
            .factor(|matrix| system.jacobian_with(geometry, time, state.view(), slopes, matrix));
    }

    /// Base of the second stage, by `rest` along the slopes of the first, and its predictor, by `part` more.
    fn begin_second(&mut self, state: &mut State, rest: f64, part: f64) {
        move_by(rest, &mut self.base.y, &self.start.y, &state.y_dot);
        move_by(rest, &mut self.base.q, &self.start.q, &state.y);
        move_by(part, &mut state.y, &self.base.y, &state.y_dot);
    }

    /// Iterates on a stage that ends at `time` and is `length` long, s, with the factors at hand. Returns its defect. Without factors y
    /// stays, and positions move on with it.
    fn iterate<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        (time, length): (f64, f64),
        open: &mut OpenStep,
        limits: &Limits,
        budget: &mut Budget,
    ) -> f64 {
        let mut damping = open.damping;
        let mut has_moved = false;
        let mut norm = f64::INFINITY;
        let mut solved = 0.0;
        let (mut accepted, mut refused) = (0, 0);
        let mut known = open.begun;
        let mut left = limits.residuals;
        self.accepted.copy_from_slice(&state.y);
        self.step.fill(0.0);
        self.broyden.restart();
        while known || left > 0 {
            let moved = self.accepted.iter().zip(self.step.iter().zip(&self.chord.scale));
            for (y, (from, (u, s))) in state.y.iter_mut().zip(moved) {
                *y = from + damping * (u * s);
            }
            self.complete(system, state, length);
            if known {
                self.trial.copy_from_slice(&self.residual);
            } else {
                system.residual(time, state.view(), &mut self.trial);
                self.counts.residuals += 1;
                budget.residuals -= 1;
                left -= 1;
            }
            known = false;
            let after = if self.regular { self.correct() } else { f64::INFINITY };
            let is_first = norm.is_infinite();
            let allowed = if damping > LEAST {
                (1.0 - RESTRICTION * damping) * norm
            } else {
                GROWTH * norm
            };
            if after.is_finite() && (is_first || after <= allowed) {
                accepted = if after < norm { accepted + 1 } else { 0 };
                norm = after;
                self.accept(state, damping);
                has_moved |= !is_first;
                if is_first {
                    solved = (SOLVED * norm).clamp(LIMITS[0], LIMITS[1]);
                }
                if limits.accepted_defect.is_some() && norm < solved {
                    break;
                }
                refused = 0;
                if accepted >= ACCEPTED {
                    damping = (damping / DAMPED).min(1.0);
                }
            } else {
                damping = (damping * DAMPED).max(LEAST);
                accepted = 0;
                refused += 1;
                if refused >= REFUSED && limits.accepted_defect.is_some_and(|accepted| norm <= accepted) {
                    break;
                }
            }
        }
        state.y.copy_from_slice(&self.accepted);
        self.complete(system, state, length);
        open.damping = if has_moved { 1.0 } else { damping };
        norm
    }

    /// The correction at the present point; its root mean square in units of Newton's scale.
    fn correct(&mut self) -> f64 {
        self.chord.correct(&self.trial);
        (self.chord.measure().1 / self.trial.len() as f64).sqrt()
    }

    /// Accepts the present point, which the damped step led to, and makes the step from it.
    fn accept(&mut self, state: &State, damping: f64) {
        self.accepted.copy_from_slice(&state.y);
        std::mem::swap(&mut self.residual, &mut self.trial);
        if damping < 1.0 {
            self.broyden.restart();
        }
        let step = self.broyden.step(&self.chord.correction, &self.chord.scale);
        self.step.copy_from_slice(step);
        if !self.broyden.is_finite() {
            // Two corrections alike to the last bit, or none at all: Broyden's update divides by nothing.
            self.broyden.restart();
            self.step.fill(0.0);
        }
    }

    /// Sets ẏ and q of a state to those of y in a stage of this length.
    fn complete(&self, system: &impl System, state: &mut State, length: f64) {
        let mut stage = Stage {
            time: 0.0,
            slopes: [1.0 / length, length],
            base: &self.base.y,
            position: &self.base.q,
            state,
        };
        stage.complete(system.has_position());
    }
}
