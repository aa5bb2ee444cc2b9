//! The settings of a unit; its rings, and the variables that choose among them.

use crate::fmi::table::{Access, Causality, Enumeration, Kind, Retired, Variable};
use crate::fmi::unit::Identity;
use crate::variator::ring_models::BeltRing;
use crate::variator::settings::table::{Row, WHOLE, part};
use crate::variator::settings::{
    Axial, BeltKind, Drive, Inputs, Mode, ParameterError, Parameters, Readings, RingModel, StartState,
};
use std::fmt::Debug;
use std::sync::Arc;

/// The values that an importer sets. The default is the variator of the default experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings<R = StandardRings> {
    /// Parameters of the variator.
    pub parameters: Parameters,
    /// Inputs of the variator.
    pub inputs: Inputs,
    /// Settings of the unit alone: of a variator, the choice of a ring.
    pub own: R,
}

/// The rings of the FMU: `ALE0` and `ALE`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StandardRings;

/// A row of a parameter of the whole variator.
#[must_use]
pub fn parameter<S, Q>(name: &str, reference: u32, text: &str, kind: Kind<S, Q>) -> Variable<S, Q> {
    Row {
        name,
        reference,
        causality: Causality::Parameter,
        text,
        kind,
    }
    .variable(WHOLE)
}

part!([R] Settings<R> => Parameters: |self| self.parameters);
part!([R] Settings<R> => Inputs: |self| self.inputs);

/// The rings that a unit offers, with the parameters that choose among them.
pub trait Rings: Clone + Default + Debug + PartialEq + 'static {
    /// Name of the unit, and what its description suggests.
    const IDENTITY: Identity;

    /// The items of `ring.model`.
    const RING_MODEL: &'static Enumeration;

    /// The enumerations of the unit.
    const ENUMERATIONS: &'static [&'static Enumeration] = &[
        Self::RING_MODEL,
        BeltKind::TYPE,
        Drive::TYPE,
        Axial::TYPE,
        StartState::TYPE,
        Mode::TYPE,
    ];

    /// Variables of earlier versions that the unit no longer has.
    const RETIRED: &'static [Retired];

    /// The variables that choose the ring: `ring.model`, and parameters of rings that no other unit
    /// has.
    fn variables() -> Vec<Variable<Settings<Self>, Readings>>;

    /// The ring that is chosen.
    ///
    /// # Errors
    /// The first parameter of the choice that does not fit the others.
    fn ring(&self, parameters: &Parameters) -> Result<Arc<dyn BeltRing>, ParameterError>;
}

const fn removed(name: &'static str, reference: u32, instead: &'static str) -> Retired {
    Retired {
        name,
        reference,
        instead,
    }
}

/// Variables that no unit has any longer.
pub const REMOVED: [Retired; 2] = [
    removed(
        "belt.contactStrain",
        1036,
        "set belt.roughness, the same strain times belt.elementThickness",
    ),
    removed("belt.filmForce", 1039, "delete it; no force acts across a gap at rest"),
];

/// Those that the FMU of the paper's comparison alone has.
const OF_PAPER: &str = "the FMU of the comparison with the paper has it (cargo fmu build --paper)";

impl Rings for StandardRings {
    const IDENTITY: Identity = Identity {
        version: env!("CARGO_PKG_VERSION"),
        author: "The pushbelt developers",
        license: env!("CARGO_PKG_LICENSE"),
        generation_tool: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
        ..Identity::new(
            "PushbeltVariator",
            "Pushbelt CVT variator: steel ring in reference dynamics (ALE), push elements, wedge contact, tilting sheaves",
        )
    };
    const RING_MODEL: &'static Enumeration = RingModel::TYPE;
    const RETIRED: &'static [Retired] = &[
        REMOVED[0],
        REMOVED[1],
        removed("mesh.aligned", 1075, OF_PAPER),
        removed("ring.referenceDirections", 1048, OF_PAPER),
        removed("ring.elements", 1045, OF_PAPER),
    ];

    fn variables() -> Vec<Variable<Settings, Readings>> {
        let access = Access::Setting {
            get: |settings: &Settings| settings.parameters.ring_model as i32,
            set: |settings: &mut Settings, number| {
                settings.parameters.ring_model = RingModel::from_number(number).unwrap_or_default();
            },
        };
        let (of, text) = (Self::RING_MODEL, "Level of detail of the ring");
        vec![parameter("ring.model", 1001, text, Kind::Enumeration { of, access })]
    }

    fn ring(&self, parameters: &Parameters) -> Result<Arc<dyn BeltRing>, ParameterError> {
        Ok(parameters.ring_of_model())
    }
}
