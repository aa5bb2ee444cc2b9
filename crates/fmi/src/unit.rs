//! The trait that a model implements to become an FMU.

use super::table::Table;
use pushbelt_archive::Archive;
use std::path::Path;

/// What the importer sets for the run before it starts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Relative tolerance, if the importer prescribes one.
    pub tolerance: Option<f64>,
    /// Time of the importer at the start, s. The unit counts its own time from there.
    pub start: f64,
    /// Time beyond which the importer does not step, if it is defined, s.
    pub stop: Option<f64>,
}

/// Name of a model, and the experiment that its description suggests.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// Model name and identifier: a C identifier, also the file name of the binary.
    pub name: &'static str,
    /// What the model is, in one sentence.
    pub description: &'static str,
    /// Version of the model.
    pub version: &'static str,
    /// Authors of the model.
    pub author: &'static str,
    /// Licence of the model.
    pub license: &'static str,
    /// Name and version of the program that makes the model description.
    pub generation_tool: &'static str,
    /// Suggested stop time of an experiment from 0 s, s.
    pub stop_time: f64,
    /// Suggested communication step, s.
    pub step_size: f64,
    /// Suggested relative tolerance.
    pub tolerance: f64,
    /// Longest communication step that is accepted, s: a wrong unit of time gives an error instead
    /// of hours of computation.
    pub longest_step: f64,
}

impl Identity {
    /// A model without author and licence, with an experiment of 1 s in steps of 1 ms.
    #[must_use]
    pub const fn new(name: &'static str, description: &'static str) -> Self {
        Self {
            name,
            description,
            version: "0.1.0",
            author: "",
            license: "",
            generation_tool: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
            stop_time: 1.0,
            step_size: 1e-3,
            tolerance: 1e-4,
            longest_step: 1e3,
        }
    }
}

/// A message for the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether the user should act on it.
    pub warning: bool,
    /// The message in one sentence.
    pub text: String,
}

impl Message {
    /// A message on which the user should act.
    #[must_use]
    pub fn warning(text: String) -> Self {
        Self { warning: true, text }
    }
}

/// A model in an FMU. It contains its whole dynamic state, solver history included, so that a clone
/// continues exactly as the original would.
///
/// A communication step is [`begin`](Unit::begin), then [`advance`](Unit::advance) until
/// [`is_over`](Unit::is_over), then [`finish`](Unit::finish). A step that fails leaves the unit in
/// the state before `begin`, as FMI 3.0 requires: a shorter one, or one with other inputs, may be
/// possible.
///
/// An error is the reason, as a sentence, if possible with variable, value and allowed range.
pub trait Unit: Clone + Sized {
    /// Parameters and inputs. The default holds the start values.
    type Settings: Clone + Default;
    /// Outputs and locals.
    type Readings;
    /// What the unit needs from one internal step of a communication step to the next.
    type Step;

    /// Name of the model, and the experiment that its description suggests.
    const IDENTITY: Identity;
    /// Whether [`Unit::begin`] uses the rates of inputs; otherwise input derivatives are refused.
    const INTERPOLATES_INPUTS: bool = false;
    /// Whether [`Unit::moment`] returns readings; otherwise output derivatives are refused.
    const OUTPUT_DERIVATIVES: bool = false;

    /// All variables of the model.
    fn table() -> Table<Self::Settings, Self::Readings>;

    /// The settings of a new instance, with data of the model from the folder of its resources, if
    /// there is one.
    ///
    /// # Errors
    /// The data are missing or damaged. There is no instance then.
    fn load(_resources: Option<&Path>) -> Result<Self::Settings, String> {
        Ok(Self::Settings::default())
    }

    /// A hash of the data that [`Unit::load`] has read. It is part of the GUID and of stored
    /// states.
    fn data(_settings: &Self::Settings) -> Option<u128> {
        None
    }

    /// Checks the settings as a whole, when a tunable parameter changes during a run.
    ///
    /// # Errors
    /// They do not fit together.
    fn check(_settings: &Self::Settings) -> Result<(), String> {
        Ok(())
    }

    /// Builds the model and finds its state at the start, the unit's time 0.
    ///
    /// # Errors
    /// The settings do not fit, or there is no state to start from.
    fn start(
        settings: &Self::Settings,
        experiment: &Experiment,
        messages: &mut Vec<Message>,
    ) -> Result<Self, String>;

    /// As [`Unit::start`]. The search for the state may begin at the one that `near` started from.
    ///
    /// # Errors
    /// As [`Unit::start`].
    fn start_near(
        _near: &Self,
        settings: &Self::Settings,
        experiment: &Experiment,
        messages: &mut Vec<Message>,
    ) -> Result<Self, String> {
        Self::start(settings, experiment, messages)
    }

    /// The present time since the start, s.
    fn time(&self) -> f64;

    /// Readings at the present time; elements of arrays only if `elements` is true. During a run
    /// they depend on inputs through the state only: a changed input has an effect from the next
    /// step on.
    fn readings(&mut self, elements: bool) -> &Self::Readings;

    /// Begins a communication step from the present time to the time `to`, s, with these settings.
    /// `rates` has the time derivatives of the real inputs in the inputs' fields; none if all are
    /// held.
    ///
    /// # Errors
    /// A setting is out of its range. Nothing has changed.
    fn begin(
        &mut self,
        to: f64,
        settings: &Self::Settings,
        rates: Option<&Self::Settings>,
    ) -> Result<Self::Step, String>;

    /// Advances by one internal step, at most to the end of the communication step at the time
    /// `to`, s. Inputs that differ from those of the previous call take effect here.
    ///
    /// # Errors
    /// The step is not possible. The communication step has ended, and the unit is in the state
    /// before [`Unit::begin`].
    fn advance(
        &mut self,
        to: f64,
        step: &mut Self::Step,
        settings: &Self::Settings,
        messages: &mut Vec<Message>,
    ) -> Result<(), String>;

    /// Whether the end of the communication step at the time `to`, s, is reached.
    fn is_over(&self, to: f64, _step: &Self::Step) -> bool {
        self.time() >= to
    }

    /// A description of an event since the communication step began, if there is one for the
    /// importer to handle.
    fn event(&self, _step: &Self::Step) -> Option<String> {
        None
    }

    /// The communication step is shortened: it ends at the time `to`, s, or at the present if that
    /// is later.
    fn end_at(&mut self, _to: f64, _step: &mut Self::Step) {}

    /// Ends the communication step at the present time.
    fn finish(&mut self, _step: &Self::Step, _messages: &mut Vec<Message>) {}

    /// Readings a moment before and a moment after the present, with the inputs as they were, and
    /// the time between the two, s: time derivatives follow. Without elements of arrays.
    fn moment(&mut self) -> Option<([Self::Readings; 2], f64)> {
        None
    }

    /// A model into which [`Unit::serialize`] can read a state.
    ///
    /// # Errors
    /// The settings do not fit.
    fn blank(settings: &Self::Settings, experiment: &Experiment) -> Result<Self, String> {
        Self::start(settings, experiment, &mut Vec::new())
    }

    /// Writes the whole dynamic state to an archive or reads it from one, solver history included.
    /// A model that was read continues bit for bit.
    fn serialize(&mut self, archive: &mut Archive<'_>);
}
