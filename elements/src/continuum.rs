//! The other side of a comparison: steady states of the FMU's model under the loads of a case.
//!
//! The laws are the same as far as parameters go: oil of the case, without oil no viscosity of the
//! stack, no friction between layers, no loss by turning elements.

use pushbelt::variator::Variator;
use pushbelt::variator::run::StepError;
use pushbelt::variator::settings::{Axial, Drive, Inputs, RingModel, StartState};
use pushbelt_elements::case::{Case, SHIFT};
use pushbelt_elements::run::csv;
use std::error::Error;

/// Names of the columns behind the case; the last two after a jolt.
pub const COLUMNS: &str = "model,ratio,thrustRatio,slip,efficiency,primary.idleArc,secondary.idleArc,\
    pushForceMax,loss.sheaves,loss.ring,loss.other,slipMin,slipMax";

/// Ratios are met to this, in this many trials.
const RATIO: f64 = 1.0e-4;
const TRIALS: usize = 6;

/// Models: name, ring, refinement of the mesh.
pub const MODELS: [(&str, RingModel, i32); 3] = [
    ("ALE", RingModel::Ale, 1),
    ("ALE x3", RingModel::Ale, 3),
    ("ALE0", RingModel::Ale0, 1),
];

/// The line of a model in a case, without their names.
///
/// # Errors
/// There is no such steady state.
pub fn line(case: &Case, (_, ring, mesh): (&str, RingModel, i32)) -> Result<String, Box<dyn Error>> {
    let (mut variator, mut inputs) = steady(case, ring, mesh)?;
    let outputs = variator.outputs();
    if let Some(step) = case.options.shift {
        let held = [outputs.ratio_geometric, outputs.thrust_ratio, step];
        inputs.primary.clamping_force = outputs.primary.axial_force * step.exp();
        let mut after = |time: f64| {
            variator.advance(time, &inputs)?;
            Ok::<_, StepError>(variator.outputs().ratio_geometric.recip())
        };
        let rate = (-after(0.5 * SHIFT)? + after(SHIFT)?) / (0.5 * SHIFT);
        return Ok(csv(&[&held[..], &[rate, rate / step]].concat()));
    }
    let mut values = vec![outputs.ratio_geometric, outputs.thrust_ratio];
    values.extend([outputs.slip, outputs.belt_efficiency]);
    values.extend([outputs.primary, outputs.secondary].map(|pulley| pulley.idle_arc));
    let losses = outputs.losses;
    values.extend([outputs.push_force_max, losses.sheaves, losses.ring, losses.other]);
    values.extend(after_jolt(&mut variator, &inputs)?);
    Ok(csv(&values))
}

/// Least and largest slip 0.3 to 0.4 s after 10 ms with 110 % of the secondary force.
fn after_jolt(variator: &mut Variator, inputs: &Inputs) -> Result<[f64; 2], StepError> {
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    for step in 1..=400 {
        let mut jolted = *inputs;
        jolted.secondary.clamping_force *= if step <= 10 { 1.1 } else { 1.0 };
        variator.advance(1.0e-3 * f64::from(step), &jolted)?;
        if step > 300 {
            let slip = variator.outputs().slip;
            ends = [ends[0].min(slip), ends[1].max(slip)];
        }
    }
    Ok(ends)
}

fn steady(case: &Case, ring: RingModel, mesh: i32) -> Result<(Variator, Inputs), Box<dyn Error>> {
    let mut of = case.parameters.clone();
    of.ring_model = ring;
    of.mesh = of.mesh.refined(mesh);
    (of.layers.friction, of.belt.element_inertia) = (0.0, 0.0);
    if case.options.squeeze == 0.0 {
        of.belt.film_damping = 0.0;
    }
    of.belt.film_thickness = case.options.film;
    of.belt.squeeze_damping = case.options.squeeze;
    of.primary.drive = Drive::Speed;
    if case.options.shift.is_none() {
        of.primary.axial = Axial::Held;
    }
    of.initial.primary_speed = case.options.speed;
    let mut inputs = Inputs::ZERO;
    inputs.primary.speed_setpoint = case.options.speed;
    inputs.primary.clamping_force = case.options.force;
    (inputs.secondary.torque, inputs.secondary.clamping_force) = (-case.torque(), case.options.force);
    // The start's ratio is that of a point of the curve; the one to meet is that of the mean radii.
    of.initial.ratio = case.ratio;
    for _ in 0..TRIALS {
        let mut variator = Variator::new(of.clone())?;
        variator.initialise(0.0, &inputs)?;
        let (messages, outputs) = (variator.take_messages(), variator.outputs());
        if outputs.start_state != StartState::Steady {
            let cause = messages.first().map(|one| one.text.clone());
            return Err(cause.unwrap_or("no steady state".into()).into());
        }
        let excess = outputs.ratio_geometric / case.ratio;
        if (excess - 1.0).abs() < RATIO {
            return Ok((variator, inputs));
        }
        of.initial.ratio /= excess;
    }
    Err("the ratio is not met".into())
}
