//! Own steps of a communication step, by error control or, in real time, of bounded work.

use super::outcome::StepError;
use super::real_time::RealTime;
use super::simulation::Simulation;
use super::tuning::{
    NEWTON_LIMITS, NEWTON_TOLERANCE, NEWTON_WIDENING, STEP_RESIDUALS, STEP_RESIDUALS_PER_SECOND,
};
use crate::archive::Archive;
use crate::pulley::PerPulley;
use crate::solver::newton::Counts;
use crate::solver::sdirk::Sdirk;
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::pulleys::rows::Stop;
use crate::variator::settings::{Inputs, Mode, Parameters, Work};

/// An ongoing communication step.
#[derive(Clone, Debug)]
pub struct CommunicationStep {
    /// Where it begins and ends, s.
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) is_over: bool,
    /// Until when loads and friction are smooth, s; none before the first own step under them.
    pub(super) smooth_until: Option<f64>,
    /// Inputs that were given last, and as functions of time.
    pub(super) given: Inputs,
    pub(super) profile: InputProfile,
    /// In the beginning: end stops that the sheaves were at, work until then.
    pub(super) stops: PerPulley<Option<Stop>>,
    pub(super) before: Counts,
}

/// Advances a simulation to the end of a communication step in own steps.
#[derive(Clone, Debug)]
pub(super) struct Stepper {
    pub(super) sdirk: Sdirk,
    pub(super) real_time: Option<RealTime>,
    /// Factor of the number of steps by a tolerance tighter than the default.
    shortening: f64,
}

impl Stepper {
    /// From the state and time of a simulation, in its mode; with error control this step is first,
    /// s.
    pub fn new(simulation: &Simulation, first_step: f64) -> Self {
        let solver = &simulation.system.parameters.solver;
        let mut sdirk = Sdirk::new(&simulation.system, first_step, solver.max_step);
        let fraction = solver.tolerance / Parameters::default().solver.tolerance;
        let [sharpest, widest] = NEWTON_LIMITS;
        sdirk.newton_tolerance = (NEWTON_TOLERANCE * fraction).clamp(sharpest, widest);
        sdirk.newton_widening = NEWTON_WIDENING * fraction.min(1.0);
        let real_time = (solver.mode == Mode::RealTime).then(|| RealTime::new(simulation, &mut sdirk));
        Self {
            sdirk,
            real_time,
            shortening: fraction.recip().cbrt().max(1.0),
        }
    }

    /// Begins a communication step to a time, s, with the inputs `given`, as functions of time
    /// `profile`.
    pub fn begin(
        &mut self,
        simulation: &Simulation,
        to: f64,
        given: &Inputs,
        profile: InputProfile,
    ) -> CommunicationStep {
        self.sdirk.newton.defect = 0.0;
        CommunicationStep {
            from: simulation.time,
            to,
            is_over: to - simulation.time < SHORTEST_STEP,
            smooth_until: None,
            given: *given,
            profile,
            stops: simulation.stops(),
            before: self.counts(),
        }
    }

    /// One own step of a communication step. In real time there is no error.
    pub fn step(&mut self, simulation: &mut Simulation, of: &mut CommunicationStep) -> Result<(), StepError> {
        let CommunicationStep { from, to, profile, .. } = *of;
        if let Some(real_time) = &mut self.real_time {
            real_time.advance(&mut self.sdirk, simulation, &profile, to);
            of.is_over = simulation.time == to;
            return Ok(());
        }
        let end = of.smooth_until.take().unwrap_or_else(|| {
            let mut end = to.min(simulation.time + simulation.friction_lasts());
            if profile.kink > simulation.time {
                end = end.min(profile.kink);
            }
            simulation.apply(profile);
            end
        });
        let mut time = simulation.time;
        let (mut problem, state) = simulation.problem();
        if let Err(stalled) = self.sdirk.step(&mut problem, state, &mut time, end) {
            return Err(StepError::Stalled {
                from,
                reached: stalled.time,
                reason: stalled.to_string(),
            });
        }
        simulation.time = time;
        if time < end {
            of.smooth_until = Some(end);
        } else if to - simulation.time < SHORTEST_STEP {
            simulation.time = to;
            of.is_over = true;
            return Ok(());
        }
        let residuals = (self.counts() - of.before).residuals;
        if residuals as f64 > self.shortening * (STEP_RESIDUALS + STEP_RESIDUALS_PER_SECOND * (to - from)) {
            return Err(StepError::Exhausted {
                from,
                to,
                reached: simulation.time,
                residuals,
            });
        }
        Ok(())
    }

    /// Work since the start, and remainders of the last communication step at a time, s.
    pub fn output(&self, time: f64) -> Work {
        let output = |count: u64| i32::try_from(count).unwrap_or(i32::MAX);
        let counts = self.counts();
        Work {
            steps: output(counts.steps + counts.rejected + counts.failed),
            jacobians: output(counts.factorizations),
            residuals: output(counts.residuals),
            defect: self.sdirk.newton.defect,
            behind: self.real_time.as_ref().map_or(0.0, |run| run.behind(time)),
            skipped: self.real_time.as_ref().map_or(0.0, |run| run.skipped),
            rollbacks: self.real_time.as_ref().map_or(0, |_| output(counts.rejected)),
        }
    }

    pub fn counts(&self) -> Counts {
        self.sdirk.newton.counts
    }

    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.sdirk.serialize(archive);
        if let Some(real_time) = &mut self.real_time {
            real_time.serialize(archive);
        }
    }
}
