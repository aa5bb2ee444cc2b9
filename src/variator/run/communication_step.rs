//! A communication step in own steps: an importer can read outputs, change inputs or end the
//! communication step at the end of each. Else it is [`Variator::advance_along`] to the last bit.

use super::outcome::{Event, StepError, TimeError};
use super::stepper::CommunicationStep;
use super::tuning::REAL_TIME;
use super::variator::Variator;
use crate::pulley::Pulley;
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::settings::{Inputs, Mode};

/// Whole communication steps.
impl Variator {
    /// Advances to time `to` with inputs that are held, after the ramp of `inputs.ramp`.
    ///
    /// # Errors
    /// As [`Variator::advance_along`].
    pub fn advance(&mut self, to: f64, inputs: &Inputs) -> Result<(), StepError> {
        self.advance_along(to, inputs, &Inputs::ZERO)
    }

    /// Advances to time `to` with inputs that change linearly: `inputs` now, with the time
    /// derivatives `rates`. A clamping force that falls ends at zero. Less than a nanosecond is
    /// left to the next call.
    ///
    /// # Errors
    /// A time before the present one or out of its range, an input out of its range, a rate that is
    /// not finite, or a step that can't be done. The variator is then in the state of before.
    pub fn advance_along(&mut self, to: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        let mut step = CommunicationStep::begin(self, to, inputs, rates)?;
        while !step.is_over() {
            step.advance(self)?;
        }
        step.finish(self);
        Ok(())
    }
}

fn skipped_warning(time: f64) -> String {
    format!(
        "at {time} s the run is {} s behind the clock, and what is beyond is left out: speeds and ratio lack the effect of the loads over \
         that time, which solver.skipped adds up; a larger solver.effort, ring.model = ALE0 or smoother inputs avoid it",
        REAL_TIME.behind
    )
}

impl CommunicationStep {
    /// Begins a communication step to time `to` as [`Variator::advance_along`] does it:
    /// [`CommunicationStep::advance`] until it is over, then [`CommunicationStep::finish`].
    ///
    /// # Errors
    /// A time before the present one or out of its range, an input out of its range, or a rate that
    /// is not finite.
    pub fn begin(
        variator: &mut Variator,
        to: f64,
        inputs: &Inputs,
        rates: &Inputs,
    ) -> Result<Self, StepError> {
        TimeError::check(Some(variator.time()), to)?;
        inputs.validate()?;
        rates.validate_rates()?;
        variator.save();
        let simulation = &variator.simulation;
        let ramp = simulation.system.parameters.solver.input_ramp;
        let times = [simulation.time, to];
        let profile = InputProfile::new(ramp, times, &simulation.inputs(), inputs, rates);
        Ok(variator.stepper.begin(simulation, to, inputs, profile))
    }

    /// Whether its end is reached.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// One own step of a communication step that is not over.
    ///
    /// # Errors
    /// A step that can't be done. The variator is then in the state of before.
    pub fn advance(&mut self, variator: &mut Variator) -> Result<(), StepError> {
        variator.stale = true;
        let outcome = variator.stepper.step(&mut variator.simulation, self);
        if outcome.is_err() {
            self.discard(variator);
        }
        outcome
    }

    /// Abandons it: the variator is in the state of before, the work remains counted.
    pub fn discard(&self, variator: &mut Variator) {
        variator.roll_back();
        self.count_work(variator);
    }

    /// Changes inputs of a communication step that is not over: those that differ from the ones
    /// given before count at once.
    ///
    /// # Errors
    /// An input out of its range; nothing was changed.
    pub fn set_inputs(&mut self, inputs: &Inputs) -> Result<(), StepError> {
        if *inputs == self.given {
            return Ok(());
        }
        inputs.validate()?;
        self.profile.change(&self.given, inputs);
        self.given = *inputs;
        self.smooth_until = None;
        Ok(())
    }

    /// Moves its end to a time, s, or to the present one if that is past. It never becomes longer;
    /// a time that is not a number changes nothing.
    pub fn end_at(&mut self, variator: &Variator, time: f64) {
        if time.is_nan() || time >= self.to {
            return;
        }
        let now = variator.simulation.time;
        self.to = time.max(now);
        self.smooth_until = None;
        self.is_over |= self.to - now < SHORTEST_STEP;
    }

    /// The first event since it began, if there is one.
    #[must_use]
    pub fn event(&self, variator: &Variator) -> Option<Event> {
        let slips = variator.simulation.slips(variator.macro_slip);
        if slips != variator.macro_slip {
            return Some(Event::of_slip(slips));
        }
        let now = variator.simulation.stops();
        let reached = Pulley::BOTH.map(|pulley| (pulley, now[pulley], self.stops[pulley]));
        let mut reached = reached.into_iter().filter(|(_, now, before)| now != before);
        reached.find_map(|(pulley, now, _)| Some(Event::Reaches { pulley, stop: now? }))
    }

    /// Ends it at the time that it has reached.
    pub fn finish(&self, variator: &mut Variator) {
        let Variator {
            simulation, stepper, ..
        } = variator;
        if simulation.time == self.from {
            return;
        }
        if stepper.real_time.is_some() {
            simulation.restore(self.profile);
        }
        let before = std::mem::replace(&mut variator.work, stepper.output(simulation.time));
        if before.skipped == 0.0 && variator.work.skipped > 0.0 {
            simulation.log(true, skipped_warning(simulation.time));
        }
        self.count_work(variator);
        variator.report_slip();
        variator.warn(false);
        variator.stale = true;
    }

    /// Counts its work, and warns of too much of it. In real time it is bounded.
    fn count_work(&self, variator: &mut Variator) {
        if variator.parameters().solver.mode == Mode::RealTime {
            return;
        }
        let simulated = variator.time() - self.from;
        let (work, unknowns) = (variator.counts() - self.before, variator.state().y.len());
        let remark = variator.pace.count(&self.given, simulated, work, unknowns);
        remark.into_iter().for_each(|text| variator.simulation.log(true, text));
    }
}
