//! Parameters, set before a run: one struct per group, one field per parameter of the interface. SI units, angles in rad. Start values and
//! ranges are in [`table`](super::table).

pub use crate::chain::PushElements;
pub use crate::contact::{Contact, Friction};
pub use crate::cylinder::Cylinder;
use crate::pulley::Pulley;
pub use crate::ring::layers::Layers;
pub use crate::ring::{Joints, Ring};
pub use crate::shaft::ShaftDrag;
pub use crate::tilt::{RIGID_TILT_STIFFNESS, Tilt};
pub use crate::variator::settings::choices::{Axial, BeltKind, Drive, Mode, RingModel};

/// Lag of a pulley's speed behind its set point in [`Drive::Speed`], s.
pub const SPEED_LAG: f64 = 1e-3;

/// All parameters of a variator. [`Default`] is the laboratory variator `bench168`.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "said at the type of a group, or in the table of variables")]
pub struct Parameters {
    pub ring_model: RingModel,
    pub spatial: bool,
    pub geometry: Geometry,
    pub kind: BeltKind,
    pub belt: PushElements,
    pub ring: Ring,
    pub layers: Layers,
    pub joints: Joints,
    pub friction: Friction,
    pub contact: Contact,
    pub primary: PulleyParameters,
    pub secondary: PulleyParameters,
    pub mesh: Mesh,
    pub solver: Solver,
    pub initial: Initial,
}

/// Geometry of the drive.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "said once, in the table of variables")]
pub struct Geometry {
    pub center_distance: f64,
    pub belt_length: f64,
    pub wedge_angle: f64,
    pub pulley_offset: f64,
}

/// Parameters of a pulley with its shaft.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "said once, in the table of variables")]
pub struct PulleyParameters {
    pub drive: Drive,
    pub axial: Axial,
    pub inertia: f64,
    pub sheave_mass: f64,
    pub sheave_damping: f64,
    pub tilt: Tilt,
    pub min_radius: f64,
    pub max_radius: f64,
    pub drag: ShaftDrag,
    pub cylinder: Cylinder,
}

/// Elements along the belt. Their borders include the arc borders and move with them: five segments (half secondary arc, upper
/// strand, primary arc, lower strand, half secondary arc).
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "said once, in the table of variables")]
pub struct Mesh {
    pub primary_arc: i32,
    pub secondary_arc: i32,
    pub strand: i32,
    pub cells_per_element: i32,
}

impl Mesh {
    /// Every element divided by `factor`.
    #[must_use]
    pub fn refined(&self, factor: i32) -> Self {
        let [primary_arc, secondary_arc, strand] =
            [self.primary_arc, self.secondary_arc, self.strand].map(|elements| factor * elements);
        Self {
            primary_arc,
            secondary_arc,
            strand,
            ..self.clone()
        }
    }
}

/// Parameters of time integration and of the ramps of inputs.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "said once, in the table of variables")]
pub struct Solver {
    pub mode: Mode,
    pub effort: i32,
    pub tolerance: f64,
    pub max_step: f64,
    pub input_ramp: f64,
}

/// State that a run starts from.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "said once, in the table of variables")]
pub struct Initial {
    pub ratio: f64,
    pub primary_speed: f64,
    pub steady: bool,
    pub equilibrium: bool,
    pub strict: bool,
}

impl Parameters {
    /// Zeros, before the table sets the start values.
    pub(super) fn blank() -> Self {
        Self {
            ring_model: RingModel::default(),
            spatial: false,
            geometry: Geometry::default(),
            kind: BeltKind::default(),
            belt: PushElements::default(),
            ring: Ring::default(),
            layers: Layers::default(),
            joints: Joints::default(),
            friction: Friction::default(),
            contact: Contact::default(),
            primary: PulleyParameters::default(),
            secondary: PulleyParameters::default(),
            mesh: Mesh::default(),
            solver: Solver::default(),
            initial: Initial::default(),
        }
    }

    /// Whether the belt is a pull chain.
    pub fn is_chain(&self) -> bool {
        self.kind == BeltKind::PullChain
    }

    /// Distance e of the pitch line inside the ring centre line, m: 0 for a chain, whose pins touch the sheaves at its centre line.
    pub fn pitch_offset(&self) -> f64 {
        if self.is_chain() { 0.0 } else { self.belt.pitch_offset }
    }

    /// The parameters that the laws use. A pull chain has no stack, no layers and no ring that slides on elements; its contact
    /// is at its centre line, and its whole mass is that of the ring.
    #[must_use]
    pub fn in_force(&self) -> Self {
        let mut of = self.clone();
        if self.is_chain() {
            of.ring.mass_per_length += of.belt.mass_per_length;
            (of.belt.mass_per_length, of.belt.play) = (0.0, 0.0);
            of.belt.pitch_offset = self.pitch_offset();
            (of.layers.friction, of.layers.thickness, of.friction.ring) = (0.0, 0.0, 0.0);
        }
        of
    }

    /// Parameters of a pulley.
    pub fn pulley(&self, pulley: Pulley) -> &PulleyParameters {
        match pulley {
            Pulley::Secondary => &self.secondary,
            Pulley::Primary => &self.primary,
        }
    }

    /// Whether a sheave does not move.
    pub fn holds_a_sheave(&self) -> bool {
        self.primary.axial == Axial::Held || self.secondary.axial == Axial::Held
    }

    /// Whether no sheave moves.
    pub fn holds_both_sheaves(&self) -> bool {
        self.primary.axial == Axial::Held && self.secondary.axial == Axial::Held
    }
}
