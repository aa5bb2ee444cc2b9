//! How a simulation is advanced within a communication step: one trait, and the accurate integrator.

use std::fmt::Debug;

use crate::archive::Archive;
use crate::solver::newton::Counts;
use crate::solver::sdirk::{Sdirk, Stalled};
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::run::simulation::Simulation;
use crate::variator::run::tuning::{NEWTON_LIMITS, NEWTON_TOLERANCE, NEWTON_WIDENING, USUAL_TOLERANCE};
use crate::variator::settings::signals::Work;
use crate::variator::system::VariatorSystem;

/// Advances a simulation to the end of a communication step in own steps.
pub(super) trait Stepper: Debug + Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn Stepper>;

    /// Begins a communication step between two times, s.
    fn begin(&mut self, span: [f64; 2]);

    /// Takes note that the inputs, or the end of the communication step, have changed: from now to the end, s.
    fn restart(&mut self, span: [f64; 2]);

    /// One own step towards a time, s. Returns whether that time is reached.
    ///
    /// # Errors
    /// A step that can't be done.
    fn step(&mut self, simulation: &mut Simulation, profile: &InputProfile, to: f64) -> Result<bool, Stalled>;

    /// Ends a communication step at the simulation's time. Returns the work since the start, and what the step left.
    fn finish(&mut self, simulation: &mut Simulation, profile: &InputProfile) -> Work;

    /// Work since the start.
    fn counts(&self) -> Counts;

    /// ÿ of an unknown at the end of the last step, as far as it is known; else 0.
    fn slope_rate(&self, _unknown: usize) -> f64 {
        0.0
    }

    /// Starts again from the simulation's state, where a communication step began that can't be done: with the step size of then, without
    /// anything else from earlier steps. The counts remain. A stepper that can do each step needs nothing.
    fn start_again(&mut self, _simulation: &Simulation) {}

    /// Takes note that the laws have changed.
    fn change_laws(&mut self) {}

    /// Writes to an archive, or reads from it, all that later steps depend on beside the simulation.
    fn serialize(&mut self, archive: &mut Archive<'_>);
}

impl Clone for Box<dyn Stepper> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// Work as outputs, with a defect as a share of what accurate steps tolerate.
pub(super) fn work(counts: Counts, defect: f64) -> Work {
    let output = |count: u64| i32::try_from(count).unwrap_or(i32::MAX);
    Work {
        steps: output(counts.steps + counts.rejected + counts.failed),
        jacobians: output(counts.factorizations),
        residuals: output(counts.residuals),
        defect,
        behind: 0.0,
        rollbacks: 0,
    }
}

/// Steps as the error control requires.
#[derive(Clone, Debug)]
pub(super) struct Accurate {
    sdirk: Sdirk,
    /// End of the time over which loads change alike, s; none before the first step of it.
    end: Option<f64>,
    /// Preferred step where the communication step began, s.
    first_step: f64,
}

impl Accurate {
    pub fn new(system: &VariatorSystem, first_step: f64) -> Self {
        let solver = &system.parameters.solver;
        let mut sdirk = Sdirk::new(system, first_step, solver.max_step);
        let share = solver.tolerance / USUAL_TOLERANCE;
        let [sharpest, widest] = NEWTON_LIMITS;
        sdirk.newton_tolerance = (NEWTON_TOLERANCE * share).clamp(sharpest, widest);
        sdirk.newton_widening = NEWTON_WIDENING * share.min(1.0);
        Self {
            sdirk,
            end: None,
            first_step,
        }
    }
}

impl Stepper for Accurate {
    fn boxed(&self) -> Box<dyn Stepper> {
        Box::new(self.clone())
    }

    fn begin(&mut self, span: [f64; 2]) {
        self.sdirk.newton.left = 0.0;
        self.first_step = self.sdirk.step;
        self.restart(span);
    }

    fn restart(&mut self, _span: [f64; 2]) {
        self.end = None;
    }

    fn step(&mut self, simulation: &mut Simulation, profile: &InputProfile, to: f64) -> Result<bool, Stalled> {
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
        self.sdirk.step(&mut problem, state, &mut time, end)?;
        simulation.time = time;
        if time < end {
            self.end = Some(end);
            return Ok(false);
        }
        let is_over = to - simulation.time < SHORTEST_STEP;
        if is_over {
            simulation.time = to;
        }
        Ok(is_over)
    }

    fn finish(&mut self, _simulation: &mut Simulation, _profile: &InputProfile) -> Work {
        work(self.counts(), self.sdirk.newton.left)
    }

    fn counts(&self) -> Counts {
        self.sdirk.newton.counts
    }

    fn slope_rate(&self, unknown: usize) -> f64 {
        self.sdirk.slope_rate(unknown)
    }

    fn start_again(&mut self, simulation: &Simulation) {
        let counts = self.counts();
        *self = Self::new(&simulation.system, self.first_step);
        self.sdirk.newton.counts = counts;
    }

    fn change_laws(&mut self) {
        self.sdirk.newton.forget_rate();
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.sdirk.serialize(archive);
    }
}
