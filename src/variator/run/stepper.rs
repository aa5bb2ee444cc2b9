//! How a simulation is advanced within a communication step: in steps as the error control requires or, in real time, of bounded work.

use crate::archive::Archive;
use crate::solver::newton::Counts;
use crate::solver::sdirk::Sdirk;
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::run::outcome::StepError;
use crate::variator::run::real_time::RealTime;
use crate::variator::run::simulation::Simulation;
use crate::variator::run::tuning::{
    NEWTON_LIMITS, NEWTON_TOLERANCE, NEWTON_WIDENING, STEP_RESIDUALS, STEP_RESIDUALS_PER_SECOND,
};
use crate::variator::settings::parameters::Parameters;
use crate::variator::settings::signals::Work;

/// Advances a simulation to the end of a communication step in own steps.
#[derive(Clone, Debug)]
pub(super) struct Stepper {
    sdirk: Sdirk,
    pub(super) real_time: Option<RealTime>,
    /// End of the time over which loads change alike, s; none before the first step of it.
    end: Option<f64>,
    /// How many times more steps a tolerance tighter than the default takes.
    shortening: f64,
    /// Where the communication step began: time, s, work until then, preferred step, s.
    from: f64,
    before: Counts,
    first_step: f64,
}

impl Stepper {
    /// Steps as the error control requires.
    pub fn accurate(simulation: &Simulation, first_step: f64) -> Self {
        let solver = &simulation.system.parameters.solver;
        let mut sdirk = Sdirk::new(&simulation.system, first_step, solver.max_step);
        let share = solver.tolerance / Parameters::default().solver.tolerance;
        let [sharpest, widest] = NEWTON_LIMITS;
        sdirk.newton_tolerance = (NEWTON_TOLERANCE * share).clamp(sharpest, widest);
        sdirk.newton_widening = NEWTON_WIDENING * share.min(1.0);
        Self {
            sdirk,
            real_time: None,
            end: None,
            shortening: share.recip().cbrt().max(1.0),
            from: simulation.time,
            before: Counts::default(),
            first_step,
        }
    }

    /// Steps of one length with bounded work.
    pub fn in_real_time(simulation: &Simulation) -> Self {
        let mut stepper = Self::accurate(simulation, 0.0);
        stepper.real_time = Some(RealTime::new(simulation, &mut stepper.sdirk));
        stepper
    }

    /// Begins a communication step at a time, s.
    pub fn begin(&mut self, from: f64) {
        (self.from, self.before, self.first_step) = (from, self.counts(), self.sdirk.step);
        self.sdirk.newton.left = 0.0;
        self.restart();
    }

    /// Takes note that the inputs, or the end of the communication step, have changed.
    pub fn restart(&mut self) {
        self.end = None;
    }

    /// One own step towards a time, s. Returns whether that time is reached.
    ///
    /// # Errors
    /// A step that can't be done, or takes more work than it may. In real time each can be done.
    pub fn step(&mut self, simulation: &mut Simulation, profile: &InputProfile, to: f64) -> Result<bool, StepError> {
        if let Some(real_time) = &mut self.real_time {
            real_time.advance(&mut self.sdirk, simulation, profile, to);
            return Ok(simulation.time == to);
        }
        let end = self.end.take().unwrap_or_else(|| {
            let mut end = to.min(simulation.time + simulation.soft_start.piece(simulation.time));
            if profile.kink > simulation.time {
                end = end.min(profile.kink);
            }
            simulation.apply(*profile);
            end
        });
        let mut time = simulation.time;
        let (mut problem, state) = simulation.problem();
        if let Err(stalled) = self.sdirk.step(&mut problem, state, &mut time, end) {
            return Err(StepError::Stalled {
                from: self.from,
                reached: stalled.time,
                reason: stalled.to_string(),
            });
        }
        simulation.time = time;
        if time < end {
            self.end = Some(end);
        } else if to - simulation.time < SHORTEST_STEP {
            simulation.time = to;
            return Ok(true);
        }
        let residuals = self.work().residuals;
        if residuals as f64 > self.shortening * (STEP_RESIDUALS + STEP_RESIDUALS_PER_SECOND * (to - self.from)) {
            return Err(StepError::Exhausted {
                from: self.from,
                to,
                reached: simulation.time,
                residuals,
            });
        }
        Ok(false)
    }

    /// Ends a communication step at the simulation's time. Returns the work since the start, and what the step left.
    pub fn finish(&mut self, simulation: &mut Simulation, profile: &InputProfile) -> Work {
        let output = |count: u64| i32::try_from(count).unwrap_or(i32::MAX);
        let counts = self.counts();
        let work = Work {
            steps: output(counts.steps + counts.rejected + counts.failed),
            jacobians: output(counts.factorizations),
            residuals: output(counts.residuals),
            defect: self.sdirk.newton.left,
            behind: 0.0,
            rollbacks: 0,
        };
        let Some(real_time) = &self.real_time else {
            return work;
        };
        simulation.restore(*profile);
        Work {
            behind: real_time.behind(simulation.time),
            rollbacks: output(counts.rejected),
            ..work
        }
    }

    /// Time at which the communication step began, s.
    pub fn from(&self) -> f64 {
        self.from
    }

    /// Work since the start.
    pub fn counts(&self) -> Counts {
        self.sdirk.newton.counts
    }

    /// Work of the communication step.
    pub fn work(&self) -> Counts {
        self.counts() - self.before
    }

    /// ÿ of an unknown at the end of the last step, as far as it is known; else 0.
    pub fn slope_rate(&self, unknown: usize) -> f64 {
        self.sdirk.slope_rate(unknown)
    }

    /// Starts again from the simulation's state, where a communication step began that can't be done: with the step size of then, without
    /// anything else from earlier steps. The counts remain.
    pub fn start_again(&mut self, simulation: &Simulation) {
        let (counts, before) = (self.counts(), self.before);
        *self = Self::accurate(simulation, self.first_step);
        (self.sdirk.newton.counts, self.before) = (counts, before);
    }

    /// Takes note that the laws have changed.
    pub fn change_laws(&mut self) {
        self.sdirk.newton.forget_rate();
    }

    /// Writes to an archive, or reads from it, all that later steps depend on beside the simulation.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.sdirk.serialize(archive);
        if let Some(real_time) = &mut self.real_time {
            real_time.serialize(archive);
        }
    }
}
