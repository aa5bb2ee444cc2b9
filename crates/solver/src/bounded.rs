//! Time integration with bounded work, for real time: in each millisecond some Jacobians that differ little from those before
//! ([`Geometry`]), and a fixed number of residuals after each ([`Budget`]), whatever happens. A tick that isn't solved when the work is
//! used up stays open, and the next millisecond goes on with it from the best point so far, with a new Jacobian there. There are two
//! kinds of ticks, both one-step and L-stable:
//!
//! - A calm tick ([`Tick::Calm`]) is a step of [`Sdirk`](super::sdirk::Sdirk), of order two, in two stages.
//! - A rough tick ([`Tick::Rough`]) is implicit Euler, of order one: a swing of 70 Hz lags by 0.2 rad in ticks of 1 ms. It damps more,
//!   and has one stage to solve.
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
use super::sdirk::{Evolution, GAMMA, Geometry, Interval, Quadrature, move_by};
use super::{State, System};
use pushbelt_tape::Tape;

/// Longest tick of a run that keeps up with the clock, s.
pub const TICK: f64 = 1.0e-3;
/// Residuals after each Jacobian. All Jacobians have new slopes of the laws, and the first one of a millisecond new geometry too
/// ([`Geometry`]): of one of so many parts of the belt in a calm tick that begins there, else of all.
pub const RESIDUALS: usize = 8;
const PARTS: usize = 2;
/// Share of them that the first stage of a tick may take at once: the second one needs some.
const OF_FIRST: f64 = 0.75;
/// A stage that more work follows is solved where its correction is such a share of the first one, within limits. With an absolute
/// limit alone, a slow drift of smooth loads is lost.
const SOLVED: f64 = 3.0e-3;
const LIMITS: [f64; 2] = [1.0e-3, 10.0];
/// Defects up to which a stage is good enough, of calm and of rough ticks: while work is left, and once that of the millisecond is used up.
/// From a rough tick that is hardly solved the next ones are no better.
const GOOD: [[f64; 2]; 2] = [[150.0, 3.0], [150.0, 1000.0]];
/// Rough ticks that are shorter than this share of [`TICK`] are those after one that was not taken: they get whole Jacobians.
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

/// How a tick is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tick {
    /// Two stages of order two with tangents: where some iterations find the solution.
    Calm,
    /// One stage of order one with secants: where they don't.
    Rough,
}

impl Tick {
    /// Its stages.
    fn stages(self) -> usize {
        match self {
            Self::Calm => 2,
            Self::Rough => 1,
        }
    }

    /// Length of a stage, as a share of that of the tick.
    fn part(self) -> f64 {
        match self {
            Self::Calm => GAMMA,
            Self::Rough => 1.0,
        }
    }

    /// Defect up to which a stage is good enough, with work left or without.
    fn good(self, is_used_up: bool) -> f64 {
        let [calm, rough] = GOOD[usize::from(is_used_up)];
        match self {
            Self::Calm => calm,
            Self::Rough => rough,
        }
    }
}

/// A tick to solve.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    /// From when to when, s.
    pub span: [f64; 2],
    /// How.
    pub kind: Tick,
    /// It takes all work up to this part of the millisecond, though it needs less.
    pub takes: usize,
    /// Whether it ends when the work is used up, however far it got.
    pub is_forced: bool,
}

/// Where an open tick goes on.
#[derive(Clone, Copy, Debug)]
struct Mark {
    /// Stage under way.
    stage: usize,
    /// Whether it has a point already.
    begun: bool,
    /// Damping that its last steps were refused with: it goes on from there, since a Jacobian at the same point is the same. Else 1.
    damping: f64,
    /// Largest defect of the stages before.
    defect: f64,
}

impl Default for Mark {
    fn default() -> Self {
        Self {
            stage: 0,
            begun: false,
            damping: 1.0,
            defect: 0.0,
        }
    }
}

/// What is asked of a stage.
#[derive(Clone, Copy, Debug)]
struct Aim {
    /// It ends at this time and is so long, s.
    time: f64,
    length: f64,
    /// Residuals that it may take.
    residuals: usize,
    /// Defect from which on it may end before; without it all residuals are used.
    good: Option<f64>,
    /// Whether the residual at the present point is known.
    known: bool,
    /// Damping of the first step.
    damping: f64,
}

/// Ticks of bounded work.
#[derive(Clone, Debug)]
pub struct Bounded {
    matrix: Arrow,
    factors: ArrowLu,
    /// Whether there are factors.
    regular: bool,
    /// Part of the belt whose geometry is next.
    turn: usize,
    scale: Vec<f64>,
    correction: Vec<f64>,
    /// The point that was accepted last, its residual, and the step from it, scaled.
    accepted: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    broyden: Broyden,
    /// State at the start of the tick.
    start: State,
    /// y_0 and q_0 of a stage.
    base: State,
    /// Of an open tick: where it stands, y of its first stage, and y of the stage under way.
    open: Option<Mark>,
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
            matrix: Arrow::new(shape),
            factors: ArrowLu::new(shape),
            regular: false,
            turn: 0,
            scale: zeros(),
            correction: zeros(),
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

    /// Passes by a tape all that later ticks depend on beside the state. A millisecond begins with a new Jacobian.
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
        let mut mark = self.open.unwrap_or_default();
        let mut is_second = mark.stage > 0;
        let mut is_second_part = self.turn > 0;
        for flag in [&mut is_open, &mut is_second, &mut mark.begun, &mut is_second_part] {
            tape.flag(flag);
        }
        tape.real(&mut mark.damping);
        tape.real(&mut mark.defect);
        mark.stage = usize::from(is_second);
        self.turn = usize::from(is_second_part);
        self.open = is_open.then_some(mark);
        for values in [&mut self.first, &mut self.point, &mut self.residual] {
            tape.reals(values);
        }
    }

    /// Whether a tick is open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Gives up an open tick.
    pub fn give_up(&mut self) {
        self.open = None;
    }

    /// Begins a tick, or goes on with the open one, as far as the budget leads. Returns its defect once it is over: root mean square
    /// of the correction that is left, in units of Newton's scale. Until then the state stays at its start.
    pub fn tick<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        task: &Task,
        budget: &mut Budget,
    ) -> Option<f64> {
        let Task { span, kind, .. } = *task;
        let [from, to] = span;
        let length = to - from;
        let part = kind.part() * length;
        self.start.copy_from(state);
        self.base.copy_from(state);
        system.newton_scale(part, &mut self.scale);
        let mut mark = self.open.take().unwrap_or_default();
        loop {
            if mark.stage > 0 {
                state.y.copy_from_slice(&self.first);
                self.complete(system, state, part);
                self.move_on(state, length - part, part);
            }
            let is_last = mark.stage + 1 >= kind.stages();
            let time = if is_last { to } else { from + part };
            if mark.begun {
                state.y.copy_from_slice(&self.point);
            }
            if mark.begun || mark.stage > 0 {
                self.complete(system, state, part);
            }
            self.renew(system, state, (time, part), (kind, mark.begun), budget);
            let good = kind.good(budget.is_last());
            let share = if is_last || mark.begun { 1.0 } else { OF_FIRST };
            let aim = Aim {
                time,
                length: part,
                residuals: (share * budget.residuals as f64).ceil() as usize,
                good: (!is_last || kind == Tick::Calm && budget.part > task.takes).then_some(good),
                known: mark.begun,
                damping: mark.damping,
            };
            let (defect, damping) = self.iterate(system, state, aim, budget);
            mark.damping = damping;
            let is_good = defect <= good;
            let more = is_last && budget.part < task.takes && !budget.is_last();
            let ends = is_good || is_last && task.is_forced && budget.is_last();
            if more || !ends {
                mark.begun = defect.is_finite();
                self.point.copy_from_slice(&state.y);
                self.leave_open(state, mark);
                return None;
            }
            mark.defect = mark.defect.max(defect);
            if is_last {
                break;
            }
            self.first.copy_from_slice(&state.y);
            mark.begun = false;
            mark.damping = 1.0;
            mark.stage += 1;
            if budget.is_used_up() {
                self.leave_open(state, mark);
                return None;
            }
        }
        let rule = match kind {
            Tick::Calm => Quadrature::Trapezoid,
            Tick::Rough => Quadrature::End,
        };
        let defect = mark.defect.min(WORST);
        let interval = Interval { end: to, length, rule };
        system.accumulate(self.start.view(), state.view(), interval);
        self.counts.steps += 1;
        Some(defect)
    }

    fn leave_open(&mut self, state: &mut State, mark: Mark) {
        self.open = Some(mark);
        state.copy_from(&self.start);
    }

    /// Spends the Jacobian, if it is left, at the present point of a stage that ends at `time` and is `length` long, s; `goes_on` says that
    /// it was open.
    fn renew<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &State,
        (time, length): (f64, f64),
        (kind, goes_on): (Tick, bool),
        budget: &mut Budget,
    ) {
        if !std::mem::take(&mut budget.jacobian) {
            return;
        }
        let geometry = match kind {
            Tick::Rough if length < SHORT * TICK => Geometry::All,
            _ if budget.part > 1 => Geometry::Kept,
            Tick::Calm if !goes_on => Geometry::Part {
                number: self.turn,
                parts: PARTS,
            },
            _ => Geometry::All,
        };
        if budget.part == 1 {
            self.turn = (self.turn + 1) % PARTS;
        }
        let slopes = [1.0 / length, length];
        system.jacobian_with(geometry, time, state.view(), slopes, &mut self.matrix);
        self.counts.factorizations += 1;
        self.regular = self.factors.factor(&self.matrix).is_ok();
    }

    /// From the first stage to the second: its base lies by `rest` along the slopes of the first, and its first guess by `part` more.
    fn move_on(&mut self, state: &mut State, rest: f64, part: f64) {
        move_by(rest, &mut self.base.y, &self.start.y, &state.y_dot);
        move_by(rest, &mut self.base.q, &self.start.q, &state.y);
        move_by(part, &mut state.y, &self.base.y, &state.y_dot);
    }

    /// Iterates on a stage with the factors at hand; returns its defect, and the damping with which to go on. Without any, y stays, and
    /// positions move on with it.
    fn iterate<S: Evolution>(
        &mut self,
        system: &mut S,
        state: &mut State,
        aim: Aim,
        budget: &mut Budget,
    ) -> (f64, f64) {
        let Aim { time, length, .. } = aim;
        let mut damping = aim.damping;
        let mut has_moved = false;
        let mut norm = f64::INFINITY;
        let mut solved = 0.0;
        let (mut accepted, mut refused) = (0, 0);
        let mut known = aim.known;
        let mut left = aim.residuals;
        self.accepted.copy_from_slice(&state.y);
        self.step.fill(0.0);
        self.broyden.restart();
        while known || left > 0 {
            let moved = self.accepted.iter().zip(self.step.iter().zip(&self.scale));
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
                if aim.good.is_some() && norm < solved {
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
                if refused >= REFUSED && aim.good.is_some_and(|good| norm <= good) {
                    break;
                }
            }
        }
        state.y.copy_from_slice(&self.accepted);
        self.complete(system, state, length);
        (norm, if has_moved { 1.0 } else { damping })
    }

    /// The correction at the present point; its root mean square in units of Newton's scale.
    fn correct(&mut self) -> f64 {
        self.correction.copy_from_slice(&self.trial);
        self.factors.solve(&mut self.correction);
        let squares = self.correction.iter().zip(&self.scale).map(|(d, s)| (d / s) * (d / s));
        (squares.sum::<f64>() / self.scale.len() as f64).sqrt()
    }

    /// Accepts the present point, which the damped step led to, and makes the step from it.
    fn accept(&mut self, state: &State, damping: f64) {
        self.accepted.copy_from_slice(&state.y);
        std::mem::swap(&mut self.residual, &mut self.trial);
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
