//! What a model has to offer to become an FMU.

use super::table::Table;
use crate::tape::Tape;

/// What the master says about the run before it starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Relative tolerance, if the master prescribes one.
    pub tolerance: Option<f64>,
    /// Start time, s.
    pub start: f64,
    /// Time the master will not step beyond, if it says so, s.
    pub stop: Option<f64>,
}

impl Default for Experiment {
    fn default() -> Self {
        Self {
            tolerance: None,
            start: 0.0,
            stop: None,
        }
    }
}

/// Name and suggestions for the head of the description.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// Model name and identifier: a C identifier, also the file name of the binary.
    pub name: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Version of the model.
    pub version: &'static str,
    /// Who wrote it.
    pub author: &'static str,
    /// Licence.
    pub license: &'static str,
    /// Suggested stop time of an experiment from 0 s, s.
    pub stop_time: f64,
    /// Suggested communication step, s.
    pub step_size: f64,
    /// Suggested relative tolerance.
    pub tolerance: f64,
    /// Longest communication step that is accepted, s: a slip of units should end in a message, not in hours of work.
    pub longest_step: f64,
}

/// A remark for the user's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// Whether the user should act on it.
    pub warning: bool,
    /// One sentence.
    pub text: String,
}

/// Why a step was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StepFailure {
    /// A setting is out of its range; nothing was changed.
    #[error("{0}")]
    Setting(String),
    /// The step could not be completed. [`Unit::time`] tells how far it came; from there a shorter one may be tried.
    #[error("{0}")]
    Discarded(String),
}

/// Readings a moment before and after the present, if the inputs go on as they did: for time derivatives.
#[derive(Debug)]
pub struct Moment<R> {
    /// A moment before.
    pub before: R,
    /// A moment after.
    pub after: R,
    /// Time between the two, s.
    pub span: f64,
}

/// A model that can live in an FMU. It holds its whole dynamic state, solver history included, so that a clone
/// continues exactly as the original would.
pub trait Unit: Clone + Sized {
    /// Parameters and inputs. The default holds the start values.
    type Settings: Clone + Default;
    /// Outputs and locals.
    type Readings;

    /// Name and suggestions.
    const IDENTITY: Identity;

    /// The variable table.
    fn table() -> Table<Self::Settings, Self::Readings>;

    /// Checks the settings as a whole.
    ///
    /// # Errors
    /// A sentence that names variable, value and allowed range.
    fn check(settings: &Self::Settings) -> Result<(), String>;

    /// Builds the model and finds its state at the start.
    ///
    /// # Errors
    /// A sentence that says what is wrong.
    fn start(settings: &Self::Settings, experiment: &Experiment, remarks: &mut Vec<Remark>) -> Result<Self, String>;

    /// Advances to time `to` with the settings held. `rates`, if there are any, hold the time derivatives of the real
    /// inputs, which then change in proportion to time.
    ///
    /// # Errors
    /// See [`StepFailure`].
    fn advance(
        &mut self,
        to: f64,
        settings: &Self::Settings,
        rates: Option<&Self::Settings>,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), StepFailure>;

    /// The model as it is before [`Unit::pass`] reads a state into it.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the settings.
    fn blank(settings: &Self::Settings, experiment: &Experiment) -> Result<Self, String>;

    /// Passes by a tape the whole dynamic state, solver history included: what is read from it continues bit for bit.
    fn pass(&mut self, tape: &mut Tape<'_>);

    /// Present time, s.
    fn time(&self) -> f64;

    /// Readings at the present time; elements of arrays only if they are asked for.
    fn readings(&mut self, elements: bool) -> &Self::Readings;

    /// Readings around the present time, without elements of arrays.
    fn moment(&mut self) -> Moment<Self::Readings>;
}
