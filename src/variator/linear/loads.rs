//! Loads on the pulleys as inputs of the linear model.

use faer::Mat;

use crate::pulley::Pulley;
use crate::solver::System;
use crate::variator::linear::working_point::WorkingPoint;
use crate::variator::linear::{FORCE_SCALE, SAME, TORQUE_SCALE};
use crate::variator::pulleys::loads::Loads;
use crate::variator::settings::parameters::{Axial, Drive, Parameters};
use crate::variator::settings::signals::Inputs;

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

    /// Name of the variable of the FMU.
    #[must_use]
    pub fn name(self) -> &'static str {
        let (pulley, [primary, secondary]) = match self {
            Self::ClampingForce(j) => (j, ["primary.clampingForce", "secondary.clampingForce"]),
            Self::Pressure(j) => (j, ["primary.pressure", "secondary.pressure"]),
            Self::Torque(j) => (j, ["primary.torque", "secondary.torque"]),
            Self::SpeedSetpoint(j) => (j, ["primary.speedSetpoint", "secondary.speedSetpoint"]),
        };
        match pulley {
            Pulley::Primary => primary,
            Pulley::Secondary => secondary,
        }
    }
}

/// Inputs that act with these parameters.
pub(super) fn loads_in_force(parameters: &Parameters) -> Vec<Load> {
    let mut loads = Vec::new();
    for j in [Pulley::Primary, Pulley::Secondary] {
        let pulley = parameters.pulley(j);
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

/// B of the descriptor system: the negative derivatives of the residual by the loads, in which it is linear.
pub(super) fn load_columns(point: &mut WorkingPoint, loads: &[Load], size: usize) -> Mat<f64> {
    let (system, state, mut inputs) = (&mut point.system, &point.state, point.inputs);
    let mut residual = |inputs: &Inputs| {
        let mut out = vec![0.0; state.y.len()];
        system.loads = Loads::held(inputs);
        system.residual(0.0, state.view(), &mut out);
        out
    };
    let without = residual(&inputs);
    let mut b = Mat::<f64>::zeros(size, loads.len());
    for (l, load) in loads.iter().enumerate() {
        let given = *load.field(&mut inputs);
        *load.field(&mut inputs) += 1.0;
        for (i, (with, without)) in residual(&inputs).iter().zip(&without).enumerate() {
            b[(i, l)] = without - with;
        }
        *load.field(&mut inputs) = given;
    }
    residual(&inputs);
    b
}

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
            Load::ClampingForce(_) => ("N", FORCE_SCALE),
            Load::Pressure(j) => ("Pa", FORCE_SCALE / point.system.parameters.pulley(*j).cylinder.area),
            Load::Torque(_) => ("N.m", TORQUE_SCALE),
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
