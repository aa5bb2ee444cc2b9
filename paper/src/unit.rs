//! `PushbeltPaper.fmu`: the variator with the belts of the paper's comparison, and the variables
//! that select one.

use crate::belts::{Rotated, Travels, variant};
use crate::centred::Centred;
use crate::ring::ancf::AncfElement;
use crate::ring::rcm::RcmElement;
use pushbelt::fmi::setting;
use pushbelt::fmi::table::{Access, Enumeration, Item, Kind, Retired, Variable};
use pushbelt::fmi::unit::Identity;
use pushbelt::unit::{REMOVED, Rings, Settings, StandardRings, UnitWith, parameter};
use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing};
use pushbelt::variator::settings::{ParameterError, Parameters, Readings, RingModel};
use std::sync::Arc;

/// The unit of `PushbeltPaper.fmu`.
pub type PaperUnit = UnitWith<PaperRings>;

/// The content of its `modelDescription.xml`.
#[must_use]
pub fn model_description() -> String {
    pushbelt::fmi::model_description::<PaperUnit>(pushbelt::fmi::Version::Two, None)
}

const RCM: i32 = 3;
const ANCF: i32 = 4;
const CENTRED: i32 = 5;

static RING_MODEL: Enumeration = Enumeration {
    name: "RingModel",
    description: "Model of the ring",
    items: &[
        Item::new(
            "ALE0",
            RingModel::Ale0 as i32,
            "Reference motion only: drift, ratio and a ring tension carried along by friction",
        ),
        Item::new(
            "ALE",
            RingModel::Ale as i32,
            "Reference motion with overlaid deflection: bending, stretch, spiral running",
        ),
        Item::new("RCM", RCM, "Co-rotational elements that travel with the ring"),
        Item::new(
            "ANCF",
            ANCF,
            "Absolute nodal coordinates on elements that travel with the ring",
        ),
        Item::new(
            "ALE0Centred",
            CENTRED,
            "ALE0 with arcs about the axes of the pulleys, as in the paper",
        ),
    ],
};

/// The parameters that select one of the paper's belts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PaperRings {
    /// Number of the ring model, an item of `ring.model`.
    pub model: i32,
    /// Whether element borders follow the arc borders.
    pub aligned: bool,
    /// Whether the deflection is along the directions of the reference curve.
    pub reference_directions: bool,
    /// Whether derivatives are computed by forward differentiation.
    pub forward: bool,
    /// Number of elements of a travelling ring; 0 for the default.
    pub elements: i32,
}

impl Default for PaperRings {
    fn default() -> Self {
        Self {
            model: RingModel::Ale as i32,
            aligned: true,
            reference_directions: false,
            forward: false,
            elements: 0,
        }
    }
}

impl PaperRings {
    /// Checks these parameters among themselves.
    ///
    /// # Errors
    /// The first parameter that does not fit the others.
    pub fn check(&self) -> Result<(), ParameterError> {
        let is_ale = self.model == RingModel::Ale as i32;
        if !self.aligned && [RCM, ANCF, CENTRED].contains(&self.model) {
            let range = "true, unless ring.model is ALE0 or ALE";
            return Err(ParameterError::new("mesh.aligned", false, range));
        }
        if self.reference_directions && !(is_ale && self.aligned) {
            let range = "false, unless ring.model is ALE and mesh.aligned is true";
            return Err(ParameterError::new("ring.referenceDirections", true, range));
        }
        if self.forward && (!self.aligned || self.model == CENTRED) {
            let range = "false, unless mesh.aligned is true and ring.model is another than ALE0Centred";
            return Err(ParameterError::new("solver.forward", true, range));
        }
        if self.elements < 0 {
            let range = "0 for the ring model's usual number, or 16 to 400";
            return Err(ParameterError::new("ring.elements", self.elements, range));
        }
        Ok(())
    }
}

impl Rings for PaperRings {
    const IDENTITY: Identity = Identity {
        name: "PushbeltPaper",
        description: "Pushbelt CVT variator with the rings that the paper compares: ALE, ALE0, RCM, ANCF",
        ..StandardRings::IDENTITY
    };
    const RING_MODEL: &'static Enumeration = &RING_MODEL;
    const RETIRED: &'static [Retired] = &REMOVED;

    fn variables() -> Vec<Variable<Settings<Self>, Readings>> {
        let model = Access::Setting {
            get: |settings: &Settings<Self>| settings.own.model,
            set: |settings: &mut Settings<Self>, number| {
                settings.own.model = number;
                settings.parameters.ring_model = if [RingModel::Ale0 as i32, CENTRED].contains(&number) {
                    RingModel::Ale0
                } else {
                    RingModel::Ale
                };
            },
        };
        let of = &RING_MODEL;
        vec![
            parameter(
                "ring.model",
                1001,
                "Model of the ring",
                Kind::Enumeration { of, access: model },
            ),
            parameter(
                "ring.referenceDirections",
                1048,
                "Whether the deflection is counted along tangent, normal and binormal of the reference curve instead of \
                 along x, y, z; ring.model ALE with mesh.aligned only",
                Kind::Boolean {
                    access: setting!(own.reference_directions),
                },
            ),
            parameter(
                "ring.elements",
                1045,
                "Elements of a ring that travels with its mesh (RCM, ANCF), 16 to 400; 0: 32 for RCM, 40 for ANCF. More \
                 of them need a finer mesh of the cells, which carry the ring in between",
                Kind::Integer {
                    range: None,
                    access: setting!(own.elements),
                },
            ),
            parameter(
                "mesh.aligned",
                1075,
                "Whether element borders follow the arc borders; if not, as many elements are spaced evenly along the belt \
                 and arc borders move through them. ring.model ALE0 and ALE",
                Kind::Boolean {
                    access: setting!(own.aligned),
                },
            ),
            parameter(
                "solver.forward",
                1999,
                "Whether ALE0 and ALE have derivatives by forward differentiation, as RCM, ANCF and ring.referenceDirections \
                 have them, instead of derivatives by hand; mesh.aligned only",
                Kind::Boolean {
                    access: setting!(own.forward),
                },
            ),
        ]
    }

    fn ring(&self, parameters: &Parameters) -> Result<Arc<dyn BeltRing>, ParameterError> {
        self.check()?;
        let elements = usize::try_from(self.elements).unwrap_or_default();
        Ok(match (self.model, parameters.spatial) {
            (RCM, _) => Arc::new(Travels::<RcmElement>::new(elements)),
            (ANCF, _) => Arc::new(Travels::<AncfElement>::new(elements)),
            (CENTRED, _) => Arc::new(Centred),
            (number, _) if number == RingModel::Ale0 as i32 => variant(Ale0, self.aligned, self.forward),
            (_, false) if self.reference_directions => Arc::new(Rotated::<2>),
            (_, true) if self.reference_directions => Arc::new(Rotated::<3>),
            (_, false) => variant(Ale::<2>, self.aligned, self.forward),
            (_, true) => variant(Ale::<3>, self.aligned, self.forward),
        })
    }
}
