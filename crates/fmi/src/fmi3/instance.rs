//! An instance of FMI 3.0: a slave, what its master handles, and the communication step under way.

use super::description::TIME;
use super::types::{Environment, IntermediateUpdate};
use crate::log::Status;
use crate::slave::{Slave, Underway};
use crate::state::State;
use crate::stepping::OwnSteps;

/// How a master watches the unit's own steps.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    /// Whether the master handles events.
    pub events: bool,
    /// Whether a communication step may end early.
    pub early_return: bool,
    /// Called at the end of each own step, with the importer's environment.
    pub update: Option<(IntermediateUpdate, Environment)>,
    /// Inputs that are set and outputs that are read there.
    pub required: Vec<u32>,
    /// Whether inputs are among them.
    pub sets_inputs: bool,
}

/// An instance.
pub struct Instance3<U: OwnSteps> {
    pub slave: Slave<U>,
    pub watch: Watch,
    pub underway: Option<Underway<U::Way>>,
    /// Whether the master has been called back and has not returned: intermediate update mode.
    pub asking: bool,
}

/// What is to be done next in a communication step.
#[derive(Clone, Copy, Debug)]
pub enum Next {
    /// The unit goes on by itself.
    GoOn,
    /// The master is called back.
    Ask(Question),
    /// The step has ended.
    Ended(Ending),
    /// The step has failed.
    Failed(Status),
}

/// What a master is asked in intermediate update mode.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    pub update: IntermediateUpdate,
    pub environment: Environment,
    pub time: f64,
    pub inputs_may_be_set: bool,
    pub can_return_early: bool,
}

/// How a communication step ended.
#[derive(Clone, Copy, Debug)]
pub struct Ending {
    pub status: Status,
    pub event: bool,
    pub early: bool,
    /// Time reached, s.
    pub time: f64,
}

impl<U: OwnSteps> Instance3<U> {
    pub fn new(slave: Slave<U>, watch: Watch) -> Self {
        Self {
            slave,
            watch,
            underway: None,
            asking: false,
        }
    }

    /// Whether events end a communication step when they happen.
    fn returns_at_events(&self) -> bool {
        self.watch.events && self.watch.early_return
    }

    /// Begins a communication step. Where nobody watches the unit's own steps, it is done at once.
    pub fn begin(&mut self, current: f64, step: f64) -> Next {
        self.underway = None;
        if self.watch.update.is_none() && !self.watch.events {
            let status = self.slave.do_step(current, step);
            return match status {
                Status::Ok => Next::Ended(self.ending(false, false)),
                failed => Next::Failed(failed),
            };
        }
        let (status, underway) = self.slave.set_out(current, step);
        self.underway = underway;
        match (status, &self.underway) {
            (Status::Ok, Some(underway)) if underway.is_over() => self.end(None),
            (Status::Ok, Some(_)) => Next::GoOn,
            _ => Next::Failed(status),
        }
    }

    /// One own step of the unit.
    pub fn go_on(&mut self) -> Next {
        let Some(underway) = &mut self.underway else {
            return Next::Failed(Status::Error);
        };
        let status = self.slave.own_step(underway);
        if status != Status::Ok {
            self.underway = None;
            return Next::Failed(status);
        }
        let over = underway.is_over();
        let Some((update, environment)) = self.watch.update else {
            return self.after_own_step();
        };
        self.asking = true;
        Next::Ask(Question {
            update,
            environment,
            time: self.slave.own_time(),
            inputs_may_be_set: self.watch.sets_inputs && !over,
            can_return_early: self.watch.early_return && !over,
        })
    }

    /// The master has returned from intermediate update mode; it may want the step to end at a time, s.
    pub fn answered(&mut self, until: Option<f64>) -> Next {
        self.asking = false;
        if self.slave.state() == State::Error {
            // A call of the master's has failed, and it has been told so.
            self.underway = None;
            return Next::Failed(Status::Error);
        }
        if let (Some(until), Some(underway)) = (until, &mut self.underway) {
            let status = self.slave.end_at(underway, until);
            if status != Status::Ok {
                return Next::Failed(status);
            }
        }
        self.after_own_step()
    }

    /// Ends the communication step at its end or at an event.
    fn after_own_step(&mut self) -> Next {
        let Some(underway) = &mut self.underway else {
            return Next::Failed(Status::Error);
        };
        let over = underway.is_over();
        let look = self.watch.events && (over || self.watch.early_return);
        let event = look.then(|| self.slave.event(underway)).flatten();
        if event.is_some() && !over && self.returns_at_events() {
            let here = self.slave.own_time();
            if let Some(underway) = &mut self.underway {
                self.slave.end_at(underway, here);
            }
            return self.end(event);
        }
        if over { self.end(event) } else { Next::GoOn }
    }

    fn end(&mut self, event: Option<String>) -> Next {
        let Some(underway) = self.underway.take() else {
            return Next::Failed(Status::Error);
        };
        let (status, early) = self.slave.arrive(&underway, event.as_deref());
        match status {
            Status::Ok => Next::Ended(self.ending(event.is_some(), early)),
            failed => Next::Failed(failed),
        }
    }

    fn ending(&self, event: bool, early: bool) -> Ending {
        Ending {
            status: Status::Ok,
            event,
            early,
            time: self.slave.time(),
        }
    }
}

impl<U: OwnSteps> Instance3<U> {
    /// Why these variables can't be used now: in intermediate update mode only those that were announced for it, and the time.
    pub fn not_announced(&self, references: &[u32]) -> Option<String> {
        let announced = |reference: &u32| *reference == TIME || self.watch.required.contains(reference);
        let unannounced = references.iter().find(|reference| !announced(reference))?;
        self.asking.then(|| {
            format!(
                "in intermediate update mode, and the value reference {unannounced} is not among the required intermediate \
                 variables that fmi3InstantiateCoSimulation was given"
            )
        })
    }

    /// Why no input can be set now.
    pub fn not_for_setting(&self) -> Option<String> {
        let over = self.underway.as_ref().is_some_and(Underway::is_over);
        (self.asking && over).then(|| "the communication step has come to its end: set inputs after it".to_owned())
    }
}
