//! Communication steps as sequences of internal steps of the unit, and the status of the last one.

use super::error::{CallError, Outcome, refused};
use super::instance::{Environment, IntermediateUpdate, Slave, StepInProgress};
use crate::log::{Category, Status};
use crate::state::{Call, State};
use crate::unit::{StepFailure, Unit};

/// What comes next in a communication step.
#[derive(Clone, Copy, Debug)]
pub enum Next {
    /// An internal step of the unit.
    Advance,
    /// The callback of the master, in intermediate update mode.
    Update(Update),
    /// The communication step has ended.
    Ended(Ended),
}

/// The callback of the master and its arguments.
#[derive(Clone, Copy, Debug)]
pub struct Update {
    /// The importer's function.
    pub function: IntermediateUpdate,
    /// Its environment.
    pub environment: Environment,
    /// Time of the unit, s.
    pub time: f64,
    /// Whether inputs may be set.
    pub inputs_may_be_set: bool,
    /// Whether the communication step may end early.
    pub can_return_early: bool,
}

/// How a communication step ended.
#[derive(Clone, Copy, Debug)]
pub struct Ended {
    /// Whether an event has happened.
    pub event: bool,
    /// Whether it ended before the end that the master had set.
    pub early: bool,
    /// Time reached, s.
    pub time: f64,
}

impl Ended {
    /// Without an event, at a time, s, that was not early.
    #[must_use]
    pub fn at(time: f64) -> Self {
        Self {
            event: false,
            early: false,
            time,
        }
    }
}

impl<U: Unit> Slave<U> {
    /// A whole communication step of size `step` from `current`, s, for a master without callback.
    pub fn do_step(&mut self, current: f64, step: f64) -> Outcome {
        let mut next = self.begin_step(current, step)?;
        while let Next::Advance = next {
            next = self.advance_step()?;
        }
        Ok(())
    }

    /// Begins a communication step of size `step` from `current`, s.
    pub fn begin_step(&mut self, current: f64, step: f64) -> Result<Next, CallError> {
        self.allow(Call::DoStep)?;
        let now = &mut self.now;
        let end = now
            .clock
            .after(current, step, U::IDENTITY.longest_step, now.experiment.stop)?;
        let unit = started(&mut now.unit)?;
        if !end.is_after(unit.time()) {
            // Rounding alone: the unit stays where it is, and the next step makes up for the difference.
            (now.clock, now.rates, now.state) = (end, None, State::StepComplete);
            return Ok(Next::Ended(Ended::at(end.point)));
        }
        // A longer previous step may have ended on a coarser grid, just ahead of this time.
        let to = end.on_grid(step).max(unit.time());
        let step = match unit.begin(to, &now.settings, now.rates.as_ref()) {
            Ok(step) => step,
            Err(failure) => return self.fail_step(failure),
        };
        let over = unit.is_over(&step);
        let step = StepInProgress {
            step,
            rates: now.rates.take(),
            end,
            shortened: false,
        };
        if over {
            return self.finish_step(&step, None);
        }
        self.step = Some(step);
        Ok(Next::Advance)
    }

    /// One internal step of the unit.
    pub fn advance_step(&mut self) -> Result<Next, CallError> {
        let Some(mut step) = self.step.take() else {
            return refused("no communication step is in progress");
        };
        let mut remarks = Vec::new();
        let unit = started(&mut self.now.unit)?;
        let advanced = unit.advance(&mut step.step, &self.now.settings, &mut remarks);
        self.log_remarks(&remarks);
        if let Err(failure) = advanced {
            self.now.rates = step.rates;
            return self.fail_step(failure);
        }
        let Some((function, environment)) = self.master.update else {
            return self.after_internal_step(step);
        };
        let unit = started(&mut self.now.unit)?;
        let over = unit.is_over(&step.step);
        let time = self.now.clock.of_master(unit.time());
        self.step = Some(step);
        self.now.state = State::IntermediateUpdate;
        Ok(Next::Update(Update {
            function,
            environment,
            time,
            inputs_may_be_set: self.master.sets_inputs && !over,
            can_return_early: self.master.early_return && !over,
        }))
    }

    /// Continues after the master's callback, which may request that the step ends at a time, s.
    pub fn resume_step(&mut self, until: Option<f64>) -> Result<Next, CallError> {
        let step = self.step.take();
        let (State::IntermediateUpdate, Some(mut step)) = (self.now.state, step) else {
            return refused("a call within the intermediate update failed");
        };
        self.now.state = State::StepComplete;
        if let Some(until) = until {
            let until = self.now.clock.of_unit(until);
            self.end_step_at(&mut step, until)?;
        }
        self.after_internal_step(step)
    }

    /// Whether a communication step in progress has reached its end.
    pub(super) fn step_is_over(&self) -> bool {
        let unit = self.now.unit.as_ref().zip(self.step.as_ref());
        unit.is_some_and(|(unit, step)| unit.is_over(&step.step))
    }

    /// Ends the communication step at its end or at an event.
    fn after_internal_step(&mut self, mut step: StepInProgress<U>) -> Result<Next, CallError> {
        let unit = started(&mut self.now.unit)?;
        let (over, time) = (unit.is_over(&step.step), unit.time());
        let watched = self.master.events && (over || self.master.early_return);
        let event = watched.then(|| unit.event(&step.step)).flatten();
        if !over && event.is_none() {
            self.step = Some(step);
            return Ok(Next::Advance);
        }
        self.end_step_at(&mut step, time)?;
        self.finish_step(&step, event)
    }

    /// Shortens a communication step so that it ends at a time of the unit, s, or at the present time if that is later.
    fn end_step_at(&mut self, step: &mut StepInProgress<U>, time: f64) -> Outcome {
        let unit = started(&mut self.now.unit)?;
        if !unit.is_over(&step.step) && time < step.end.elapsed {
            unit.end_at(&mut step.step, time);
            step.shortened = true;
        }
        Ok(())
    }

    fn finish_step(&mut self, step: &StepInProgress<U>, event: Option<String>) -> Result<Next, CallError> {
        let mut remarks = Vec::new();
        let unit = started(&mut self.now.unit)?;
        unit.finish(&step.step, &mut remarks);
        let clock = match step.shortened {
            true => self.now.clock.back_at(unit.time()),
            false => step.end,
        };
        let time = clock.point;
        self.log_remarks(&remarks);
        if let Some(event) = &event {
            let text = format!("event at {time} s: {event}");
            self.log.send(Status::Ok, Category::Events, &text);
        }
        (self.now.state, self.now.clock) = (State::StepComplete, clock);
        Ok(Next::Ended(Ended {
            event: event.is_some(),
            early: step.shortened,
            time,
        }))
    }

    /// Ends a communication step that was not completed: all is as before, and the next step begins where this one did.
    fn fail_step(&mut self, failure: StepFailure) -> Result<Next, CallError> {
        self.now.state = State::StepFailed;
        Err(CallError::Discarded(self.with_start(&failure.to_string()).into_owned()))
    }
}

/// How the last step ended, in FMI 2.0.
impl<U: Unit> Slave<U> {
    /// Writes the status to `place`, if its `kind` is the `known` one: of the numbers of `fmi2StatusKind`, from 0 to 3, the one that has a
    /// value of this type.
    pub fn status<T>(&self, kind: i32, known: i32, place: &mut T, value: impl FnOnce(&Self) -> T) -> Outcome {
        if !(0..=3).contains(&kind) {
            return refused(format!("the kind of status {kind} is not one of the standard's"));
        }
        self.allow(Call::GetStatus)?;
        if kind != known {
            return Err(CallError::Discarded(format!(
                "there is no status of the kind {kind} in this type: each step is complete when fmi2DoStep returns"
            )));
        }
        *place = value(self);
        Ok(())
    }

    /// How the last step ended.
    #[must_use]
    pub fn step_status(&self) -> Status {
        match self.now.state {
            State::StepFailed => Status::Discard,
            _ => Status::Ok,
        }
    }
}

/// The unit, once it has been started.
fn started<U>(unit: &mut Option<U>) -> Result<&mut U, CallError> {
    match unit {
        Some(unit) => Ok(unit),
        None => refused("the unit is not initialised"),
    }
}
