//! Messages to the importer.

use crate::slave::Version;

/// Status of a call, numbered as in the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// The call was done.
    Ok = 0,
    /// The call was done; a message has a warning.
    Warning = 1,
    /// A value was discarded, or a step was not completed; another value or a smaller step may work.
    Discard = 2,
    /// The call failed; the run can't continue without reset or a stored state.
    Error = 3,
    /// All instances are lost. Never returned here.
    Fatal = 4,
    /// A call is still running. Never returned here.
    Pending = 5,
}

/// Categories of messages, as in the description's `LogCategories`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Category {
    /// Why a call failed.
    Error,
    /// What may be wrong; the run continues.
    Warning,
    /// Why a value or a step was discarded.
    Discard,
    /// What the unit did.
    Events,
}

impl Category {
    /// All categories.
    pub const ALL: [Self; 4] = [Self::Error, Self::Warning, Self::Discard, Self::Events];

    /// Name that the standard suggests for the log.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "logStatusError",
            Self::Warning => "logStatusWarning",
            Self::Discard => "logStatusDiscard",
            Self::Events => "logEvents",
        }
    }

    /// The bit of the category in [`Log::enabled`].
    fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl From<()> for Status {
    fn from((): ()) -> Self {
        Self::Ok
    }
}

/// Passes one message on to the importer.
pub type Sink = Box<dyn Fn(Status, Category, &str)>;

/// A sink with a choice of categories.
pub struct Log {
    sink: Option<Sink>,
    enabled: u8,
    /// Whether the importer switched debug logging on when it created the instance.
    debug: bool,
    /// What is logged without debug logging.
    quiet: &'static [Category],
}

impl Log {
    /// A log into `sink`, if there is one. Without debug logging FMI 2.0 has errors, warnings and discarded steps: they are no debug
    /// messages, and `loggingOn` is about these (section 2.1.5). FMI 3.0 has errors only: section 2.3.1 of 3.0.2 forbids any message,
    /// but 3.0.3 corrects that. A host that reads none passes no function for messages.
    #[must_use]
    pub fn new(version: Version, sink: Option<Sink>, debug: bool) -> Self {
        let quiet: &[Category] = match version {
            Version::Two => &[Category::Error, Category::Warning, Category::Discard],
            Version::Three => &[Category::Error],
        };
        let mut log = Self {
            sink,
            enabled: 0,
            debug,
            quiet,
        };
        log.reset();
        log
    }

    /// Logs the messages from before it was created.
    pub fn reset(&mut self) {
        self.choose(self.debug, &[]);
    }

    /// Chooses the logged categories: errors, and with `debug` these, or all if `categories` is empty.
    pub fn choose(&mut self, debug: bool, categories: &[Category]) {
        let categories = match (debug, categories.is_empty()) {
            (false, _) => self.quiet,
            (true, true) => &Category::ALL[..],
            (true, false) => categories,
        };
        let always = if debug { Category::Error.bit() } else { 0 };
        self.enabled = categories.iter().fold(always, |bits, category| bits | category.bit());
    }

    /// Logs a message.
    pub fn send(&self, status: Status, category: Category, text: &str) {
        if let Some(sink) = &self.sink
            && self.enabled & category.bit() != 0
        {
            sink(status, category, text);
        }
    }
}
