//! What a model has to offer to become an FMU.

use super::table::Table;
use pushbelt_tape::Tape;

/// What the master sets for the run before it starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Relative tolerance, if the master prescribes one.
    pub tolerance: Option<f64>,
    /// Start time, s.
    pub start: f64,
    /// Time beyond which the master will not step, if it gives one, s.
    pub stop: Option<f64>,
}

impl Experiment {
    /// As a master sets it up: tolerance and stop time count only where they are said to be defined.
    pub(super) fn given(tolerance: (bool, f64), start: f64, stop: (bool, f64)) -> Self {
        let defined = |(defined, value): (bool, f64)| defined.then_some(value);
        Self {
            tolerance: defined(tolerance),
            start,
            stop: defined(stop),
        }
    }
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

/// Name of a model, and what its description suggests for an experiment.
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
    /// Longest communication step that is accepted, s: a mistaken unit should end in a message, not in hours of work.
    pub longest_step: f64,
}

/// A remark for the user's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// Whether the user should act on it.
    pub warning: bool,
    /// The remark in one sentence.
    pub text: String,
}

/// Why a step was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StepFailure {
    /// A setting is out of its range; nothing was changed.
    #[error("{0}")]
    Setting(String),
    /// The step was completed in part. It ended at [`Unit::time`], and a shorter step may go on from there.
    #[error("{0}")]
    Discarded(String),
}

/// Readings a moment before and a moment after the present, from which time derivatives follow.
#[derive(Debug)]
pub struct Moment<R> {
    /// Readings a moment before the present.
    pub before: R,
    /// Readings a moment after it, with the inputs as they were.
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

    /// Name of the model, and what its description suggests.
    const IDENTITY: Identity;

    /// All variables of the model.
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

    /// The model as it is before [`Unit::serialize`] reads a state into it.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the settings.
    fn blank(settings: &Self::Settings, experiment: &Experiment) -> Result<Self, String>;

    /// Writes the whole dynamic state to a tape or reads it from one, solver history included. A model that was read
    /// continues bit for bit.
    fn serialize(&mut self, tape: &mut Tape<'_>);

    /// The present time, s.
    fn time(&self) -> f64;

    /// Readings at the present time; elements of arrays only if they are asked for.
    fn readings(&mut self, elements: bool) -> &Self::Readings;

    /// Readings around the present time, without elements of arrays.
    fn moment(&mut self) -> Moment<Self::Readings>;
}
