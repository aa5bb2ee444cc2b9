//! Parameters, set before a run: one struct per group, one field per parameter of the interface. SI
//! units, angles in rad. Start values and ranges are in [`table`](super::table).
#![expect(missing_docs, reason = "fields are described in the tables of variables")]

use super::ParameterError;
pub use super::choices::{Axial, BeltKind, Drive, Mode, RingModel};
use crate::archive::Archive;
pub use crate::contact::{Contact, Friction};
pub use crate::cylinder::Cylinder;
use crate::pulley::Pulley;
pub use crate::ring::layers::Layers;
pub use crate::ring::{Joints, Ring};
pub use crate::shaft::ShaftDrag;
pub use crate::stack::PushElements;
pub use crate::tilt::{RIGID_TILT_STIFFNESS, Tilt};

/// Lag of a pulley's speed behind its set point in [`Drive::Speed`], s.
pub const SPEED_LAG: f64 = 1e-3;

/// All parameters of a variator. [`Default`] is the laboratory variator `bench168`.
#[derive(Clone, Debug, PartialEq)]
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
pub struct Geometry {
    pub center_distance: f64,
    pub belt_length: f64,
    pub wedge_angle: f64,
    pub pulley_offset: f64,
}

/// Parameters of a pulley with its shaft.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// Elements along the belt. Their borders include and follow the borders of five segments: half
/// secondary arc, upper strand, primary arc, lower strand, half secondary arc.
#[derive(Clone, Debug, Default, PartialEq)]
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
pub struct Solver {
    pub mode: Mode,
    pub effort: i32,
    pub tolerance: f64,
    pub max_step: f64,
    pub input_ramp: f64,
}

/// State that a run starts from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Initial {
    pub ratio: f64,
    pub primary_speed: f64,
    pub steady: bool,
    pub equilibrium: bool,
    pub strict: bool,
}

/// Parameters that the laws use, to which this dereferences, with those that were set. A pull chain
/// has no stack, no layers and no ring that slides on elements; its contact is at its centre line,
/// and its whole mass is that of the ring. The two don't compare:
///
/// ```compile_fail,E0369
/// # use pushbelt::variator::settings::Parameters;
/// let parameters = Parameters::default();
/// assert!(parameters.in_force() == parameters);
/// ```
#[derive(Clone, Debug)]
pub struct ParametersInForce {
    as_set: Parameters,
    laws: Parameters,
}

impl std::ops::Deref for ParametersInForce {
    type Target = Parameters;

    fn deref(&self) -> &Parameters {
        &self.laws
    }
}

impl std::ops::DerefMut for ParametersInForce {
    fn deref_mut(&mut self) -> &mut Parameters {
        &mut self.laws
    }
}

impl ParametersInForce {
    /// The parameters that were set.
    #[must_use]
    pub fn as_set(&self) -> &Parameters {
        &self.as_set
    }

    /// Sets the two tunable friction coefficients. Returns whether one has changed.
    ///
    /// # Errors
    /// A coefficient that is out of its range; nothing was changed.
    pub fn set_friction(&mut self, pulley: f64, ring: f64) -> Result<bool, ParameterError> {
        let present = &self.as_set.friction;
        if (present.pulley, present.ring) == (pulley, ring) {
            return Ok(false);
        }
        let mut changed = self.as_set.clone();
        (changed.friction.pulley, changed.friction.ring) = (pulley, ring);
        changed.validate_friction()?;
        self.laws.friction = changed.in_force().laws.friction;
        self.as_set = changed;
        Ok(true)
    }

    /// Writes the two tunable friction coefficients to an archive, or reads them.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let Friction {
            mut pulley, mut ring, ..
        } = self.as_set.friction;
        archive.real(&mut pulley);
        archive.real(&mut ring);
        if self.set_friction(pulley, ring).is_err() {
            archive.reject();
        }
    }
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
    #[must_use]
    pub fn is_pull_chain(&self) -> bool {
        self.kind == BeltKind::PullChain
    }

    /// Distance e of the pitch line inside the ring centre line, m: 0 for a chain, whose pins touch
    /// the sheaves at its centre line.
    #[must_use]
    pub fn pitch_offset(&self) -> f64 {
        if self.is_pull_chain() {
            0.0
        } else {
            self.belt.pitch_offset
        }
    }

    /// Distance e₁ = e − (n − 1) t/2 of the neutral line of the innermost of the n layers outside the
    /// pitch line, m: the ring slides on the elements there. At least 0, since elements rock inside
    /// the ring.
    #[must_use]
    pub fn saddle_offset(&self) -> f64 {
        let half = 0.5 * f64::from(self.layers.count - 1) * self.layers.thickness;
        (self.pitch_offset() - half).max(0.0)
    }

    /// The parameters that the laws use.
    #[must_use]
    pub fn in_force(&self) -> ParametersInForce {
        let mut laws = self.clone();
        if self.is_pull_chain() {
            laws.ring.mass_per_length += laws.belt.mass_per_length;
            (laws.belt.mass_per_length, laws.belt.play) = (0.0, 0.0);
            laws.belt.pitch_offset = self.pitch_offset();
            (laws.layers.friction, laws.layers.thickness, laws.friction.ring) = (0.0, 0.0, 0.0);
        }
        ParametersInForce {
            as_set: self.clone(),
            laws,
        }
    }

    /// Parameters of a pulley.
    #[must_use]
    pub fn pulley(&self, pulley: Pulley) -> &PulleyParameters {
        match pulley {
            Pulley::Secondary => &self.secondary,
            Pulley::Primary => &self.primary,
        }
    }

    /// Whether a sheave does not move.
    #[must_use]
    pub fn holds_a_sheave(&self) -> bool {
        self.primary.axial == Axial::Held || self.secondary.axial == Axial::Held
    }

    /// Whether no sheave moves.
    #[must_use]
    pub fn holds_both_sheaves(&self) -> bool {
        self.primary.axial == Axial::Held && self.secondary.axial == Axial::Held
    }
}
