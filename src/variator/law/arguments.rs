//! Arguments and results of the cell law: constants, place, motion, balance.

use crate::contact::{Contact, Friction};
use crate::pulley::{PerPulley, Wedge};
use crate::reference_curve::Jet;
use crate::ring::kinematics::{Motion, ReferenceMotion};
use crate::ring::layers::Layers;
use crate::ring::{Joints, Ring};
use crate::scalar::Real;
use crate::solver::Factors;
use crate::stack::{self, Transport};
use crate::variator::law::element_rotation::rotation_drag_coefficients;
use crate::variator::mesh::belt_mesh::Station;

/// Constants of the cell law.
#[derive(Clone, Debug)]
pub struct CellLaw {
    /// The push elements.
    pub stack: stack::PushElements,
    /// The ring sets, as one beam.
    pub ring: Ring,
    /// The ring's layers.
    pub layers: Layers,
    /// The joints of a pull chain; `None` for a pushbelt.
    pub joints: Option<Joints>,
    /// Mass m_r per length whose centrifugal force reduces the normal load of the ring, kg/m: that
    /// of the ring; 0 for the joints of a chain, which carry the whole tension.
    pub saddle_mass: f64,
    /// Distance e₁ of the neutral line of the innermost layer outside the pitch line, m.
    pub saddle_offset: f64,
    /// The contact between flank and sheave.
    pub contact: Contact,
    /// Wedge of the sheaves.
    pub wedge: Wedge,
    /// Pitch radius of unloaded contact at ratio 1, m.
    pub r0: f64,
    /// Pulley axes, x coordinate, m.
    pub axes: PerPulley<f64>,
    /// Position of the sheaves along z.
    pub planes: PerPulley<SheavePlane>,
}

/// The middle of a pulley along z: it moves by half the travel of the movable sheave, away from
/// that sheave. The movable sheaves are on opposite sides of the belt, so both middles move in the
/// same direction when the ratio changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheavePlane<L = f64> {
    /// Side of the movable sheave: +1 or −1 along z.
    pub side: L,
    /// Middle of the pulley at z_j = 0, m.
    pub middle: L,
}

/// Coefficients of drag on the arc of each pulley.
#[derive(Clone, Copy, Debug)]
pub struct ArcDrags<T> {
    /// [`CellGeometry::layer_drag`].
    pub layers: PerPulley<T>,
    /// [`CellGeometry::rotation_drag`], kg/m.
    pub rotation: PerPulley<T>,
}

impl CellLaw {
    /// Whether the belt is a pull chain.
    #[inline(always)]
    #[must_use]
    pub fn is_pull_chain(&self) -> bool {
        self.joints.is_some()
    }

    /// Drag on the arcs of a ring with these radii, m, and wrap angles, rad, the secondary first.
    #[inline(always)]
    #[must_use]
    pub fn arc_drags<T: Real>(&self, radii: [T; 2], wraps: [T; 2]) -> ArcDrags<T> {
        let radii = radii.map(|radius| radius - self.stack.pitch_offset);
        let [radii, wraps] = [radii, wraps].map(|[secondary, primary]| PerPulley { secondary, primary });
        let layers = match self.joints {
            Some(joints) => joints.drag_coefficients(radii, wraps),
            None => self.layers.drag_coefficients(radii),
        };
        let rotation = rotation_drag_coefficients(&self.stack, radii, wraps);
        ArcDrags { layers, rotation }
    }
}

impl SheavePlane {
    /// Planes that are `offset` apart at ratio 1, m.
    #[must_use]
    pub fn pair(offset: f64) -> PerPulley<Self> {
        PerPulley {
            secondary: -1.0,
            primary: 1.0,
        }
        .map(|side| Self {
            side,
            middle: 0.5 * side * offset,
        })
    }

    /// Middle of the pulley at the axial position `z` of the sheave, m.
    #[must_use]
    pub fn middle(&self, z: f64) -> f64 {
        self.middle - 0.5 * self.side * z
    }
}

/// Motion of a pulley: sheave, tilt, shaft.
#[derive(Clone, Copy, Debug)]
pub struct PulleyMotion<T> {
    /// Axial position z of the sheave, m.
    pub z: T,
    /// Axial speed ż of the sheave, m/s.
    pub z_dot: T,
    /// Tilt ψ_x, ψ_y of the sheaves, rad.
    pub psi: [T; 2],
    /// Rates of the tilt, rad/s.
    pub psi_dot: [T; 2],
    /// Angular speed ω, rad/s.
    pub omega: T,
}

/// State of a cell without the ring.
#[derive(Clone, Copy, Debug)]
pub struct CellMotion<T: Real> {
    /// V at the faces, m/s.
    pub speed: [T; 2],
    /// V̇ at the faces, m/s².
    pub speed_dot: [T; 2],
    /// Content N of elements, m.
    pub content: T,
    /// Motion of the reference curve and drift of the ring.
    pub reference: ReferenceMotion<T>,
    /// The pulley this cell can touch.
    pub pulley: PulleyMotion<T>,
}

/// Position, value or rate of an unknown.
#[derive(Clone, Copy, Debug)]
pub enum StateComponent {
    /// The position q.
    Position,
    /// The unknown y.
    Value,
    /// Its rate ẏ.
    Rate,
}

impl StateComponent {
    /// Derivative with respect to the unknown.
    #[inline(always)]
    #[must_use]
    pub fn derivative(self, factors: Factors) -> f64 {
        match self {
            Self::Position => factors.beta,
            Self::Value => 1.0,
            Self::Rate => factors.alpha,
        }
    }
}

/// First degrees of freedom of a cell, without the ring's.
#[derive(Clone, Copy, Debug)]
pub struct FirstUnknowns {
    /// First of V, V, N.
    pub own: usize,
    /// First of s, Θ.
    pub drift: usize,
    /// First of z, ψ_x, ψ_y, ω.
    pub sheave: usize,
}

impl<T: Real> CellMotion<T> {
    /// The motion, where `unknown` returns a component of a degree of freedom.
    #[inline(always)]
    pub fn from_unknowns(
        FirstUnknowns { own, drift, sheave }: FirstUnknowns,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Self {
        let value = |k: usize| unknown(StateComponent::Value, k);
        let rate = |k: usize| unknown(StateComponent::Rate, k);
        let theta = drift + 1;
        let tilt = [sheave + 1, sheave + 2];
        Self {
            speed: [value(own), value(own + 1)],
            speed_dot: [rate(own), rate(own + 1)],
            content: value(own + 2),
            reference: ReferenceMotion {
                theta: Motion {
                    value: unknown(StateComponent::Position, theta),
                    rate: value(theta),
                    acceleration: rate(theta),
                },
                s_dot: value(drift),
                s_ddot: rate(drift),
            },
            pulley: PulleyMotion {
                z: unknown(StateComponent::Position, sheave),
                z_dot: value(sheave),
                psi: tilt.map(value),
                psi_dot: tilt.map(rate),
                omega: value(sheave + 3),
            },
        }
    }
}

/// Load of the belt or of a part of it on a pulley.
#[derive(Clone, Copy, Debug, Default)]
pub struct PulleyLoad<T = f64> {
    /// Axial force on one sheave, N.
    pub axial: T,
    /// Moment of the axial force on one sheave, N·m.
    pub tilting: [T; 2],
    /// Torque on the pulley, N·m.
    pub torque: T,
    /// Resultant of the contact forces on the belt, N; its negative acts on the pulley's shaft.
    pub resultant: [T; 2],
}

impl<T: Copy> PulleyLoad<T> {
    /// Applies `f` to each component.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> PulleyLoad<U> {
        PulleyLoad {
            axial: f(self.axial),
            tilting: self.tilting.map(&f),
            torque: f(self.torque),
            resultant: self.resultant.map(&f),
        }
    }
}

impl<T: Real> PulleyLoad<T> {
    /// Adds `on` times another load.
    #[inline(always)]
    pub fn add(&mut self, other: &Self, on: T) {
        self.axial += other.axial * on;
        self.torque += other.torque * on;
        for k in 0..2 {
            self.tilting[k] += other.tilting[k] * on;
            self.resultant[k] += other.resultant[k] * on;
        }
    }
}

/// Generalised forces of a cell (inertia − forces), without those on the ring, and its flow.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellBalance<T> {
    /// Conjugates of V at the faces, N.
    pub speed: [T; 2],
    /// Load on the pulley.
    pub pulley: PulleyLoad<T>,
    /// Quantities that determine the fluxes of elements.
    pub transport: Transport<T>,
}

/// Place of an element on its segment, as fractions of the segment.
#[derive(Clone, Copy, Debug)]
pub struct Extent<L> {
    /// Start.
    pub start: L,
    /// Length.
    pub length: L,
}

/// Geometry of cells.
#[derive(Debug)]
pub struct CellGeometry<'a, T: Real> {
    /// Place of the element.
    pub extent: Extent<T::Constant>,
    /// Left face; fractions refer to the element.
    pub face: &'a Station<T::Constant>,
    /// Quadrature points.
    pub stations: &'a [Station<T::Constant>],
    /// Pulley axis, x coordinate, m.
    pub axis: T::Constant,
    /// Position of the sheaves along z.
    pub plane: SheavePlane<T::Constant>,
    /// Length of the element.
    pub length: Jet<T>,
    /// Drag of the ring's layers, or of a chain's joints, on the nearest arc, over the normal load.
    pub layer_drag: T,
    /// Drag of elements that start and stop turning, on the nearest arc: I/(h R² α), kg/m.
    pub rotation_drag: T,
}

impl<T: Real> CellGeometry<'_, T> {
    /// The face (0) or a station (1 and up).
    #[inline(always)]
    #[must_use]
    pub fn point(&self, at: usize) -> &Station<T::Constant> {
        if at == 0 { self.face } else { &self.stations[at - 1] }
    }

    /// Fraction of the segment at the face or a station.
    #[inline(always)]
    #[must_use]
    pub fn fraction(&self, at: usize) -> T::Constant {
        let Extent { start, length } = self.extent;
        start + length * self.point(at).fraction
    }
}

/// Arguments of the cell law.
#[derive(Clone, Copy, Debug)]
pub struct CellInput<'a, T: Real> {
    /// Constants of the laws.
    pub law: &'a CellLaw,
    /// Friction in force.
    pub friction: &'a Friction,
    /// Geometry of the cell.
    pub geometry: &'a CellGeometry<'a, T>,
    /// State of the cell without the ring.
    pub motion: &'a CellMotion<T>,
}

/// Linear interpolation between the two faces of a cell.
#[inline(always)]
pub fn between<T: Real>(faces: &[T; 2], right: T::Constant) -> T {
    faces[0] * (-right + 1.0) + faces[1] * right
}

/// Weight of a face in [`between`]: 0 the left one, 1 the right one.
#[inline(always)]
pub fn face_weight<T: Real>(face: usize, right: T::Constant) -> T {
    T::constant(if face == 0 { -right + 1.0 } else { right })
}
