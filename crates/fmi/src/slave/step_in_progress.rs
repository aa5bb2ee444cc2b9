//! A communication step that has begun.

use crate::unit::{CommunicationStep, Unit};

/// A communication step in progress.
pub(super) struct StepInProgress<U: Unit> {
    pub step: CommunicationStep<U>,
    /// The communication point at which it ends, by the master's sum of steps, s.
    pub end: f64,
    /// Whether it ends early.
    pub shortened: bool,
}
