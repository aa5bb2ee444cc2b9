//! Variators and inputs that the tests share.

use pushbelt::contact;
use pushbelt::variator::settings::{BeltKind, Mesh, Parameters, RIGID_TILT_STIFFNESS, RingModel, ShaftDrag};
use pushbelt::variator::settings::{Inputs, PulleyInputs, PulleyOutputs};

/// 2000 rpm, rad/s.
pub const SPEED: f64 = 209.44;

/// Both levels of detail.
pub const MODELS: [RingModel; 2] = [RingModel::Ale0, RingModel::Ale];

/// Elements on each arc and each strand, in `ALE` two cells in each.
pub fn mesh(arc: i32, strand: i32) -> Mesh {
    Mesh {
        primary_arc: arc,
        secondary_arc: arc,
        strand,
        cells_per_element: 2,
    }
}

/// The laboratory variator with one of the ring models.
pub fn variator(model: RingModel) -> Parameters {
    Parameters {
        ring_model: model,
        ..Parameters::default()
    }
}

/// The same with one cell per element.
pub fn one_cell(model: RingModel) -> Parameters {
    let mut parameters = variator(model);
    parameters.mesh.cells_per_element = 1;
    parameters
}

/// The laboratory variator on a coarse mesh, sufficient for tests of laws but not of accuracy.
pub fn coarse(model: RingModel) -> Parameters {
    let factor = if model == RingModel::Ale0 { 2 } else { 1 };
    Parameters {
        mesh: mesh(8, 6).refined(factor),
        ..variator(model)
    }
}

/// Sheaves that do not tilt.
pub fn rigid(mut parameters: Parameters) -> Parameters {
    parameters.primary.tilt.stiffness = RIGID_TILT_STIFFNESS;
    parameters.secondary.tilt.stiffness = RIGID_TILT_STIFFNESS;
    parameters
}

/// The belt alone: shafts without drag, layers of the ring without friction, no loss by turning
/// elements, Coulomb friction on the sheaves. For comparison with theories that have no other
/// losses.
pub fn belt_alone(mut parameters: Parameters) -> Parameters {
    parameters.primary.drag = ShaftDrag::default();
    parameters.secondary.drag = ShaftDrag::default();
    parameters.layers.friction = 0.0;
    parameters.belt.element_inertia = 0.0;
    parameters.joints.radius = 0.0;
    parameters.friction.fall = 0.0;
    parameters
}

/// Inputs of torque and clamping force over pulleys, and speed set points of 2000 rpm.
pub fn inputs(primary: (f64, f64), secondary: (f64, f64)) -> Inputs {
    let pulley = |(torque, clamping_force)| PulleyInputs {
        torque,
        clamping_force,
        speed_setpoint: SPEED,
        pressure: 0.0,
    };
    Inputs {
        primary: pulley(primary),
        secondary: pulley(secondary),
    }
}

/// Torque at which a pulley under its axial force slips tangentially all around, N·m.
pub fn full_slip_torque(parameters: &Parameters, pulley: &PulleyOutputs) -> f64 {
    let cos_beta = parameters.geometry.wedge_angle.cos();
    contact::full_slip_torque(&parameters.friction, cos_beta, pulley.axial_force, pulley.radius)
}

/// The laboratory variator with a pull chain, the chain of `chain168`.
pub fn chain(model: RingModel) -> Parameters {
    let mut parameters = variator(model);
    parameters.kind = BeltKind::PullChain;
    (parameters.belt.mass_per_length, parameters.ring.mass_per_length) = (0.5, 0.65);
    (parameters.belt.element_thickness, parameters.belt.element_inertia) = (8.5e-3, 1.8e-7);
    (parameters.ring.axial_stiffness, parameters.ring.bending_stiffness) = (3.5e6, 1.5e-3);
    parameters.contact.stiffness = 1.2e10;
    parameters
}
