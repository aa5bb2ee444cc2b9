//! A communication step that has begun.

use super::clock::Clock;
use crate::unit::{CommunicationStep, Unit};

/// A communication step in progress.
pub(super) struct StepInProgress<U: Unit> {
    pub step: CommunicationStep<U>,
    /// The communication point at which it ends.
    pub end: Clock,
    /// Whether it ends early.
    pub shortened: bool,
}
