//! Communication steps as sequences of internal steps of the unit, and the status of the last one.

use std::mem::MaybeUninit;

use super::calls::{Callback, FmuInstance, StepInProgress};
use super::{CallError, Outcome, refused};
use crate::log::{Category, Status};
use crate::state::{Call, State};
use crate::unit::Unit;

/// How a communication step goes on.
pub enum Next {
    /// The importer is called back, in intermediate update mode.
    Update(Update),
    Ended(Ended),
}

/// The callback of the importer and its arguments.
pub struct Update {
    pub callback: Callback,
    /// Time of the unit, s.
    pub time: f64,
    pub inputs_may_be_set: bool,
    pub can_return_early: bool,
}

/// How a communication step ended: whether by an event, whether before the end that the importer
/// had set, and at which time, s.
pub struct Ended {
    pub event: bool,
    pub early: bool,
    pub time: f64,
}

impl Ended {
    /// Neither early nor by an event, at a time, s.
    pub fn completed_at(time: f64) -> Self {
        Self {
            event: false,
            early: false,
            time,
        }
    }
}

impl<U: Unit> FmuInstance<U> {
    /// Begins a communication step of size `step` from `current`, s, and goes on until its end, or
    /// until the importer is to be called back.
    ///
    /// # Errors
    /// The step does not begin at the communication point, is not forward or too long, or ends
    /// after the stop time; or the unit can't do it, and it is discarded.
    pub fn begin_step(&mut self, current: f64, step: f64) -> Result<Next, CallError> {
        self.allow(Call::DoStep)?;
        let now = &mut self.now;
        let end = now
            .clock
            .after(current, step, U::IDENTITY.longest_step, now.experiment.stop)?;
        let Some(unit) = &mut now.unit else {
            return refused("the unit is not initialised");
        };
        if !end.is_after(unit.time()) {
            // Rounding alone: the unit stays where it is, and the next step makes up for the
            // difference.
            (now.clock, now.rates, now.state) = (end, None, State::StepComplete);
            return Ok(Next::Ended(Ended::completed_at(end.point)));
        }
        // A longer previous step may have ended on a coarser grid, just ahead of this time.
        let to = end.on_grid(step).max(unit.time());
        let step = match unit.begin(to, &now.settings, now.rates.as_ref()) {
            Ok(step) => step,
            Err(text) => return self.fail_step(&text),
        };
        self.step = Some(StepInProgress {
            step,
            to,
            rates: now.rates.take(),
            end,
            shortened: false,
        });
        self.go_on(false)
    }

    /// Goes on after the importer's callback, which may request that the step ends at a time, s.
    ///
    /// # Errors
    /// A call within the callback failed; or the unit can't do the rest of the step, and the whole
    /// step is discarded.
    pub fn resume_step(&mut self, until: Option<f64>) -> Result<Next, CallError> {
        let (State::IntermediateUpdate, Some(unit), Some(step)) =
            (self.now.state, &mut self.now.unit, &mut self.step)
        else {
            return refused("a call within the intermediate update failed");
        };
        self.now.state = State::StepComplete;
        if let Some(until) = until {
            step.end_at(unit, self.now.clock.unit_time(until));
        }
        self.go_on(true)
    }

    /// Internal steps until the end of the communication step, an event after one of them, or the
    /// importer's callback. `stepped`: whether one has just been done.
    fn go_on(&mut self, mut stepped: bool) -> Result<Next, CallError> {
        loop {
            let (Some(unit), Some(step)) = (&mut self.now.unit, &mut self.step) else {
                return refused("no communication step is in progress");
            };
            let mut over = unit.is_over(step.to, &step.step);
            let watched = stepped && self.importer.events && (over || self.importer.early_return);
            let event = watched.then(|| unit.event(&step.step)).flatten();
            if over || event.is_some() {
                return self.end_step(event);
            }
            let mut messages = Vec::new();
            let advanced = unit.advance(step.to, &mut step.step, &self.now.settings, &mut messages);
            (over, stepped) = (unit.is_over(step.to, &step.step), true);
            let time = self.now.clock.importer_time(unit.time());
            self.log_messages(&messages);
            if let Err(text) = advanced {
                self.now.rates = self.step.take().and_then(|step| step.rates);
                return self.fail_step(&text);
            }
            if let Some(callback) = self.importer.update {
                self.now.state = State::IntermediateUpdate;
                return Ok(Next::Update(Update {
                    callback,
                    time,
                    inputs_may_be_set: self.importer.sets_inputs && !over,
                    can_return_early: self.importer.early_return && !over,
                }));
            }
        }
    }

    pub(super) fn step_is_over(&self) -> bool {
        let in_step = self.now.unit.as_ref().zip(self.step.as_ref());
        in_step.is_some_and(|(unit, step)| unit.is_over(step.to, &step.step))
    }

    /// Ends the communication step at the present time of the unit.
    fn end_step(&mut self, event: Option<String>) -> Result<Next, CallError> {
        let (Some(unit), Some(mut step)) = (&mut self.now.unit, self.step.take()) else {
            return refused("no communication step is in progress");
        };
        if !unit.is_over(step.to, &step.step) {
            step.end_at(unit, unit.time());
        }
        let mut messages = Vec::new();
        unit.finish(&step.step, &mut messages);
        self.now.state = State::StepComplete;
        self.now.clock = match step.shortened {
            true => self.now.clock.back_at(unit.time()),
            false => step.end,
        };
        let time = self.now.clock.point;
        self.log_messages(&messages);
        if let Some(event) = &event {
            let text = format!("event at {time} s: {event}");
            self.log.send(Status::Ok, Category::Events, &text);
        }
        Ok(Next::Ended(Ended {
            event: event.is_some(),
            early: step.shortened,
            time,
        }))
    }

    /// Ends a communication step that was not completed: all is as before, and the next step begins
    /// where this one did.
    fn fail_step(&mut self, text: &str) -> Result<Next, CallError> {
        self.now.state = State::StepFailed;
        Err(CallError::Discarded(self.with_start(text)))
    }

    /// In FMI 2.0, how the last step ended. Writes to `place`, if its `kind` is the `known` one: of
    /// the numbers of `fmi2StatusKind`, from 0 to 3, the one that has a value of this type.
    ///
    /// # Errors
    /// The kind is not of the standard; or
    /// the kind has no value of this type, and the call is discarded.
    pub fn status<T>(
        &self,
        kind: i32,
        known: i32,
        place: &mut MaybeUninit<T>,
        value: impl FnOnce(&Self) -> T,
    ) -> Outcome {
        if !(0..=3).contains(&kind) {
            return refused(format!("the kind of status {kind} is not one of the standard's"));
        }
        self.allow(Call::GetStatus)?;
        if kind != known {
            return Err(CallError::Discarded(format!(
                "there is no status of the kind {kind} in this type: each step is complete when \
                 fmi2DoStep returns"
            )));
        }
        place.write(value(self));
        Ok(())
    }

    pub fn step_status(&self) -> Status {
        match self.now.state {
            State::StepFailed => Status::Discard,
            _ => Status::Ok,
        }
    }
}

impl<U: Unit> StepInProgress<U> {
    /// Shortens it: it ends at a time of the unit, s, or at the present one if that is later.
    fn end_at(&mut self, unit: &mut U, time: f64) {
        if time < self.end.elapsed {
            self.to = self.to.min(time);
            unit.end_at(self.to, &mut self.step);
            self.shortened = true;
        }
    }
}
