//! A unit from a model without internal steps and events.

use super::table::Table;
use super::unit::{Experiment, Identity, Remark, StepFailure, Unit};
use pushbelt_archive::Archive;

/// A model without internal steps, events and derivatives, whose inputs are held over a communication step. [`SimpleUnit`] makes a
/// [`Unit`] of it.
pub trait SimpleModel: Clone {
    /// Parameters and inputs. The default holds the start values.
    type Settings: Clone + Default;
    /// Outputs and locals.
    type Readings;

    /// Name of the model, and the experiment that its description suggests.
    const IDENTITY: Identity;

    /// All variables of the model.
    fn table() -> Table<Self::Settings, Self::Readings>;

    /// Checks the settings as a whole, when a tunable parameter changes during a run.
    ///
    /// # Errors
    /// The reason, as a sentence with variable, value and allowed range.
    fn check(_settings: &Self::Settings) -> Result<(), String> {
        Ok(())
    }

    /// The model at the start time, s.
    ///
    /// # Errors
    /// The reason, as a sentence.
    fn start(settings: &Self::Settings, time: f64) -> Result<Self, String>;

    /// Readings at the present time. They depend on inputs through the state only.
    fn readings(&mut self) -> &Self::Readings;

    /// Advances over a communication step, from a time to a later one, s.
    ///
    /// # Errors
    /// The step is not possible; nothing has changed.
    fn advance(&mut self, settings: &Self::Settings, from: f64, to: f64) -> Result<(), StepFailure>;

    /// Writes the whole state to an archive or reads it from one.
    fn serialize(&mut self, archive: &mut Archive<'_>);
}

/// The unit of a [`SimpleModel`]: the model, the start time and the time since then. Times of the model are those of the master.
#[derive(Clone, Debug)]
pub struct SimpleUnit<M> {
    model: M,
    start: f64,
    time: f64,
}

impl<M: SimpleModel> Unit for SimpleUnit<M> {
    type Settings = M::Settings;
    type Readings = M::Readings;
    /// Its end, s.
    type Step = f64;

    const IDENTITY: Identity = M::IDENTITY;

    fn table() -> Table<M::Settings, M::Readings> {
        M::table()
    }

    fn check(settings: &M::Settings) -> Result<(), String> {
        M::check(settings)
    }

    fn start(settings: &M::Settings, experiment: &Experiment, _: &mut Vec<Remark>) -> Result<Self, String> {
        let start = experiment.start;
        let model = M::start(settings, start)?;
        Ok(Self {
            model,
            start,
            time: 0.0,
        })
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn readings(&mut self, _: bool) -> &M::Readings {
        self.model.readings()
    }

    fn begin(&mut self, to: f64, _: &M::Settings, _: Option<&M::Settings>) -> Result<f64, StepFailure> {
        Ok(to)
    }

    fn advance(&mut self, to: &mut f64, settings: &M::Settings, _: &mut Vec<Remark>) -> Result<(), StepFailure> {
        self.model.advance(settings, self.start + self.time, self.start + *to)?;
        self.time = *to;
        Ok(())
    }

    fn is_over(&self, to: &f64) -> bool {
        self.time >= *to
    }

    fn end_at(&mut self, to: &mut f64, time: f64) {
        *to = to.min(time.max(self.time));
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.time);
        self.model.serialize(archive);
    }
}
