//! Loads on the pulleys as inputs of the linear model.

use faer::Mat;

use crate::pulley::Pulley;
use crate::variator::linear::working_point::WorkingPoint;
use crate::variator::pulleys::loads::{Boundary, ShaftMode, SheaveMode};
use crate::variator::settings::parameters::{Axial, Drive, Parameters, SPEED_LAG};
use crate::variator::settings::signals::Inputs;
use crate::variator::system::VariatorSystem;

/// An input of the linear model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// Clamping force of a pulley, N.
    ClampingForce(Pulley),
    /// Pressure in the cylinder of a pulley, Pa.
    Pressure(Pulley),
    /// External torque on a pulley's shaft, N·m.
    Torque(Pulley),
    /// Speed set point of a pulley, rad/s.
    SpeedSetpoint(Pulley),
}

impl Load {
    /// The input among all `inputs`.
    pub fn field(self, inputs: &mut Inputs) -> &mut f64 {
        let Inputs { primary, secondary } = inputs;
        let (Self::ClampingForce(j) | Self::Pressure(j) | Self::Torque(j) | Self::SpeedSetpoint(j)) = self;
        let pulley = match j {
            Pulley::Primary => primary,
            Pulley::Secondary => secondary,
        };
        match self {
            Self::ClampingForce(_) => &mut pulley.clamping_force,
            Self::Pressure(_) => &mut pulley.pressure,
            Self::Torque(_) => &mut pulley.torque,
            Self::SpeedSetpoint(_) => &mut pulley.speed_setpoint,
        }
    }

    /// Adds a change of the input to the boundary conditions.
    pub(super) fn change(self, by: f64, system: &VariatorSystem, boundary: &mut Boundary) {
        let (Self::ClampingForce(j) | Self::Pressure(j) | Self::Torque(j) | Self::SpeedSetpoint(j)) = self;
        match (self, &mut boundary.sheave[j], &mut boundary.shaft[j]) {
            (Self::ClampingForce(_), SheaveMode::Force(force), _) => *force += by,
            (Self::Pressure(_), SheaveMode::Force(force), _) => {
                *force += system.parameters.pulley(j).cylinder.area * by
            }
            (Self::Torque(_) | Self::SpeedSetpoint(_), _, ShaftMode::Torque(load) | ShaftMode::Setpoint(load)) => {
                *load += by;
            }
            _ => {}
        }
    }

    /// Name of the variable of the FMU.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ClampingForce(Pulley::Primary) => "primary.clampingForce",
            Self::ClampingForce(Pulley::Secondary) => "secondary.clampingForce",
            Self::Pressure(Pulley::Primary) => "primary.pressure",
            Self::Pressure(Pulley::Secondary) => "secondary.pressure",
            Self::Torque(Pulley::Primary) => "primary.torque",
            Self::Torque(Pulley::Secondary) => "secondary.torque",
            Self::SpeedSetpoint(Pulley::Primary) => "primary.speedSetpoint",
            Self::SpeedSetpoint(Pulley::Secondary) => "secondary.speedSetpoint",
        }
    }
}

/// Inputs that act with these parameters.
pub(super) fn loads_in_force(parameters: &Parameters) -> Vec<Load> {
    let mut loads = Vec::new();
    for (j, pulley) in [
        (Pulley::Primary, &parameters.primary),
        (Pulley::Secondary, &parameters.secondary),
    ] {
        loads.push(match pulley.drive {
            Drive::Torque => Load::Torque(j),
            Drive::Speed => Load::SpeedSetpoint(j),
        });
        if pulley.axial == Axial::Force {
            loads.push(Load::ClampingForce(j));
            if pulley.cylinder.area > 0.0 {
                loads.push(Load::Pressure(j));
            }
        }
    }
    loads
}

/// B of the descriptor system: the negative derivatives of the residual by the loads.
pub(super) fn load_columns(system: &VariatorSystem, loads: &[Load], size: usize) -> Mat<f64> {
    let mut b = Mat::<f64>::zeros(size, loads.len());
    for (l, load) in loads.iter().enumerate() {
        let (row, factor) = match *load {
            Load::ClampingForce(j) => (system.belt.layout.sheave(j), 1.0),
            Load::Pressure(j) => (system.belt.layout.sheave(j), system.parameters.pulley(j).cylinder.area),
            Load::Torque(j) => (system.belt.layout.shaft_speed(j), 1.0),
            Load::SpeedSetpoint(j) => (
                system.belt.layout.shaft_speed(j),
                system.parameters.pulley(j).inertia / SPEED_LAG,
            ),
        };
        b[(row, l)] = factor;
    }
    b
}

/// Largest relative difference between a specified load and the required one that causes no remark.
const SAME: f64 = 0.01;
/// Least sizes of loads in this comparison, N and N·m: drag alone changes a torque of zero.
const SMALL_FORCE: f64 = 5.0e3;
const SMALL_TORQUE: f64 = 50.0;

/// Differences from the specified working point, one sentence each.
pub(super) fn departures(loads: &[Load], point: &WorkingPoint) -> Vec<String> {
    let mut found = Vec::new();
    if point.outputs.macro_slip {
        found.push(format!(
            "the belt slips through (macroSlip): slip = {:.3}",
            point.outputs.slip
        ));
    }
    let (mut given, mut held) = (point.given, point.inputs);
    for load in loads {
        let (given, held) = (*load.field(&mut given), *load.field(&mut held));
        let (unit, small) = match load {
            Load::ClampingForce(_) => ("N", SMALL_FORCE),
            Load::Pressure(j) => ("Pa", SMALL_FORCE / point.system.parameters.pulley(*j).cylinder.area),
            Load::Torque(_) => ("N.m", SMALL_TORQUE),
            // The set point is the speed of the point.
            Load::SpeedSetpoint(_) => continue,
        };
        if (held - given).abs() > SAME * given.abs().max(held.abs()).max(small) {
            let name = load.name();
            found.push(format!(
                "this point requires {name} = {held:.2} {unit}, but {given} {unit} is specified"
            ));
        }
    }
    found
}
