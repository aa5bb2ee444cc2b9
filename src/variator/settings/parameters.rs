//! Parameters, set before a run: one struct per group, one field per parameter of the interface. SI units, angles in rad.

pub use crate::chain::PushElements;
pub use crate::contact::{Contact, Friction};
pub use crate::cylinder::Cylinder;
use crate::pulley::Pulley;
pub use crate::ring::layers::Layers;
pub use crate::ring::{Joints, Ring};
pub use crate::shaft::ShaftDrag;
pub use crate::tilt::{RIGID_TILT_STIFFNESS, Tilt};

/// Model of the ring inside the variator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum RingModel {
    /// Reference motion only (`q_f` = 0): drift, ratio and a ring tension carried along by friction.
    Ale0 = 1,
    /// Reference motion with overlaid deflection: bending, stretch, spiral running.
    Ale = 2,
}

/// Kind of the belt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum BeltKind {
    /// Push elements on two ring sets: the stack of elements transmits the torque by its push force.
    PushBelt = 1,
    /// Links and rocker pins: the pins are part of the chain, whose tension transmits the torque.
    PullChain = 2,
}

/// Drive of a pulley's shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Drive {
    /// The shaft torque is the input; the speed follows from `J ω̇ = T + belt torque`.
    Torque = 1,
    /// The speed follows its set point with a lag of [`SPEED_LAG`]; the torque that it needs is an output.
    Speed = 2,
}

/// Support of a pulley's movable sheave along its axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Axial {
    /// The clamping force is the input.
    Force = 1,
    /// The sheave is held where the geometric ratio is the initial ratio.
    Held = 2,
}

/// How a run is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Mode {
    /// Steps as the error control requires, each solved.
    Accurate = 1,
    /// Steps of 0.2 ms with a bound on the work of each millisecond. For `ALE0` and `ALE`.
    RealTime = 2,
}

/// Lag of a pulley's speed behind its set point in [`Drive::Speed`], s.
pub const SPEED_LAG: f64 = 1e-3;

/// All parameters of a variator. [`Default`] is the laboratory variator `bench168`.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Model of the ring.
    pub ring_model: RingModel,
    /// Whether the ring deflects along z too, out of the plane of the drive (`ALE`).
    pub spatial: bool,
    /// Pulley distance, belt length, wedge angle.
    pub geometry: Geometry,
    /// Kind of the belt.
    pub kind: BeltKind,
    /// Push elements.
    pub belt: PushElements,
    /// The two ring sets, as one beam.
    pub ring: Ring,
    /// Layers of a ring set, which slip on each other.
    pub layers: Layers,
    /// Joints of a pull chain.
    pub joints: Joints,
    /// Friction coefficients and their regularisation.
    pub friction: Friction,
    /// Element flank on sheave.
    pub contact: Contact,
    /// Primary pulley (driver, at (d_A, 0)).
    pub primary: PulleyParameters,
    /// Secondary pulley (driven, at the origin).
    pub secondary: PulleyParameters,
    /// Discretisation along the belt.
    pub mesh: Mesh,
    /// Tolerance and longest step of time integration.
    pub solver: Solver,
    /// The state the run starts from.
    pub initial: Initial,
}

/// Geometry of the drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Distance of the pulley axes d_A, m.
    pub center_distance: f64,
    /// Length L of the unstretched ring centre line, m.
    pub belt_length: f64,
    /// Half wedge angle β of the sheaves, rad.
    pub wedge_angle: f64,
    /// Axial offset at ratio 1 of the primary pulley's belt plane from the secondary's, along z, where the movable
    /// primary sheave stands, m. It acts on a ring in space.
    pub pulley_offset: f64,
}

/// Parameters of a pulley with its shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct PulleyParameters {
    /// Drive of the shaft.
    pub drive: Drive,
    /// Support of the movable sheave.
    pub axial: Axial,
    /// Moment of inertia J of the pulley and what is rigidly connected to it, kg·m².
    pub inertia: f64,
    /// Mass m_z of the movable sheave, kg.
    pub sheave_mass: f64,
    /// Viscous damping d_z of the sheave's axial motion, N·s/m.
    pub sheave_damping: f64,
    /// Tilt of one sheave: the mean of both.
    pub tilt: Tilt,
    /// Pitch radius at the opening stop, m.
    pub min_radius: f64,
    /// Pitch radius at the closing stop, m.
    pub max_radius: f64,
    /// Drag of the shaft in seals, oil and bearings.
    pub drag: ShaftDrag,
    /// Hydraulic cylinder; all zero: clamping forces alone act.
    pub cylinder: Cylinder,
}

/// Elements along the belt. Their borders include the arc borders and move with them: five segments (half secondary arc, upper
/// strand, primary arc, lower strand, half secondary arc).
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Ring elements on the primary arc.
    pub primary_arc: i32,
    /// Ring elements on the secondary arc; even, since ξ = 0 divides it in two.
    pub secondary_arc: i32,
    /// Ring elements on each strand.
    pub strand: i32,
    /// Chain cells in each ring element; in `ALE0`, whose ring has no elements of its own, it is one.
    pub cells_per_element: i32,
}

impl Mesh {
    /// Every element divided by `factor`.
    #[must_use]
    pub fn refined(&self, factor: i32) -> Self {
        Self {
            primary_arc: factor * self.primary_arc,
            secondary_arc: factor * self.secondary_arc,
            strand: factor * self.strand,
            cells_per_element: self.cells_per_element,
        }
    }
}

/// Parameters of time integration and of the ramps of inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Solver {
    /// How a run is integrated.
    pub mode: Mode,
    /// Work of a millisecond of [`Mode::RealTime`]: so many times 15.5 residuals with their corrections.
    pub effort: i32,
    /// Relative tolerance of the error control.
    pub tolerance: f64,
    /// Longest internal step, s.
    pub max_step: f64,
    /// Time over which a held input ramps to a new value, s, at most the communication step; 0: it jumps,
    /// −1: the whole communication step.
    pub input_ramp: f64,
}

/// State that a run starts from.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Geometric ratio i_g = r_S/r_P at the start.
    pub ratio: f64,
    /// Speed ω_P of the primary pulley at the start, rad/s. 0 is a standstill, negative runs in reverse.
    pub primary_speed: f64,
    /// Start from the steady state at this ratio and speed.
    pub steady: bool,
    /// With `steady`: solve for the ratio too, from the two clamping forces.
    pub equilibrium: bool,
}

impl Parameters {
    /// Whether the belt is a pull chain.
    #[must_use]
    pub fn is_chain(&self) -> bool {
        self.kind == BeltKind::PullChain
    }

    /// Distance e of the pitch line inside the ring centre line, m: 0 for a chain, whose pins touch the sheaves at its centre line.
    #[must_use]
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

impl Default for Parameters {
    fn default() -> Self {
        let pulley = PulleyParameters {
            drive: Drive::Torque,
            axial: Axial::Force,
            inertia: 0.03,
            sheave_mass: 2.0,
            sheave_damping: 1.2e4,
            tilt: Tilt {
                stiffness: 1.79e6,
                clearance: 0.624e-3,
                time: 2.0e-3,
            },
            min_radius: 0.030,
            max_radius: 0.082,
            // Engineering values of a shaft of some 40 mm: T₀ of two lip seals or sealing rings, b of the oil that pulley and
            // bearings splash, μ_b between the catalogue values of ball bearings, 0.0015, and roller bearings, 0.002, at half
            // the bore.
            drag: ShaftDrag {
                constant: 0.15,
                viscous: 4.0e-4,
                bearing_friction: 1.8e-3,
                bearing_radius: 0.02,
            },
            cylinder: Cylinder::default(),
        };
        Self {
            ring_model: RingModel::Ale,
            spatial: false,
            geometry: Geometry {
                center_distance: 0.168,
                belt_length: 0.703,
                wedge_angle: 11.0_f64.to_radians(),
                pulley_offset: 0.0,
            },
            kind: BeltKind::PushBelt,
            belt: PushElements {
                pitch_offset: 1.0e-3,
                play: 2.0e-4,
                mass_per_length: 1.33,
                push_stiffness: 1.0e7,
                damping: 5.0e-6,
                roughness: 1.0e-7,
                element_thickness: 1.5e-3,
                // An element of 2 g and 12 mm: I = m h²/12 = 2.4e-8 as a bar, and m d² = 0.2e-8 with its centre of mass 1 mm
                // below the rocking edge, because the body below the saddle is heavier than the head. All energy of turning lost is
                // an upper bound; half of it is the estimate.
                element_inertia: 1.3e-8,
                film_thickness: 1.5e-6,
                film_damping: 9.0,
                squeeze_damping: 750.0,
                suction: 19.0,
            },
            ring: Ring {
                mass_per_length: 0.24,
                axial_stiffness: 5.57e6,
                bending_stiffness: 0.0159,
                lateral_bending_stiffness: 37.6,
                damping: 2.0e-5,
            },
            // Two sets of nine layers carry half the tension each, which is equivalent to one set that carries all. The
            // friction is an engineering value, oiled steel on steel, as between ring and elements.
            layers: Layers {
                count: 9,
                thickness: 1.85e-4,
                friction: 0.05,
                width: 9.0e-3,
                // 2π/L: layers that were aged and nitrided as circles. An engineering value: rolling may leave another one.
                residual_curvature: 8.94,
            },
            // An engineering value for rocker pins, which roll on each other.
            joints: Joints { radius: 2.0e-5 },
            friction: Friction {
                pulley: 0.09,
                ring: 0.05,
                velocity: 5.0e-4,
                ring_velocity: 2.0e-3,
                fall: 0.06,
                fall_speed: 0.5,
            },
            contact: Contact {
                stiffness: 6.0e10,
                // With 1e-6, waves of 2.6 kHz grow where the belt enters an arc on the default mesh, but not on twice the elements.
                damping: 3.0e-6,
                roughness: 1.0e-7,
            },
            primary: pulley.clone(),
            secondary: pulley,
            mesh: Mesh {
                primary_arc: 16,
                secondary_arc: 16,
                strand: 10,
                cells_per_element: 2,
            },
            solver: Solver {
                mode: Mode::Accurate,
                effort: 4,
                tolerance: 1.0e-4,
                max_step: 1.0e-2,
                input_ramp: 1.0e-3,
            },
            initial: Initial {
                ratio: 1.0,
                primary_speed: 209.44,
                steady: true,
                equilibrium: false,
            },
        }
    }
}
