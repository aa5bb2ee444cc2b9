//! Real time: the accurate integrator with a bound on the work of each millisecond ([`RealTimeTuning`]), in short steps of one length.
//!
//! A step for which the work does not last stays open and continues in the next millisecond: the run is then behind the clock, and its
//! inputs wait ([`PendingInputs`]). Work that is not needed makes up for it later. A step that has no solution is begun again with half the length.

use crate::archive::Archive;
use crate::solver::newton::{Counts, Unsolved, WorkBound};
use crate::solver::sdirk::{Sdirk, Stalled};
use crate::variator::pulleys::loads::LinearInputs;
use crate::variator::run::inputs::{InputProfile, PendingInputs, SHORTEST_STEP};
use crate::variator::run::plant::Plant;
use crate::variator::run::stepper::{Stepper, work};
use crate::variator::settings::signals::Work;

/// The millisecond of the clock, s, whose work is bounded.
const MILLISECOND: f64 = 1.0e-3;

/// What real time is tuned with. Work is in units of a residual with its correction.
struct RealTimeTuning {
    /// Work of a millisecond for each `solver.effort`, units: as much as a Jacobian and eight residuals took in earlier versions.
    effort: f64,
    /// Work that is left over from a millisecond and that the next one may use, units: the mean is then nearer to the bound.
    carried: f64,
    /// What an iteration that has begun may take beyond the bound, units. The next millisecond has less.
    overdraft: f64,
    /// Work of a Jacobian with its factors, units: with reused geometry (measured 5.3 to 5.7), and what all geometry takes beside
    /// (11 with `ALE`, 17 with `ALE0`).
    jacobian: [f64; 2],
    /// Jacobians in a stage after which its step is begun again: what they do not solve, more of them rarely do.
    jacobians: usize,
    /// Length of steps, s. Longer ones take more Jacobians under flips and hunting; with 0.125 ms smooth loads take half as much work again.
    step: f64,
    /// Share of that length of the shortest steps. Each one that has no solution halves the length, each solved one doubles it.
    shortest: f64,
    /// Newton's tolerance, in units of the Newton scale, in smooth motion: with 40 the ratio drifts under ripple. And how many times wider
    /// it is while the run is behind the clock, which saves a tenth of the work.
    tolerance: f64,
    widening: f64,
    /// Longest time behind the clock, s. What is beyond it is left out: a controller can't use older outputs.
    behind: f64,
}

const TUNING: RealTimeTuning = RealTimeTuning {
    effort: 15.5,
    carried: 16.0,
    overdraft: 12.0,
    jacobian: [6.0, 14.0],
    jacobians: 6,
    step: 0.2e-3,
    shortest: 1.0 / 32.0,
    tolerance: 10.0,
    widening: 8.0,
    behind: 0.02,
};

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
    /// Length of steps as a share of [`RealTimeTuning::step`], and that of the open step, s, if one is.
    share: f64,
    open: Option<f64>,
    /// Inputs of the present step.
    inputs: LinearInputs,
}

impl RealTime {
    /// A run that begins with the state and at the time of a plant.
    pub fn new(plant: &Plant) -> Self {
        let mut sdirk = Sdirk::new(&plant.system, TUNING.step, TUNING.step);
        sdirk.newton_tolerance = TUNING.tolerance;
        sdirk.newton.bound = WorkBound {
            left: 0.0,
            jacobian: TUNING.jacobian,
            overdraft: TUNING.overdraft,
            jacobians: TUNING.jacobians,
        };
        Self {
            sdirk,
            span: [plant.time; 2],
            parts: 0.0,
            over: 0.0,
            clock: plant.time,
            reached: plant.time,
            pending: PendingInputs::new(),
            share: 1.0,
            open: None,
            inputs: LinearInputs::constant(plant.time, &plant.inputs()),
        }
    }

    /// Advances the clock, s, and the state as far as the work lasts.
    fn advance_clock(&mut self, plant: &mut Plant, profile: &InputProfile, [from, to]: [f64; 2]) {
        self.pending.add(profile, [from, to]);
        self.clock = to;
        let effort = f64::from(plant.system.parameters.solver.effort);
        let left = &mut self.sdirk.newton.bound.left;
        *left = left.min(TUNING.carried) + effort * TUNING.effort * ((to - from) / MILLISECOND);
        plant.time = self.reached;
        plant.restore(self.inputs);
        let wider = if self.open.is_some() { TUNING.widening } else { 1.0 };
        self.sdirk.newton_tolerance = wider * TUNING.tolerance;
        while self.behind() > SHORTEST_STEP && self.step(plant) {}
        let skipped = self.behind() - TUNING.behind;
        if skipped > 0.0 {
            // An open step moves in time with its inputs: it continues.
            self.pending.level(self.reached);
            self.reached += skipped;
            self.inputs.from += skipped;
            self.pending.forget(self.reached);
        }
        plant.time = to;
    }

    /// Takes or continues a step. False if the work is used up.
    fn step(&mut self, plant: &mut Plant) -> bool {
        let length = self.open.unwrap_or_else(|| self.begin_step(plant));
        let (mut running, state) = plant.running();
        match self.sdirk.fixed_step(&mut running, state, self.reached, length) {
            Ok(()) => {
                let rest = self.behind() - length;
                self.reached = if rest < SHORTEST_STEP {
                    self.clock
                } else {
                    self.reached + length
                };
                plant.time = self.reached;
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
                self.share = (0.5 * self.share).max(TUNING.shortest);
                self.open = None;
            }
        }
        true
    }

    /// Brings the inputs of the next step into force: a straight line, so no impulse is lost. Returns its length, s: steps until the clock's
    /// time are alike.
    fn begin_step(&mut self, plant: &mut Plant) -> f64 {
        let rest = self.behind();
        let count = (rest / (self.share * TUNING.step) - SHORTEST_STEP).ceil().max(1.0);
        let length = rest / count;
        self.inputs = self.pending.line([self.reached, self.reached + length]);
        plant.apply(self.inputs);
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
    fn step(&mut self, plant: &mut Plant, profile: &InputProfile, to: f64) -> Result<bool, Stalled> {
        self.over += 1.0;
        let is_over = self.over >= self.parts;
        let [from, end] = self.span;
        let until = if is_over {
            to
        } else {
            from + self.over * ((end - from) / self.parts)
        };
        self.advance_clock(plant, profile, [plant.time, until]);
        Ok(is_over)
    }

    fn finish(&mut self, plant: &mut Plant, profile: &InputProfile) -> Work {
        plant.restore(profile.segment(plant.time));
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
        archive.within(&mut self.share, TUNING.shortest, 1.0);
        archive.option(&mut self.open);
    }
}
