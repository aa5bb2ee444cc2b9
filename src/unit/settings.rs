//! The values that a master sets.

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

macro_rules! holds {
    ($field:ident: $of:ty) => {
        impl<R> AsRef<$of> for Settings<R> {
            fn as_ref(&self) -> &$of {
                &self.$field
            }
        }

        impl<R> AsMut<$of> for Settings<R> {
            fn as_mut(&mut self) -> &mut $of {
                &mut self.$field
            }
        }
    };
}
holds!(parameters: Parameters);
holds!(inputs: Inputs);
