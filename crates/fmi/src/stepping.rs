//! What a model offers to a master that watches its own steps, as FMI 3.0 lets it.

use super::unit::{Remark, StepFailure, Unit};

/// A unit whose communication steps can be watched. Left alone, its own steps come to what [`Unit::advance`] comes to, bit for bit.
pub trait OwnSteps: Unit {
    /// A communication step on its way.
    type Way;

    /// Begins a communication step to time `to`, with settings and rates as in [`Unit::advance`].
    ///
    /// # Errors
    /// A setting is out of its range; nothing was changed.
    fn set_out(
        &mut self,
        to: f64,
        settings: &Self::Settings,
        rates: Option<&Self::Settings>,
    ) -> Result<Self::Way, StepFailure>;

    /// Whether the end of a way is reached.
    fn is_over(&self, way: &Self::Way) -> bool;

    /// Goes on by one own step. Inputs that differ from those of the step before count from here on. Readings are those of the
    /// time reached.
    ///
    /// # Errors
    /// See [`StepFailure`]; the way ends there.
    fn own_step(
        &mut self,
        way: &mut Self::Way,
        settings: &Self::Settings,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), StepFailure>;

    /// What has happened since the way began that a master may want to handle, in words.
    fn event(&self, way: &Self::Way) -> Option<String>;

    /// Lets a way end at a time, s, or where it is if that is past. It never becomes longer.
    fn end_at(&mut self, way: &mut Self::Way, time: f64);

    /// Ends the communication step where its way has led.
    fn arrive(&mut self, way: &Self::Way, remarks: &mut Vec<Remark>);
}
