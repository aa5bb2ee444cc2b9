//! Loads on the pulleys as inputs of the linear model.

use faer::Mat;

use super::SAME;
use super::working_point::WorkingPoint;
use crate::solver::System;
use crate::variator::pulleys::loads::Loads;
use crate::variator::settings::{Axial, Drive, INPUTS, Input, Inputs, Parameters};

/// An input of the linear model, by its index among the values of `Inputs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Load(usize);

impl Load {
    /// Its value.
    #[must_use]
    pub fn value(self, inputs: &Inputs) -> f64 {
        inputs.values()[self.0]
    }

    /// Adds to its value.
    pub fn add(self, more: f64, inputs: &mut Inputs) {
        *inputs.each_mut()[self.0] += more;
    }

    /// Name of the variable of the FMU.
    #[must_use]
    pub fn name(self) -> &'static str {
        INPUTS[self.0].name
    }

    /// Its unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        INPUTS[self.0].unit
    }
}

pub(super) fn loads_in_force(parameters: &Parameters) -> Vec<Load> {
    let mut loads = Vec::new();
    for (pulley, prefix) in [(&parameters.primary, "primary."), (&parameters.secondary, "secondary.")] {
        let is_clamped = pulley.axial == Axial::Force;
        for (name, acts) in [
            ("torque", pulley.drive == Drive::Torque),
            ("speedSetpoint", pulley.drive == Drive::Speed),
            ("clampingForce", is_clamped),
            ("pressure", is_clamped && pulley.cylinder.area > 0.0),
        ] {
            let index = INPUTS
                .iter()
                .position(|input| input.name.strip_prefix(prefix) == Some(name));
            loads.extend(index.filter(|_| acts).map(Load));
        }
    }
    loads
}

/// B of the descriptor system: the negative derivatives of the residual by the loads, in which it
/// is linear.
pub(super) fn load_columns(point: &mut WorkingPoint, loads: &[Load], size: usize) -> Mat<f64> {
    let (system, state, inputs) = (&mut point.system, &point.state, point.inputs);
    let mut residual = |inputs: &Inputs| {
        let mut out = vec![0.0; state.y.len()];
        system.loads = Loads::held(inputs);
        system.residual(0.0, state.view(), &mut out);
        out
    };
    let without = residual(&inputs);
    let mut b = Mat::<f64>::zeros(size, loads.len());
    for (l, load) in loads.iter().enumerate() {
        let mut more = inputs;
        load.add(1.0, &mut more);
        for (i, (with, without)) in residual(&more).iter().zip(&without).enumerate() {
            b[(i, l)] = without - with;
        }
    }
    system.loads = Loads::held(&inputs);
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
    // The set point of a speed is the speed of the point.
    for load in loads.iter().filter(|load| load.unit() != "rad/s") {
        let (given, held) = (load.value(&point.given), load.value(&point.inputs));
        let Input { name, unit, size } = INPUTS[load.0];
        // Drag alone changes a torque of zero.
        if (held - given).abs() > SAME * given.abs().max(held.abs()).max(size) {
            found.push(format!(
                "this point requires {name} = {held:.2} {unit}, but {given} {unit} is specified"
            ));
        }
    }
    found
}
