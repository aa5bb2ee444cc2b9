//! A small variator far from any steady state, and its derivatives: against differences, and with
//! updated constitutive tangents.

use crate::differences::compare;
use crate::noise;
use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::solver::arrow::Arrow;
use pushbelt::solver::{Factors, State, System};
use pushbelt::variator::pulleys::loads::{Boundary, Loads, ShaftMode, SheaveMode};
use pushbelt::variator::ring_models::{Assembly, Belt, BeltRing, InForce, ResultantDerivatives};
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt::variator::steady::start::{Start, kinematic_state};
use pushbelt::variator::system::VariatorSystem;
use std::sync::Arc;

/// Time of the residual, s: the loads are constant.
pub const TIME: f64 = 0.0;
/// Factors of the derivatives.
const FACTORS: Factors = Factors {
    alpha: 1.0e4,
    beta: 1.0e-4,
};
/// Clamping forces, N.
pub const CLAMPING: PerPulley<f64> = PerPulley {
    secondary: 1.0e4,
    primary: 1.3e4,
};

/// A small variator with this ring, in the plane.
pub fn small(ring_model: RingModel) -> Parameters {
    let mut parameters = Parameters {
        ring_model,
        ..Parameters::default()
    };
    parameters.geometry.pulley_offset = 5.0e-4;
    (parameters.mesh.primary_arc, parameters.mesh.secondary_arc) = (4, 4);
    parameters.mesh.strand = 3;
    // A hundred times that of real elements: the slopes of their drag weigh in the Jacobian.
    parameters.belt.element_inertia = 2.5e-6;
    parameters
}

/// A variator at a state in which the belt slides, sticks, is compressed and has gaps.
pub fn disturbed(parameters: &Parameters, speed: f64) -> (VariatorSystem, State) {
    disturbed_with(parameters, parameters.ring_of_model(), speed)
}

/// [`disturbed`] with a ring other than that of the parameters.
pub fn disturbed_with(
    parameters: &Parameters,
    ring: Arc<dyn BeltRing>,
    speed: f64,
) -> (VariatorSystem, State) {
    let mut system = VariatorSystem::with_ring(parameters, ring);
    system.loads = Loads::Steady(Boundary {
        sheave: CLAMPING.map(SheaveMode::Force),
        shaft: PerPulley {
            secondary: ShaftMode::Torque(-40.0),
            primary: ShaftMode::Torque(50.0),
        },
    });
    let start = Start {
        ratio: 1.2,
        primary_speed: speed,
        clamping: CLAMPING,
    };
    let material = &system.belt.material_mesh;
    let travels = material.is_some();
    let mut state = if let Some(material) = material {
        let other = VariatorSystem::with_ring(parameters, material.starts_on.clone()).belt;
        let on_other = kinematic_state(&other, &start).expect("the belt closes");
        (material.start)(&system.belt, &other, &on_other)
    } else {
        kinematic_state(&system.belt, &start).expect("the belt closes")
    };
    let mut random = noise(7);
    let n = state.y.len();
    let mut size = vec![0.0; n];
    let beta = FACTORS.beta;
    system.newton_scale(beta, &mut size);
    for (i, &size) in size.iter().enumerate() {
        state.y[i] += 200.0 * size * random();
        state.y_dot[i] = 2000.0 * size * random();
        if system.has_position()[i] {
            state.q[i] += 2000.0 * size * beta * random();
        }
    }
    if travels {
        state.q[system.belt.layout.drift()] += 0.0123;
    }
    (system, state)
}

/// The Jacobian against central differences, whose steps are `step` times the negligible errors.
#[track_caller]
pub fn assert_jacobian((mut system, state): (VariatorSystem, State), step: f64) {
    let Factors { alpha, beta } = FACTORS;
    let mut size = vec![0.0; state.y.len()];
    system.newton_scale(beta, &mut size);
    // Strains of a travelling ring are differences of positions, so each force has a rounding error
    // of EA·ε.
    let mut coarse = vec![false; size.len()];
    if system.belt.material_mesh.is_some() {
        let layout = &system.belt.layout;
        layout.node_unknowns().for_each(|of| coarse[of.index] = of.is_length);
    }
    let h = |i: usize| size[i] * if coarse[i] { 1.0 } else { step };
    let name = system.belt.ring.name();
    compare(&mut system, TIME, &state, [alpha, beta], h, |entry| {
        let noise = 1e-15 * (entry.rounded + 1e3 / h(entry.column));
        let allowed = 2e-4 * entry.exact.abs() + 1e-6 * entry.largest + 20.0 * noise;
        assert!(
            (entry.difference - entry.exact).abs() < allowed,
            "{name}, row {}: {entry:?}",
            entry.row
        );
    });
}

/// Equations of a belt, with derivatives by hand or by forward differentiation.
pub type Equations = fn(&Belt, bool) -> Box<dyn Assembly>;

/// Derivatives of the `equations` in a state, column by column: rows of the matrix, then resultants
/// of the contact forces.
fn columns(system: &VariatorSystem, state: &State, equations: Equations, by_hand: bool) -> Vec<Vec<f64>> {
    let (belt, friction) = (&*system.belt, &system.friction());
    let n = state.y.len();
    let (mut matrix, mut resultants) = (Arrow::new(system.shape()), ResultantDerivatives::new(n));
    equations(belt, by_hand).jacobian(
        InForce { belt, friction },
        state.view(),
        FACTORS,
        &mut matrix,
        &mut resultants,
    );
    let column = |k: usize| {
        let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
        unit[k] = 1.0;
        matrix.multiply(&unit, &mut column);
        for pulley in Pulley::BOTH {
            column.extend(
                [[1.0, 0.0], [0.0, 1.0]]
                    .map(|axis| resultants.along(pulley, axis).nth(k).unwrap_or(f64::NAN)),
            );
        }
        column
    };
    (0..n).map(column).collect()
}

/// The hand-written derivatives are those of forward differentiation, to rounding.
#[track_caller]
pub fn assert_derivatives_by_hand(parameters: &Parameters, ring: &Arc<dyn BeltRing>, equations: Equations) {
    for speed in [200.0, -200.0, 0.0] {
        let (system, state) = disturbed_with(parameters, Arc::clone(ring), speed);
        let [by_hand, forward] = [true, false].map(|by_hand| columns(&system, &state, equations, by_hand));
        for (k, (by_hand, forward)) in by_hand.iter().zip(&forward).enumerate() {
            let scale = forward.iter().fold(1e-6_f64, |most, x| most.max(x.abs()));
            for (row, (a, b)) in by_hand.iter().zip(forward).enumerate() {
                assert!(
                    (a - b).abs() < 1e-9 * scale,
                    "{ring:?}, {speed} rad/s, row {row}, column {k}: {a:e} {b:e}"
                );
            }
        }
    }
}

/// The product of a matrix with a vector that has no zeros.
pub fn product(matrix: &Arrow) -> Vec<f64> {
    let x: Vec<f64> = (0..matrix.shape().len()).map(|i| 1.0 + (i % 7) as f64).collect();
    let mut product = vec![0.0; x.len()];
    matrix.multiply(&x, &mut product);
    product
}

/// The Jacobian at the second state after an update of the constitutive tangents alone, with the
/// geometry of the first state: it differs from the exact one by less than `share` of the
/// difference due to `change` and the states.
#[track_caller]
fn assert_updated(
    system: &mut VariatorSystem,
    states: [&State; 2],
    change: impl FnOnce(&mut VariatorSystem),
    share: f64,
) {
    let Factors { alpha, beta } = FACTORS;
    let matrix = || Arrow::new(system.shape());
    let [mut first, mut found, mut exact] = [matrix(), matrix(), matrix()];
    system.jacobian(TIME, states[0].view(), alpha, beta, &mut first);
    change(system);
    let renewed = system.renew_jacobian(TIME, states[1].view(), alpha, beta, &mut found);
    assert_eq!(renewed, 0.0, "the geometry is reused");
    system.jacobian(TIME, states[1].view(), alpha, beta, &mut exact);
    let [first, found, exact] = [&first, &found, &exact].map(product);
    let largest =
        |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    let (changed, off) = (largest(&first, &exact), largest(&found, &exact));
    assert!(changed > 1e3 && off < share * changed, "{changed:e}, {off:e}");
}

/// An update of the constitutive tangents alone gives the current Jacobian: where laws have other
/// tangents and the same forces, and close to the state at which the geometry was evaluated.
#[track_caller]
pub fn assert_update_of_tangents(parameters: &Parameters, ring: &Arc<dyn BeltRing>) {
    let (mut system, mut state) = disturbed_with(parameters, Arc::clone(ring), 200.0);
    // A difference of a tenth of a roughness and of a friction velocity.
    let mut further = state.clone();
    for pulley in Pulley::BOTH {
        further.q[system.belt.layout.sheave(pulley)] += 0.1 * parameters.contact.roughness;
    }
    for at in &system.belt.cells_at {
        further.y[at.speed] += 0.1 * parameters.friction.velocity;
    }
    assert_updated(&mut system, [&state, &further], |_| (), 1e-3);
    // At rest, laws of rates have tangents but no forces.
    state.y.fill(0.0);
    state.y_dot.fill(0.0);
    let of_rates = |system: &mut VariatorSystem| {
        let law = &mut Arc::make_mut(&mut system.belt).law;
        law.stack.damping *= 3.0;
        law.stack.film_damping *= 3.0;
        law.contact.damping *= 3.0;
        system.friction_velocity *= 2.0;
        system.parameters.friction.ring_velocity *= 2.0;
    };
    assert_updated(&mut system, [&state, &state], of_rates, 1e-9);
}
