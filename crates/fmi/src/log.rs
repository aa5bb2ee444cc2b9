//! Messages to the importer.

/// Status of a call, numbered as in the standard; the others, of lost instances and pending calls,
/// are never returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// The call was done.
    Ok = 0,
    /// The call was done; a message has a warning.
    Warning = 1,
    /// A value was discarded, or a step was not completed; another value or a smaller step may
    /// work.
    Discard = 2,
    /// The call failed; the run can't continue without reset or a stored state.
    Error = 3,
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
}

impl From<()> for Status {
    fn from((): ()) -> Self {
        Self::Ok
    }
}

#[cfg(feature = "c")]
pub(crate) type Sink = Box<dyn Fn(Status, Category, &str)>;

#[cfg(feature = "c")]
pub(crate) struct Log {
    sink: Option<Sink>,
    /// Whether the importer switched debug logging on when it created the instance.
    debug: bool,
    enabled: Vec<Category>,
}

#[cfg(feature = "c")]
impl Log {
    /// A log into `sink`, if there is one.
    pub fn new(sink: Option<Sink>, debug: bool) -> Self {
        let mut log = Self {
            sink,
            debug,
            enabled: Vec::new(),
        };
        log.reset();
        log
    }

    /// Logs what it logged when it was created.
    pub fn reset(&mut self) {
        self.choose(self.debug, &[]);
    }

    /// Chooses what is logged with `debug`: errors and these categories, or all if there is none.
    /// Without it errors, warnings and discards are logged: they are no debug messages, and
    /// `loggingOn` is about these (section 2.1.5 of FMI 2.0; section 2.3.1 of 3.0.2 forbids any
    /// message, 3.0.3 corrects that for errors).
    pub fn choose(&mut self, debug: bool, chosen: &[Category]) {
        self.enabled = match (debug, chosen) {
            (false, _) => vec![Category::Error, Category::Warning, Category::Discard],
            (true, []) => Category::ALL.to_vec(),
            (true, _) => [chosen, &[Category::Error]].concat(),
        };
    }

    /// Logs a message.
    pub fn send(&self, status: Status, category: Category, text: &str) {
        if let Some(sink) = &self.sink
            && self.enabled.contains(&category)
        {
            sink(status, category, text);
        }
    }
}
