//! A communication step in own steps: a master can read outputs at the end of each, change inputs there or end the communication step.
//! Left alone, it is [`Variator::advance_along`] to the last bit.

use crate::pulley::{PerPulley, Pulley};
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::pulleys::rows::Stop;
use crate::variator::run::outcome::{Event, StepError};
use crate::variator::run::variator::Variator;
use crate::variator::settings::parameters::Mode;
use crate::variator::settings::signals::Inputs;

/// An ongoing communication step.
#[derive(Clone, Debug)]
pub struct CommunicationStep {
    /// Where it ends, s.
    to: f64,
    /// Inputs that were given last, and how they come into force.
    given: Inputs,
    profile: InputProfile,
    /// End stops that the sheaves were at in the beginning.
    stops: PerPulley<Option<Stop>>,
    is_over: bool,
}

/// Whole communication steps.
impl Variator {
    /// Advances to time `to` with inputs that are held, after the ramp of `inputs.ramp`.
    ///
    /// # Errors
    /// Inputs out of range, or a step that can't be done. The variator is then in the state of before.
    pub fn advance(&mut self, to: f64, inputs: &Inputs) -> Result<(), StepError> {
        self.advance_along(to, inputs, &Inputs::ZERO)
    }

    /// Advances to time `to` with inputs that change in proportion to time: `inputs` now, with the time derivatives
    /// `rates`. A clamping force that falls ends at zero. Less than a nanosecond is left to the next call.
    ///
    /// # Errors
    /// Inputs out of range, or a step that can't be done. The variator is then in the state of before.
    pub fn advance_along(&mut self, to: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        let mut step = CommunicationStep::begin(self, to, inputs, rates)?;
        while !step.is_over() {
            step.advance(self)?;
        }
        step.finish(self);
        Ok(())
    }
}

impl CommunicationStep {
    /// Begins a communication step to time `to` as [`Variator::advance_along`] does it: [`CommunicationStep::advance`] until it
    /// is over, then [`CommunicationStep::finish`].
    ///
    /// # Errors
    /// Inputs out of range.
    pub fn begin(variator: &mut Variator, to: f64, inputs: &Inputs, rates: &Inputs) -> Result<Self, StepError> {
        inputs.validate()?;
        variator.save();
        let simulation = &variator.simulation;
        let from = simulation.time;
        let ramp = simulation.system.parameters.solver.input_ramp;
        let profile = InputProfile::new(ramp, [from, to], &simulation.inputs(), inputs, rates);
        let stops = simulation.stops();
        variator.stepper.begin(from);
        Ok(Self {
            to,
            given: *inputs,
            profile,
            stops,
            is_over: to - from < SHORTEST_STEP,
        })
    }

    /// Whether its end is reached.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// One own step of a communication step that is not over.
    ///
    /// # Errors
    /// The communication step can't be done: the variator is in the state of before.
    pub fn advance(&mut self, variator: &mut Variator) -> Result<(), StepError> {
        variator.stale = true;
        match variator.stepper.step(&mut variator.simulation, &self.profile, self.to) {
            Ok(is_over) => {
                self.is_over = is_over;
                Ok(())
            }
            Err(error) => {
                variator.roll_back();
                self.count_work(variator);
                Err(error)
            }
        }
    }

    /// Changes inputs of a communication step that is not over: those that differ from what was given before count at once.
    ///
    /// # Errors
    /// Inputs out of range; nothing was changed.
    pub fn set_inputs(&mut self, variator: &mut Variator, inputs: &Inputs) -> Result<(), StepError> {
        if *inputs == self.given {
            return Ok(());
        }
        inputs.validate()?;
        self.profile.change(&self.given, inputs);
        self.given = *inputs;
        variator.stepper.restart();
        Ok(())
    }

    /// Moves its end to a time, s, or to where it is if that is past. It never becomes longer.
    pub fn end_at(&mut self, variator: &mut Variator, time: f64) {
        if time >= self.to {
            return;
        }
        let now = variator.simulation.time;
        self.to = time.max(now);
        variator.stepper.restart();
        self.is_over |= self.to - now < SHORTEST_STEP;
    }

    /// What has happened since it began, the first of what there is.
    #[must_use]
    pub fn event(&self, variator: &Variator) -> Option<Event> {
        let slips = variator.simulation.slips(variator.macro_slip);
        if slips != variator.macro_slip {
            return Some(Event::of_slip(slips));
        }
        let now = variator.simulation.stops();
        let reached = Pulley::BOTH.map(|pulley| (pulley, now[pulley], self.stops[pulley]));
        let mut reached = reached.into_iter().filter(|(_, now, before)| now != before);
        reached.find_map(|(pulley, now, _)| Some(Event::Reaches(pulley, now?)))
    }

    /// Ends it at the time that it has reached.
    pub fn finish(&self, variator: &mut Variator) {
        if variator.simulation.time == variator.stepper.from() {
            return;
        }
        self.count_work(variator);
        variator.work = variator.stepper.finish(&mut variator.simulation, &self.profile);
        variator.report_slip();
        variator.report_buckling();
        variator.warn_of_loads(false);
        variator.stale = true;
    }

    /// Counts its work so far, and warns where that is too much. In real time it is bounded.
    fn count_work(&self, variator: &mut Variator) {
        if variator.parameters().solver.mode == Mode::RealTime {
            return;
        }
        let simulated = variator.time() - variator.stepper.from();
        let (work, unknowns) = (variator.stepper.work(), variator.state().y.len());
        let remark = variator.pace.count(&self.given, simulated, work, unknowns);
        remark.into_iter().for_each(|text| variator.simulation.log(true, text));
    }
}
