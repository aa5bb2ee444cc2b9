//! The values that a master sets.

use crate::variator::settings::{Inputs, Parameters};

/// The values that a master sets. The default is the variator of the default experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Parameters of the variator.
    pub parameters: Parameters,
    /// Inputs of the variator.
    pub inputs: Inputs,
}
