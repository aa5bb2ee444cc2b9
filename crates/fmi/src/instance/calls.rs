//! An instance, and what is common to all calls: permission, log, and containment of a panic.

use std::cell::OnceCell;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::clock::Clock;
use super::snapshot::Snapshot;
use super::{CallError, Outcome, refused};
use crate::description::{self, Version};
use crate::log::{Category, Log, Status};
use crate::state::{Call, State};
use crate::table::Table;
use crate::unit::{Message, Unit};

/// `fmi3InstanceEnvironment`: a pointer that the importer gets back with each callback.
pub type Environment = *mut c_void;

/// `fmi3IntermediateUpdateCallback`: environment, time, whether inputs may be set, whether outputs
/// may be read, whether the unit's step is accepted, whether an early return may be requested;
/// results: whether it is requested, and for which time.
pub type IntermediateUpdate = unsafe extern "C" fn(Environment, f64, u8, u8, u8, u8, *mut u8, *mut f64);

/// A function of the importer, and the environment that it gets back.
#[derive(Clone, Copy, Debug)]
pub struct Callback {
    pub function: IntermediateUpdate,
    pub environment: Environment,
}

/// Capabilities of an importer. The default is an importer of FMI 2.0.
#[derive(Clone, Debug, Default)]
pub struct Importer {
    /// Version of the standard.
    pub version: Version,
    /// Whether it handles events: `eventModeUsed`.
    pub events: bool,
    /// Whether a communication step may end early.
    pub early_return: bool,
    /// Called after each internal step of the unit.
    pub update: Option<Callback>,
    /// Variables that it sets and reads there.
    pub intermediate: Vec<u32>,
    /// Whether inputs are among them.
    pub sets_inputs: bool,
}

pub(super) struct StepInProgress<U: Unit> {
    pub step: U::Step,
    /// Time of the unit at which it ends, s.
    pub to: f64,
    /// Time derivatives of the inputs, which a step that can't be done leaves.
    pub rates: Option<U::Settings>,
    /// The communication point at which it ends.
    pub end: Clock,
    /// Whether it ends early.
    pub shortened: bool,
}

/// An instance of a unit.
pub struct FmuInstance<U: Unit> {
    pub(super) table: Table<U::Settings, U::Readings>,
    pub(super) log: Log,
    pub(super) importer: Importer,
    /// The start values of a new or reset instance.
    pub(super) start: U::Settings,
    /// Computed once: it is a hash of the whole description.
    guid: OnceCell<String>,
    /// The communication step in progress, between two internal steps of the unit.
    pub(super) step: Option<StepInProgress<U>>,
    /// The unit of before [`FmuInstance::reset_near`], until the next start.
    pub(super) near: Option<U>,
    /// The whole dynamic state.
    pub(super) now: Snapshot<U>,
}

impl<U: Unit> FmuInstance<U> {
    pub fn new(importer: Importer, log: Log, start: U::Settings) -> Self {
        Self {
            table: U::table(),
            log,
            importer,
            start: start.clone(),
            guid: OnceCell::new(),
            step: None,
            near: None,
            now: Snapshot::starting_from(start),
        }
    }

    pub(super) fn guid(&self) -> &str {
        self.guid
            .get_or_init(|| description::token::<U>(Version::Two, U::data(&self.start)))
    }

    /// The present time, s: the communication point; before the start the start time, and in
    /// intermediate update mode the time of the unit.
    pub fn time(&self) -> f64 {
        match &self.now.unit {
            Some(unit) if self.now.state == State::IntermediateUpdate => {
                self.now.clock.importer_time(unit.time())
            }
            Some(_) => self.now.clock.point,
            None => self.now.experiment.start,
        }
    }

    /// Whether a call is allowed now.
    ///
    /// # Errors
    /// It is not.
    pub(crate) fn allow(&self, call: Call) -> Outcome {
        let state = self.now.state;
        // FMI 3.0 also lets start values be read before the initialisation.
        let early =
            call == Call::Get && state == State::Instantiated && self.importer.version == Version::Three;
        if early || call.allowed_in(state) {
            return Ok(());
        }
        refused(format!("not allowed while the instance is {}", state.name()))
    }

    /// Starts the unit, unless it has been started.
    ///
    /// # Errors
    /// The unit does not start: the instance has failed.
    pub(super) fn start_unit(&mut self) -> Outcome {
        if self.now.unit.is_none() {
            let mut messages = Vec::new();
            let (settings, experiment) = (&self.now.settings, &self.now.experiment);
            let started = match self.near.take() {
                Some(near) => U::start_near(&near, settings, experiment, &mut messages),
                None => U::start(settings, experiment, &mut messages),
            };
            self.log_messages(&messages);
            self.now.unit = Some(started.map_err(CallError::Failed)?);
            self.now.clock = Clock::start(self.now.experiment.start)?;
        }
        Ok(())
    }

    /// A query beyond the standard about the unit in its present state, from initialisation mode
    /// on. Messages are logged; with a warning among them the status is a warning.
    ///
    /// # Errors
    /// The query has no result, with its reason.
    pub fn query(
        &mut self,
        query: impl FnOnce(&mut U, &U::Settings, &mut Vec<Message>) -> Result<String, String>,
    ) -> Result<(Status, String), CallError> {
        self.allow(Call::Get)?;
        if self.now.state == State::Initialisation {
            self.start_unit()?;
        }
        let Some(unit) = &mut self.now.unit else {
            return refused("there is no model after a failed start");
        };
        let mut messages = Vec::new();
        let found = query(unit, &self.now.settings, &mut messages);
        self.log_messages(&messages);
        let warned = messages.iter().any(|message| message.warning);
        let status = if warned { Status::Warning } else { Status::Ok };
        Ok((status, found.map_err(CallError::Refused)?))
    }

    pub(crate) fn log_messages(&self, messages: &[Message]) {
        for message in messages {
            let (status, category) = match message.warning {
                true => (Status::Warning, Category::Warning),
                false => (Status::Ok, Category::Events),
            };
            self.log.send(status, category, &self.with_start(&message.text));
        }
    }

    /// A text of the unit, and the start if it is not 0: times in it are those of the unit.
    pub(super) fn with_start(&self, text: &str) -> String {
        match self.now.experiment.start {
            0.0 => text.to_owned(),
            start => format!("{text} (times in this message count from the start at {start} s)"),
        }
    }

    /// Makes the call of a C function: logs its error and contains a panic within this instance.
    pub fn call(
        &mut self,
        function: &str,
        body: &mut dyn FnMut(&mut Self) -> Result<Status, CallError>,
    ) -> Status {
        let outcome = catch_unwind(AssertUnwindSafe(|| body(self))).unwrap_or_else(|panic| {
            // After a panic the unit may be inconsistent.
            let broken = (self.now.unit.take(), self.step.take());
            drop(catch_unwind(AssertUnwindSafe(|| drop(broken))));
            let text = panic.downcast_ref::<&str>().copied();
            let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
            let text = text.unwrap_or("panic without a message");
            Err(CallError::Failed(format!("internal error, please report: {text}")))
        });
        let (status, category, text) = match outcome {
            Ok(status) => return status,
            Err(CallError::Refused(text)) => (Status::Error, Category::Error, text),
            Err(CallError::Failed(text)) => {
                self.now.state = State::Error;
                (Status::Error, Category::Error, text)
            }
            Err(CallError::Discarded(text)) => (Status::Discard, Category::Discard, text),
        };
        self.log.send(status, category, &format!("{function}: {text}"));
        status
    }
}
