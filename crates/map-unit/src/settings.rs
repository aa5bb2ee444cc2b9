//! What a master sets and reads. Names, units and defaults of the variables are those of the detailed unit.

use std::sync::Arc;

use crate::tables::Tables;

/// Boundary condition of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Drive {
    /// The torque is the input.
    Torque = 1,
    /// The speed follows its set point.
    Speed = 2,
}

/// Boundary condition of a movable sheave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Axial {
    /// The clamping force is the input.
    Force = 1,
    /// The ratio is held.
    Held = 2,
}

/// Inputs of a pulley.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulleyInputs {
    /// External torque, N·m.
    pub torque: f64,
    /// Clamping force, N.
    pub clamping_force: f64,
    /// Speed set point, rad/s.
    pub speed_setpoint: f64,
    /// Pressure in the cylinder above ambient, Pa.
    pub pressure: f64,
}

/// Inputs of the variator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// Of the primary pulley.
    pub primary: PulleyInputs,
    /// Of the secondary pulley.
    pub secondary: PulleyInputs,
}

impl Inputs {
    /// Inputs as an array, for sums.
    #[must_use]
    pub fn array(&self) -> [f64; 8] {
        let Self { primary, secondary } = self;
        [
            primary.torque,
            primary.clamping_force,
            primary.speed_setpoint,
            primary.pressure,
            secondary.torque,
            secondary.clamping_force,
            secondary.speed_setpoint,
            secondary.pressure,
        ]
    }

    /// The inverse of [`Inputs::array`].
    #[must_use]
    pub fn of_array(values: [f64; 8]) -> Self {
        let pulley = |k: usize| PulleyInputs {
            torque: values[k],
            clamping_force: values[k + 1],
            speed_setpoint: values[k + 2],
            pressure: values[k + 3],
        };
        Self {
            primary: pulley(0),
            secondary: pulley(4),
        }
    }
}

/// Parameters of the cylinder of a pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cylinder {
    /// Area of the piston, m².
    pub area: f64,
    /// Force of the spring at ratio 1, N.
    pub spring_force: f64,
    /// Stiffness of the spring, N/m.
    pub spring_stiffness: f64,
    /// Closing force of the rotating oil per square of the speed, N·s²/rad².
    pub centrifugal: f64,
    /// Friction of the seals, N.
    pub seal: f64,
}

/// Parameters of a pulley.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulleyParameters {
    /// Boundary condition of the shaft.
    pub drive: Drive,
    /// Boundary condition of the movable sheave.
    pub axial: Axial,
    /// Moment of inertia, kg·m².
    pub inertia: f64,
    /// Pitch radius at the opening stop, m.
    pub min_radius: f64,
    /// Pitch radius at the closing stop, m.
    pub max_radius: f64,
    /// Drag torque that depends neither on speed nor on load, N·m.
    pub drag_constant: f64,
    /// Drag torque per speed, N·m·s/rad.
    pub drag_viscous: f64,
    /// Friction coefficient of the bearings.
    pub bearing_friction: f64,
    /// Mean radius of the bearings, m.
    pub bearing_radius: f64,
    /// Cylinder.
    pub cylinder: Cylinder,
}

/// Parameters and inputs, with the tables.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Geometric ratio at the start.
    pub ratio: f64,
    /// Primary speed at the start, rad/s.
    pub primary_speed: f64,
    /// Whether a run starts with the slip of the steady state.
    pub steady: bool,
    /// Whether a run starts at the ratio at which the clamping forces are in equilibrium.
    pub equilibrium: bool,
    /// Friction coefficient between element and sheave.
    pub friction: f64,
    /// Time over which an input ramps to its new value, s.
    pub ramp: f64,
    /// Of the primary pulley.
    pub primary: PulleyParameters,
    /// Of the secondary pulley.
    pub secondary: PulleyParameters,
    /// Inputs.
    pub inputs: Inputs,
    /// Tables from the resources; none in the settings of the model description.
    pub tables: Option<Arc<Tables>>,
}

const PULLEY: PulleyParameters = PulleyParameters {
    drive: Drive::Torque,
    axial: Axial::Force,
    inertia: 0.03,
    min_radius: 0.03,
    max_radius: 0.082,
    drag_constant: 0.15,
    drag_viscous: 4e-4,
    bearing_friction: 1.8e-3,
    bearing_radius: 0.02,
    cylinder: Cylinder {
        area: 0.0,
        spring_force: 0.0,
        spring_stiffness: 0.0,
        centrifugal: 0.0,
        seal: 0.0,
    },
};

impl Default for Settings {
    fn default() -> Self {
        let inputs = |torque, clamping_force| PulleyInputs {
            torque,
            clamping_force,
            speed_setpoint: 209.44,
            pressure: 0.0,
        };
        Self {
            ratio: 1.0,
            primary_speed: 209.44,
            steady: true,
            equilibrium: false,
            friction: 0.09,
            ramp: 1e-3,
            primary: PULLEY,
            secondary: PULLEY,
            inputs: Inputs {
                primary: inputs(50.0, 13e3),
                secondary: inputs(-49.0, 10e3),
            },
            tables: None,
        }
    }
}

/// Outputs of a pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PulleyOutputs {
    /// Speed, rad/s.
    pub speed: f64,
    /// Pitch radius, m.
    pub radius: f64,
    /// Axial force of the belt, N: in maps the whole force that closes the pulley.
    pub axial_force: f64,
    /// Speed of the movable sheave, closing positive, m/s.
    pub sheave_velocity: f64,
    /// Flow into the cylinder, m³/s.
    pub flow: f64,
    /// Torque of the belt on the pulley, N·m.
    pub shaft_torque: f64,
    /// External torque on the shaft, N·m.
    pub external_torque: f64,
    /// Power from the shaft into the belt, W.
    pub power: f64,
}

/// Outputs and locals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Axial force primary/secondary.
    pub thrust_ratio: f64,
    /// Mean speed of the belt at the pitch line, m/s.
    pub belt_speed: f64,
    /// Primary speed / secondary speed.
    pub ratio_speed: f64,
    /// r_S/r_P.
    pub ratio_geometric: f64,
    /// 1 − (ω_S/ω_P) i.
    pub slip: f64,
    /// Driven / driving shaft power.
    pub efficiency: f64,
    /// Driven / driving power at the belt.
    pub belt_efficiency: f64,
    /// Absolute torque utilisation.
    pub utilisation: f64,
    /// Whether the belt slips through.
    pub macro_slip: bool,
    /// All losses, W.
    pub loss: f64,
    /// Drag loss of both shafts, W.
    pub shaft_loss: f64,
    /// Friction loss of the seals, W.
    pub seal_loss: f64,
    /// Kinetic energy of both shafts, J.
    pub stored_energy: f64,
    /// Whether the state is beyond the tables.
    pub outside: bool,
    /// Of the primary pulley.
    pub primary: PulleyOutputs,
    /// Of the secondary pulley.
    pub secondary: PulleyOutputs,
}
