//! An instance, and what every call goes through: permission, log, and containment of a panic.

use std::any::Any;
use std::cell::OnceCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::outcome::{Outcome, Trouble, refused};
use crate::description::guid;
use crate::log::{Category, Log, Sink, Status};
use crate::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::table::Table;
use crate::unit::{Remark, Unit};

/// Version of the standard that an instance follows, with what its master handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three {
        /// Whether the master handles events: `eventModeUsed`.
        events: bool,
    },
}

/// An instance of a unit.
pub struct Slave<U: Unit> {
    pub(super) table: Table<U::Settings, U::Readings>,
    pub(super) log: Log,
    /// Whether the importer asked for debug logging when it created the instance.
    pub(super) debug: bool,
    /// What a new or reset instance starts from.
    pub(super) start: U::Settings,
    /// Written once: it is a hash of the whole description.
    guid: OnceCell<String>,
    pub(super) version: Version,
    /// Name of the C function under way, where it is not that of FMI 2.0.
    called: Option<&'static str>,
    /// The whole dynamic state.
    pub(super) now: Snapshot<U>,
}

impl<U: Unit> Slave<U> {
    /// A new instance that logs into `sink`.
    #[must_use]
    pub fn new(sink: Option<Box<dyn Sink>>, debug: bool) -> Self {
        Self::of(Version::Two, Log::new(sink, debug), debug)
    }

    /// A new instance that follows a version of the standard, with its log.
    #[must_use]
    pub fn of(version: Version, log: Log, debug: bool) -> Self {
        Self {
            table: U::table(),
            log,
            debug,
            start: U::Settings::default(),
            guid: OnceCell::new(),
            version,
            called: None,
            now: Snapshot::new(),
        }
    }

    /// The same instance with other start values, which a reset brings back too. For an instance that is new.
    #[must_use]
    pub fn starting_from(mut self, start: U::Settings) -> Self {
        self.start = start;
        self.now = Snapshot::starting_from(self.start.clone());
        self
    }

    /// The same, with the name of the C function that messages are to give.
    pub fn called(&mut self, function: &'static str) -> &mut Self {
        self.called = Some(function);
        self
    }

    /// The variable table.
    #[must_use]
    pub fn table(&self) -> &Table<U::Settings, U::Readings> {
        &self.table
    }

    /// The GUID of the unit.
    pub(super) fn guid(&self) -> &str {
        self.guid.get_or_init(guid::<U>)
    }

    /// State of the state machine.
    #[must_use]
    pub fn state(&self) -> State {
        self.now.state
    }

    /// Refuses a call that the capability flags exclude.
    pub fn not_offered(&mut self, function: &'static str, why: &str) -> Status {
        self.refuse(function, &format!("not offered: {why}"))
    }

    /// Refuses a call whose arguments can't be used.
    pub fn refuse(&mut self, function: &'static str, why: &str) -> Status {
        self.call(function, |_| refused(why))
    }

    /// Refuses a call that the present state does not allow.
    pub(super) fn allow(&self, call: Call) -> Outcome {
        // FMI 3.0 also lets start values be read before the initialisation.
        let early = call == Call::Get && self.now.state == State::Instantiated && self.version != Version::Two;
        if early || call.allowed_in(self.now.state) {
            return Ok(());
        }
        let advice = match self.now.state {
            State::Error => "; reset it or restore a stored state",
            _ => "",
        };
        refused(format!(
            "not allowed while the instance is {}{advice}",
            self.now.state.name()
        ))
    }

    /// Starts the unit, unless it has been started.
    pub(super) fn start_unit(&mut self) -> Outcome {
        if self.now.unit.is_none() {
            let mut remarks = Vec::new();
            let started = U::start(&self.now.settings, &self.now.experiment, &mut remarks);
            self.log_remarks(&remarks);
            self.now.unit = Some(started.map_err(Trouble::Failed)?);
            self.now.point = self.now.experiment.start;
        }
        Ok(())
    }

    /// Logs what the unit remarks.
    pub(super) fn log_remarks(&self, remarks: &[Remark]) {
        for remark in remarks {
            let (status, category) = if remark.warning {
                (Status::Warning, Category::Warning)
            } else {
                (Status::Ok, Category::Events)
            };
            self.log.send(status, category, &remark.text);
        }
    }

    /// Runs a call, logs what went wrong and contains a panic within this instance.
    pub(super) fn call(&mut self, function: &'static str, body: impl FnOnce(&mut Self) -> Outcome) -> Status {
        let outcome = catch_unwind(AssertUnwindSafe(|| body(self))).unwrap_or_else(|panic| {
            // What the panic left behind is not to be trusted.
            let broken = self.now.unit.take();
            drop(catch_unwind(AssertUnwindSafe(|| drop(broken))));
            Err(Trouble::Failed(format!(
                "internal error, please report: {}",
                panic_text(panic.as_ref())
            )))
        });
        let (status, category, text) = match outcome {
            Ok(()) => return Status::Ok,
            Err(Trouble::Refused(text)) => (Status::Error, Category::Error, text),
            Err(Trouble::Failed(text)) => {
                self.now.state = State::Error;
                (Status::Error, Category::Error, text)
            }
            Err(Trouble::Discarded(text)) => (Status::Discard, Category::Discard, text),
        };
        let function = self.called.unwrap_or(function);
        self.log.send(status, category, &format!("{function}: {text}"));
        status
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("panic without a message")
}
