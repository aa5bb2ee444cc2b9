//! Real time: the accurate integrator with a bound on the work of each millisecond ([`REAL_TIME`]), in short steps of one length.
//!
//! A step for which the work does not last stays open and continues in the next millisecond: the run is then behind the clock, and its
//! inputs wait ([`PendingInputs`]). Work that is not needed makes up for it later. A step that has no solution is begun again with half the length.

use crate::archive::Archive;
use crate::solver::newton::{Counts, Unsolved, WorkBound};
use crate::solver::sdirk::{Sdirk, Stalled};
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::run::pending_inputs::PendingInputs;
use crate::variator::run::simulation::Simulation;
use crate::variator::run::stepper::{Stepper, work};
use crate::variator::run::tuning::REAL_TIME;
use crate::variator::settings::signals::Work;

/// The millisecond of the clock, s, whose work is bounded.
const MILLISECOND: f64 = 1.0e-3;

/// A run in real time.
#[derive(Clone, Debug)]
pub(super) struct RealTime {
    sdirk: Sdirk,
    /// The communication step, s, its number of milliseconds or shorter parts, and how many of them are over.
    span: [f64; 2],
    parts: f64,
    over: f64,
    /// Time of the clock and of the state, s, and the inputs between them.
    clock: f64,
    reached: f64,
    pending: PendingInputs,
    /// Length of steps as a share of its longest, and that of the open step, s, if one is.
    share: f64,
    open: Option<f64>,
    /// Inputs of the present step.
    inputs: InputProfile,
}

impl RealTime {
    /// A run that begins with the state and at the time of a simulation.
    pub fn new(simulation: &Simulation) -> Self {
        let mut sdirk = Sdirk::new(&simulation.system, REAL_TIME.step, REAL_TIME.step);
        sdirk.newton_tolerance = REAL_TIME.tolerance;
        sdirk.newton.bound = WorkBound {
            left: 0.0,
            jacobian: REAL_TIME.jacobian,
            overdraft: REAL_TIME.spare,
            jacobians: REAL_TIME.jacobians,
        };
        Self {
            sdirk,
            span: [simulation.time; 2],
            parts: 0.0,
            over: 0.0,
            clock: simulation.time,
            reached: simulation.time,
            pending: PendingInputs::new(),
            share: 1.0,
            open: None,
            inputs: InputProfile::constant(&simulation.inputs()),
        }
    }

    /// Advances the clock, s, and the state as far as the work lasts.
    fn advance_clock(&mut self, simulation: &mut Simulation, profile: &InputProfile, [from, to]: [f64; 2]) {
        self.pending.add(profile, [from, to]);
        self.clock = to;
        let effort = f64::from(simulation.system.parameters.solver.effort);
        let left = &mut self.sdirk.newton.bound.left;
        *left = left.min(REAL_TIME.spare) + effort * REAL_TIME.effort * ((to - from) / MILLISECOND);
        simulation.time = self.reached;
        simulation.restore(self.inputs);
        let wider = if self.open.is_some() { REAL_TIME.widening } else { 1.0 };
        self.sdirk.newton_tolerance = wider * REAL_TIME.tolerance;
        while self.behind() > SHORTEST_STEP && self.step(simulation) {}
        let skipped = self.behind() - REAL_TIME.behind;
        if skipped > 0.0 {
            // An open step moves in time with its inputs: it continues.
            self.pending.level(self.reached);
            self.reached += skipped;
            self.inputs.kink += skipped;
            self.pending.forget(self.reached);
        }
        simulation.time = to;
    }

    /// Takes or continues a step. False if the work is used up.
    fn step(&mut self, simulation: &mut Simulation) -> bool {
        let length = self.open.unwrap_or_else(|| self.begin_step(simulation));
        let (mut problem, state) = simulation.problem();
        match self.sdirk.fixed_step(&mut problem, state, self.reached, length) {
            Ok(()) => {
                let rest = self.behind() - length;
                self.reached = if rest < SHORTEST_STEP {
                    self.clock
                } else {
                    self.reached + length
                };
                simulation.time = self.reached;
                self.pending.forget(self.reached);
                self.share = (2.0 * self.share).min(1.0);
                self.open = None;
            }
            Err(Unsolved::OutOfWork) => {
                self.open = Some(length);
                return false;
            }
            Err(Unsolved::NoSolution) => {
                self.sdirk.newton.counts.rejected += 1;
                self.share = (0.5 * self.share).max(REAL_TIME.shortest);
                self.open = None;
            }
        }
        true
    }

    /// Brings the inputs of the next step into force: a straight line, so no impulse is lost. Returns its length, s: steps until the clock's
    /// time are alike.
    fn begin_step(&mut self, simulation: &mut Simulation) -> f64 {
        let rest = self.behind();
        let count = (rest / (self.share * REAL_TIME.step) - SHORTEST_STEP).ceil().max(1.0);
        let length = rest / count;
        self.inputs = self.pending.line([self.reached, self.reached + length]);
        simulation.apply(self.inputs);
        length
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
        self.parts = ((to - from) / MILLISECOND - SHORTEST_STEP).ceil().max(1.0);
        self.over = 0.0;
        self.sdirk.newton.left = 0.0;
    }

    fn restart(&mut self, span: [f64; 2]) {
        if span[1] != self.span[1] {
            self.begin(span);
        }
    }

    /// The work of one millisecond.
    fn step(&mut self, simulation: &mut Simulation, profile: &InputProfile, to: f64) -> Result<bool, Stalled> {
        self.over += 1.0;
        let is_over = self.over >= self.parts;
        let [from, end] = self.span;
        let until = if is_over {
            to
        } else {
            from + self.over * ((end - from) / self.parts)
        };
        self.advance_clock(simulation, profile, [simulation.time, until]);
        Ok(is_over)
    }

    fn finish(&mut self, simulation: &mut Simulation, profile: &InputProfile) -> Work {
        simulation.restore(*profile);
        let counts = self.counts();
        Work {
            behind: self.behind(),
            rollbacks: i32::try_from(counts.rejected).unwrap_or(i32::MAX),
            ..work(counts, self.sdirk.newton.left)
        }
    }

    fn counts(&self) -> Counts {
        self.sdirk.newton.counts
    }

    fn change_laws(&mut self) {
        self.sdirk.newton.forget_rate();
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.sdirk.serialize(archive);
        self.pending.serialize(archive);
        self.inputs.serialize(archive);
        archive.real(&mut self.clock);
        archive.real(&mut self.reached);
        archive.within(&mut self.share, REAL_TIME.shortest, 1.0);
        archive.option(&mut self.open);
    }
}
