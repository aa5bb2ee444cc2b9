//! Real time: a run that does the same work in each millisecond of the clock ([`Budget`]), whatever happens.
//!
//! - While ticks find their solution they are calm, on the laws that the user has set. A millisecond is one of them, or some shorter
//!   ones that share its work ([`Division`]).
//! - A tick that is still open when the work is used up goes on in the next millisecond: the run is behind the clock, and catches up
//!   where ticks need less work than there is. Its inputs wait ([`Backlog`]).
//! - A tick that stays open for too long is given up. Ticks are rough then, on rounded laws ([`Rounding`]), and not solved any more
//!   than the work allows.
//! - A rough tick that ends very far from its solution is not taken: the run goes back to the last state that was solved and on from
//!   there in shorter ticks.

mod backlog;
mod division;
mod rounding;

use crate::solver::bounded::{Bounded, Budget, Task, Tick};
use crate::solver::newton::Counts;
use crate::solver::{State, System};
use crate::tape::Tape;
use crate::variator::run::course::{Course, Held, SHORTEST_STEP};
use crate::variator::run::real_time::backlog::Backlog;
use crate::variator::run::real_time::division::Division;
use crate::variator::run::real_time::rounding::Rounding;
use crate::variator::survey::ledger::Running;

/// Milliseconds that a tick may wait to be solved. With two, flips err twice as much.
const PATIENCE: u64 = 3;
/// Time behind the clock from which on no tick waits, s.
const LATE: f64 = 0.0045;
/// Defect up to which a state counts as solved.
const SOLVED: f64 = 400.0;
/// Defect from which on a tick is not taken: the next ones would be further off.
const BACK: f64 = 2.0e4;
/// Energy that may appear or vanish in a tick that isn't solved, J, and as a share of what passes. With 5 J and no share, macro-slip is
/// seen 7 ms late.
const UNACCOUNTED: [f64; 2] = [2.0, 0.2];
/// What a tick that is not taken does to the length of the next ones, what one that is solved does, and the least that is left of it.
const SHORTER: f64 = 0.25;
const LONGER: f64 = 1.5;
const SHORTEST: f64 = 0.01;
/// A rest that is shorter than such a share of a tick of the clock belongs to the tick before.
const REST: f64 = 0.4;
/// Longest time that a run is behind the clock, s. What is beyond it is never made up for.
const BEHIND: f64 = 0.02;

/// A tick to come: from when to when, how, by what share the laws are rounded, and the inputs over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    span: [f64; 2],
    kind: Tick,
    pub rounding: f64,
    pub held: Held,
}

impl Plan {
    /// No time at all.
    const NONE: Self = Self {
        span: [0.0; 2],
        kind: Tick::Calm,
        rounding: 0.0,
        held: Held::NONE,
    };

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        for time in &mut self.span {
            tape.real(time);
        }
        let mut is_rough = self.kind == Tick::Rough;
        tape.flag(&mut is_rough);
        self.kind = if is_rough { Tick::Rough } else { Tick::Calm };
        tape.real(&mut self.rounding);
        self.held.serialize(tape);
    }
}

/// A run in real time.
#[derive(Clone, Debug)]
pub(super) struct RealTime {
    ticks: Bounded,
    rounding: Rounding,
    division: Division,
    /// Time of the clock, and length of a tick of the clock, s.
    clock: f64,
    length: f64,
    /// Time of the state, s, and the inputs from there to the clock's time.
    reached: f64,
    backlog: Backlog,
    /// The state to go back to, its time, s, and the energies there.
    solved: State,
    solved_at: f64,
    energies: [f64; 3],
    /// Length of ticks, as a share of the clock's.
    share: f64,
    /// The tick that is open, if one is, and for how many milliseconds.
    plan: Plan,
    waiting: u64,
    /// Largest defect of the ticks that were kept in this communication step.
    defect: f64,
}

impl RealTime {
    /// Memory for a system.
    pub fn new(system: &impl System) -> Self {
        Self {
            ticks: Bounded::new(system),
            rounding: Rounding::default(),
            division: Division::default(),
            clock: 0.0,
            length: 0.0,
            reached: 0.0,
            backlog: Backlog::new(),
            solved: State::zero(system.shape().len()),
            solved_at: 0.0,
            energies: [0.0; 3],
            share: 1.0,
            plan: Plan::NONE,
            waiting: 0,
            defect: 0.0,
        }
    }

    /// Begins a run from a state at a time, s, with no energies yet.
    pub fn begin(&mut self, state: &State, time: f64) {
        self.ticks.counts = Counts::default();
        self.ticks.give_up();
        self.rounding = Rounding::default();
        self.division = Division::default();
        (self.clock, self.reached, self.solved_at) = (time, time, time);
        self.backlog.clear();
        self.solved.copy_from(state);
        self.energies = [0.0; 3];
        self.share = 1.0;
        self.waiting = 0;
    }

    /// Begins a stretch of the clock's time, s, with its inputs, in which there is work for so many Jacobians.
    pub fn live(&mut self, course: &Course, [from, to]: [f64; 2], jacobians: usize) {
        let is_calm = self.behind() < SHORTEST_STEP && self.rounding.share() == 0.0;
        self.division.follow(is_calm, jacobians, to - from);
        self.backlog.add(course, [from, to]);
        (self.clock, self.length) = (to, to - from);
        if !self.ticks.is_open() {
            return;
        }
        self.waiting += 1;
        if self.plan.kind == Tick::Calm && (self.waiting >= PATIENCE || self.behind() > LATE) {
            self.ticks.give_up();
            self.waiting = 0;
            self.rounding.rise();
            self.backlog.level(self.reached);
        }
    }

    /// The next tick until the clock's time, as long as the budget lasts: the open one, or another. A rough one takes the mean of its
    /// inputs, so no impulse is lost; a calm one their straight line.
    pub fn plan(&mut self, budget: &Budget) -> Option<Plan> {
        if budget.is_used_up() || self.clock - self.reached < SHORTEST_STEP {
            return None;
        }
        if !self.ticks.is_open() {
            let rounding = self.rounding.share();
            let kind = if rounding > 0.0 { Tick::Rough } else { Tick::Calm };
            let whole = match kind {
                Tick::Calm => self.length / self.division.ticks(),
                Tick::Rough => self.length,
            };
            let end = self.reached + self.share * whole;
            let end = if end > self.clock - REST * whole {
                self.clock
            } else {
                end
            };
            let span = [self.reached, end];
            let held = match kind {
                Tick::Calm => self.backlog.line(span),
                Tick::Rough => Held::constant(self.reached, &self.backlog.mean(span)),
            };
            self.plan = Plan {
                span,
                kind,
                rounding,
                held,
            };
        }
        Some(self.plan)
    }

    /// Goes on with the tick that was planned, from a state to the next.
    pub fn tick(&mut self, running: &mut Running<'_>, state: &mut State, budget: &mut Budget) {
        let Plan { span, kind, .. } = self.plan;
        // A calm tick that is over is solved: nobody asks what it left unaccounted for.
        let books = |running: &Running<'_>, state: &State| (running.unaccounted(state.view()), running.ledger.moved);
        let before = (kind == Tick::Rough).then(|| books(running, state));
        let task = Task {
            span,
            kind,
            takes: budget.part_at(1.0 - (self.clock - span[1]) / self.length),
            is_forced: kind == Tick::Rough && (self.waiting >= PATIENCE || self.behind() > LATE),
        };
        let Some(defect) = self.ticks.tick(running, state, &task, budget) else {
            return;
        };
        self.waiting = 0;
        if kind == Tick::Rough {
            self.rounding.follow(defect);
        }
        let is_sound = before.is_none_or(|before| {
            let after = books(running, state);
            (after.0 - before.0).abs() <= UNACCOUNTED[0] + UNACCOUNTED[1] * (after.1 - before.1)
        });
        if defect > BACK || defect > SOLVED && !is_sound {
            self.go_back(running, state);
        } else {
            self.reached = span[1];
            self.defect = self.defect.max(defect);
            if defect < SOLVED {
                self.keep(running, state);
            }
        }
        if self.clock - self.reached > BEHIND {
            self.backlog.level(self.reached);
            self.reached = self.clock - BEHIND;
            self.solved_at = self.reached;
        }
    }

    fn keep(&mut self, running: &Running<'_>, state: &State) {
        self.solved.copy_from(state);
        self.solved_at = self.reached;
        self.energies = running.energies();
        self.backlog.forget(self.reached);
        self.share = (LONGER * self.share).min(1.0);
    }

    fn go_back(&mut self, running: &mut Running<'_>, state: &mut State) {
        state.copy_from(&self.solved);
        state.y_dot.fill(0.0);
        running.go_back(self.energies, state.view());
        self.reached = self.solved_at;
        self.backlog.level(self.reached);
        self.share = (SHORTER * self.share).max(SHORTEST);
        self.ticks.counts.steps -= 1;
        self.ticks.counts.rejected += 1;
    }

    /// Largest defect since it was asked for.
    pub fn take_defect(&mut self) -> f64 {
        std::mem::take(&mut self.defect)
    }

    /// How often the run went back since it began.
    pub fn rollbacks(&self) -> u64 {
        self.ticks.counts.rejected
    }

    /// How far the state is behind the clock, s.
    pub fn behind(&self) -> f64 {
        self.clock - self.reached
    }

    /// Work done since the run began.
    pub fn counts(&self) -> Counts {
        self.ticks.counts
    }

    /// Passes by a tape all that later ticks depend on.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        self.ticks.serialize(tape);
        self.rounding.serialize(tape);
        self.division.serialize(tape);
        self.backlog.serialize(tape);
        self.solved.serialize(tape);
        self.plan.serialize(tape);
        tape.counter(&mut self.waiting);
        let times = [&mut self.clock, &mut self.reached, &mut self.solved_at, &mut self.share];
        for value in times.into_iter().chain(&mut self.energies) {
            tape.real(value);
        }
    }
}
