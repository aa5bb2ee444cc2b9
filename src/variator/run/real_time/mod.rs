//! Real time: the work of each millisecond of the clock is bounded ([`Budget`]).
//!
//! - While steps find their solution they are SDIRK2 on the laws as set. A millisecond is one of them, or some shorter ones that share its
//!   work ([`Division`]).
//! - A step that is still open when the work is used up goes on in the next millisecond: the run is behind the clock. It catches up where
//!   steps need less work than there is. Inputs wait for it ([`PendingInputs`]).
//! - A step that stays open for too long is abandoned. The next ones are implicit Euler on rounded laws ([`Rounding`]), and are solved as far
//!   as the work lasts.
//! - Such a step that ends very far from its solution is not kept: the run rolls back to the last state that was solved and goes on from
//!   there in shorter steps.

mod division;
mod pending_inputs;
mod rounding;

use crate::solver::State;
use crate::solver::bounded::{Bounded, Budget, Scheme, TICK, Tick};
use crate::solver::newton::Counts;
use crate::solver::sdirk::Stalled;
use crate::tape::Tape;
use crate::variator::run::inputs::{InputProfile, InputSegment, SHORTEST_STEP};
use crate::variator::run::plant::Plant;
use crate::variator::run::real_time::division::Division;
use crate::variator::run::real_time::pending_inputs::PendingInputs;
use crate::variator::run::real_time::rounding::Rounding;
use crate::variator::run::stepper::{NEWTON_TOLERANCE, Stepper, work};
use crate::variator::settings::signals::Work;
use crate::variator::survey::energy_balance::Running;

/// Milliseconds for which a step may stay open. With two, flips err twice as much.
const PATIENCE: u64 = 3;
/// Time behind the clock from which on no step stays open, s.
const LATE: f64 = 0.0045;
/// Defect up to which a state counts as solved.
const SOLVED: f64 = 400.0;
/// Defect from which on a step is not kept: the next ones would be further off.
const ROLLED_BACK: f64 = 2.0e4;
/// Energy residual that a step may have that isn't solved, J, and as a share of what passes. With 5 J and no share, macro-slip is
/// seen 7 ms late.
const RESIDUAL: [f64; 2] = [2.0, 0.2];
/// Change of the length of steps after a rollback, after a step that was solved, and the least that is left of it.
const SHORTER: f64 = 0.25;
const LONGER: f64 = 1.5;
const SHORTEST: f64 = 0.01;
/// A rest that is shorter than such a share of a whole step belongs to the step before.
const REST: f64 = 0.4;
/// Longest time that a run is behind the clock, s. What is beyond it is left out.
const BEHIND: f64 = 0.02;

/// A run in real time.
#[derive(Clone, Debug)]
pub(super) struct RealTime {
    bounded: Bounded,
    rounding: Rounding,
    division: Division,
    /// The communication step, s, its number of milliseconds or shorter parts, and how many of them are over.
    span: [f64; 2],
    parts: f64,
    over: f64,
    /// Time of the clock, and length of its last part, s.
    clock: f64,
    length: f64,
    /// Time of the state, s, and the inputs from there to the clock's time.
    reached: f64,
    pending: PendingInputs,
    /// The state to roll back to, its time, s, and the energies there.
    solved: State,
    solved_at: f64,
    energies: [f64; 3],
    /// Length of steps, as a share of that of whole ones.
    share: f64,
    /// The open step, if one is: time, s, formula, share of rounding, inputs, and for how many milliseconds it has been open.
    step: [f64; 2],
    scheme: Scheme,
    rounded: f64,
    inputs: InputSegment,
    waiting: u64,
    /// Largest defect of the steps of this communication step that were kept.
    defect: f64,
}

impl RealTime {
    /// A run that begins with the state and at the time of a plant.
    pub fn new(plant: &Plant) -> Self {
        Self {
            bounded: Bounded::new(&plant.system),
            rounding: Rounding::default(),
            division: Division::default(),
            span: [plant.time; 2],
            parts: 0.0,
            over: 0.0,
            clock: plant.time,
            length: 0.0,
            reached: plant.time,
            pending: PendingInputs::new(),
            solved: plant.state.clone(),
            solved_at: plant.time,
            energies: [0.0; 3],
            share: 1.0,
            step: [0.0; 2],
            scheme: Scheme::Sdirk,
            rounded: 0.0,
            inputs: InputSegment::NONE,
            waiting: 0,
            defect: 0.0,
        }
    }

    /// Advances the clock, s, with its inputs, by a part that has work for so many Jacobians.
    fn advance_clock(&mut self, profile: &InputProfile, [from, to]: [f64; 2], jacobians: usize) {
        let is_on_time = self.behind() < SHORTEST_STEP && self.rounding.share() == 0.0;
        self.division.follow(is_on_time, jacobians, to - from);
        self.pending.add(profile, [from, to]);
        (self.clock, self.length) = (to, to - from);
        if !self.bounded.is_open() {
            return;
        }
        self.waiting += 1;
        if self.scheme == Scheme::Sdirk && self.is_late() {
            self.bounded.abandon();
            self.waiting = 0;
            self.rounding.rise();
            self.pending.level(self.reached);
        }
    }

    /// Whether the open step has been open for too long.
    fn is_late(&self) -> bool {
        self.waiting >= PATIENCE || self.behind() > LATE
    }

    /// Chooses the next step until the clock's time, unless one is open. False if there is none, or no budget. Implicit Euler takes the mean
    /// of the inputs, so no impulse is lost; SDIRK2 takes their straight line.
    fn has_step(&mut self, budget: &Budget) -> bool {
        if budget.is_used_up() || self.clock - self.reached < SHORTEST_STEP {
            return false;
        }
        if !self.bounded.is_open() {
            self.rounded = self.rounding.share();
            let (scheme, whole) = if self.rounded > 0.0 {
                (Scheme::Euler, self.length)
            } else {
                (Scheme::Sdirk, self.length / self.division.ticks())
            };
            let end = self.reached + self.share * whole;
            let end = if end > self.clock - REST * whole {
                self.clock
            } else {
                end
            };
            self.scheme = scheme;
            self.step = [self.reached, end];
            self.inputs = match scheme {
                Scheme::Sdirk => self.pending.line(self.step),
                Scheme::Euler => InputSegment::constant(self.reached, &self.pending.mean(self.step)),
            };
        }
        true
    }

    /// Continues the chosen step.
    fn go_on(&mut self, plant: &mut Plant, budget: &mut Budget) {
        plant.system.round(self.rounded);
        plant.apply(self.inputs);
        let (mut running, state) = plant.running();
        let [_, to] = self.step;
        let is_euler = self.scheme == Scheme::Euler;
        // An SDIRK step that is over is solved.
        let balance =
            |running: &Running<'_>, state: &State| (running.energy_residual(state.view()), running.energy.moved);
        let before = is_euler.then(|| balance(&running, state));
        let tick = Tick {
            span: self.step,
            scheme: self.scheme,
            takes: budget.part_at(1.0 - (self.clock - to) / self.length),
            is_forced: is_euler && self.is_late(),
        };
        let Some(defect) = self.bounded.tick(&mut running, state, &tick, budget) else {
            return;
        };
        self.waiting = 0;
        if is_euler {
            self.rounding.follow(defect);
        }
        let is_sound = before.is_none_or(|before| {
            let after = balance(&running, state);
            (after.0 - before.0).abs() <= RESIDUAL[0] + RESIDUAL[1] * (after.1 - before.1)
        });
        if defect > ROLLED_BACK || defect > SOLVED && !is_sound {
            self.roll_back(&mut running, state);
        } else {
            self.reached = to;
            self.defect = self.defect.max(defect);
            if defect < SOLVED {
                self.keep(&running, state);
            }
        }
        if self.clock - self.reached > BEHIND {
            self.pending.level(self.reached);
            self.reached = self.clock - BEHIND;
            self.solved_at = self.reached;
        }
    }

    fn keep(&mut self, running: &Running<'_>, state: &State) {
        self.solved.copy_from(state);
        self.solved_at = self.reached;
        self.energies = running.energies();
        self.pending.forget(self.reached);
        self.share = (LONGER * self.share).min(1.0);
    }

    fn roll_back(&mut self, running: &mut Running<'_>, state: &mut State) {
        state.copy_from(&self.solved);
        state.y_dot.fill(0.0);
        running.roll_back(self.energies, state.view());
        self.reached = self.solved_at;
        self.pending.level(self.reached);
        self.share = (SHORTER * self.share).max(SHORTEST);
        self.bounded.counts.steps -= 1;
        self.bounded.counts.rejected += 1;
    }

    /// How far the state is behind the clock, s.
    fn behind(&self) -> f64 {
        self.clock - self.reached
    }
}

impl Stepper for RealTime {
    fn boxed(&self) -> Box<dyn Stepper> {
        Box::new(self.clone())
    }

    fn begin(&mut self, span: [f64; 2]) {
        let [from, to] = span;
        self.span = span;
        self.parts = ((to - from) / TICK - SHORTEST_STEP).ceil().max(1.0);
        self.over = 0.0;
    }

    fn restart(&mut self, span: [f64; 2]) {
        if span[1] != self.span[1] {
            self.begin(span);
        }
    }

    /// The work of one millisecond.
    fn step(&mut self, plant: &mut Plant, profile: &InputProfile, to: f64) -> Result<bool, Stalled> {
        self.over += 1.0;
        let is_over = self.over >= self.parts;
        let [from, end] = self.span;
        let until = if is_over {
            to
        } else {
            from + self.over * ((end - from) / self.parts)
        };
        let jacobians = plant.system.parameters.solver.effort as usize;
        self.advance_clock(profile, [plant.time, until], jacobians);
        for mut budget in Budget::millisecond(jacobians) {
            while self.has_step(&budget) {
                self.go_on(plant, &mut budget);
            }
        }
        plant.time = until;
        Ok(is_over)
    }

    fn finish(&mut self, plant: &mut Plant, profile: &InputProfile) -> Work {
        plant.apply(profile.segment(plant.time));
        let counts = self.counts();
        let defect = std::mem::take(&mut self.defect) / NEWTON_TOLERANCE;
        Work {
            behind: self.behind(),
            rollbacks: i32::try_from(counts.rejected).unwrap_or(i32::MAX),
            ..work(counts, defect)
        }
    }

    fn counts(&self) -> Counts {
        self.bounded.counts
    }

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        self.bounded.serialize(tape);
        self.rounding.serialize(tape);
        self.division.serialize(tape);
        self.pending.serialize(tape);
        self.solved.serialize(tape);
        let mut is_euler = self.scheme == Scheme::Euler;
        tape.flag(&mut is_euler);
        self.scheme = if is_euler { Scheme::Euler } else { Scheme::Sdirk };
        self.inputs.serialize(tape);
        tape.counter(&mut self.waiting);
        let [from, to] = &mut self.step;
        let times = [&mut self.clock, &mut self.reached, &mut self.solved_at, from, to];
        let shares = [&mut self.share, &mut self.rounded];
        for value in times.into_iter().chain(shares).chain(&mut self.energies) {
            tape.real(value);
        }
    }
}
