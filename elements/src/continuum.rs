//! The other side of a comparison: steady states of the FMU's model under the loads of a case.
//!
//! The laws are the same as far as parameters go: oil of the case, without oil no viscosity of the
//! stack, no friction between layers, no loss by turning elements.

use pushbelt::variator::Variator;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Outputs, RingModel, StartState};
use pushbelt_elements::case::Case;

/// Names of the columns behind case and model.
pub const COLUMNS: &str = "ratio,thrustRatio,slip,efficiency,primary.idleArc,secondary.idleArc,\
    pushForceMax,loss.sheaves,loss.ring,loss.other";

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
pub fn line(case: &Case, (_, ring, mesh): (&str, RingModel, i32)) -> Result<String, String> {
    let outputs = steady(case, ring, mesh)?;
    let values = [
        outputs.ratio_geometric,
        outputs.thrust_ratio,
        outputs.slip,
        outputs.belt_efficiency,
        outputs.primary.idle_arc,
        outputs.secondary.idle_arc,
        outputs.push_force_max,
        outputs.losses.sheaves,
        outputs.losses.ring,
        outputs.losses.other,
    ];
    Ok(values.map(|value| format!("{value:.6}")).join(","))
}

fn steady(case: &Case, ring: RingModel, mesh: i32) -> Result<Outputs, String> {
    let mut of = case.parameters.clone();
    of.ring_model = ring;
    of.mesh = of.mesh.refined(mesh);
    (of.layers.friction, of.belt.element_inertia) = (0.0, 0.0);
    if case.options.squeeze == 0.0 {
        of.belt.film_damping = 0.0;
    }
    of.belt.film_thickness = case.options.film;
    of.belt.squeeze_damping = case.options.squeeze;
    (of.primary.drive, of.primary.axial) = (Drive::Speed, Axial::Held);
    of.initial.primary_speed = case.options.speed;
    let mut inputs = Inputs::ZERO;
    inputs.primary.speed_setpoint = case.options.speed;
    inputs.primary.clamping_force = case.options.force;
    (inputs.secondary.torque, inputs.secondary.clamping_force) = (-case.torque(), case.options.force);
    // The start's ratio is that of a point of the curve; the one to meet is that of the mean radii.
    of.initial.ratio = case.ratio;
    for _ in 0..TRIALS {
        let mut variator = Variator::new(of.clone()).map_err(|error| error.to_string())?;
        variator.initialise(0.0, &inputs).map_err(|error| error.to_string())?;
        let messages = variator.take_messages();
        let outputs = variator.outputs().clone();
        if outputs.start_state != StartState::Steady {
            return Err(messages
                .first()
                .map_or_else(|| "no steady state".to_owned(), |message| message.text.to_string()));
        }
        let excess = outputs.ratio_geometric / case.ratio;
        if (excess - 1.0).abs() < RATIO {
            return Ok(outputs);
        }
        of.initial.ratio /= excess;
    }
    Err("the ratio is not met".to_owned())
}
