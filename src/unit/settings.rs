//! The values that a master sets.

use crate::variator::settings::table::part;
use crate::variator::settings::{Inputs, Parameters};

/// The values that a master sets. The default is the variator of the default experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings<R = StandardRings> {
    /// Parameters of the variator.
    pub parameters: Parameters,
    /// Inputs of the variator.
    pub inputs: Inputs,
    /// What the unit alone has: of a variator, parameters of the choice of a ring.
    pub own: R,
}

/// The rings of the FMU: `ALE0` and `ALE`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StandardRings;

part!([R] Settings<R> => Parameters: |self| self.parameters);
part!([R] Settings<R> => Inputs: |self| self.inputs);
