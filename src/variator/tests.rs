//! The assembled system: its Jacobian against differences and against itself, its symmetries.

use super::pulleys::loads::{Boundary, Loads, ShaftMode, SheaveMode};
use super::settings::parameters::{Parameters, RingModel};
use super::steady::start::{Start, kinematic_state};
use super::system::VariatorSystem;
use crate::pulley::{PerPulley, Pulley};
use crate::solver::arrow::Arrow;
use crate::solver::differences::compare;
use crate::solver::sdirk::Geometry;
use crate::solver::{State, System};
use pushbelt_lab::noise;

/// Time of the residual, s: the loads are constant.
const TIME: f64 = 0.0;
/// Clamping forces, N.
const CLAMPING: PerPulley<f64> = PerPulley {
    secondary: 1.0e4,
    primary: 1.3e4,
};

/// A small variator with this ring, in the plane, on the aligned mesh.
fn small(ring_model: RingModel) -> Parameters {
    let mut parameters = Parameters {
        ring_model,
        ..Parameters::default()
    };
    parameters.geometry.pulley_offset = 5.0e-4;
    (parameters.mesh.primary_arc, parameters.mesh.secondary_arc) = (4, 4);
    parameters.mesh.strand = 3;
    parameters
}

/// A variator at a state that slides, sticks, pushes and gaps.
fn disturbed(parameters: &Parameters, speed: f64) -> (VariatorSystem, State) {
    let travels = parameters.ring_model.travels();
    let mut system = VariatorSystem::new(parameters);
    system.loads = Loads::constant(Boundary {
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
    let mut state = if travels {
        let ale = Parameters {
            ring_model: RingModel::Ale,
            ..parameters.clone()
        };
        let ale = VariatorSystem::new(&ale);
        system.state_on_ale(&ale, &kinematic_state(&ale.belt, &start).unwrap())
    } else {
        kinematic_state(&system.belt, &start).unwrap()
    };
    let mut random = noise(7);
    let n = state.y.len();
    let mut size = vec![0.0; n];
    let beta = 1.0e-4;
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

/// The Jacobian against central differences.
fn check_jacobian(parameters: &Parameters, speed: f64) {
    check_jacobian_by(parameters, speed, 0.4);
}

/// The Jacobian against central differences whose steps are `step` times the negligible errors.
fn check_jacobian_by(parameters: &Parameters, speed: f64, step: f64) {
    let (mut system, state) = disturbed(parameters, speed);
    let (alpha, beta) = (1.0e4, 1.0e-4);
    let mut size = vec![0.0; state.y.len()];
    system.newton_scale(beta, &mut size);
    // Strains of a ring that travels are differences of places: EA·ε of rounding in each force.
    let mut coarse = vec![false; size.len()];
    if parameters.ring_model.travels() {
        system.belt.layout.for_each_length_unknown(|i| coarse[i] = true);
    }
    let h = |i: usize| size[i] * if coarse[i] { 2.0 } else { step };
    compare(&mut system, TIME, &state, [alpha, beta], h, |entry| {
        let noise = 1e-15 * (entry.rounded + 1e3 / h(entry.column));
        let allowed = 2e-4 * entry.exact.abs() + 1e-6 * entry.largest + 20.0 * noise;
        assert!(
            (entry.difference - entry.exact).abs() < allowed,
            "{speed} rad/s, row {}: {entry:?}",
            entry.row
        );
    });
}

/// The derivatives by hand are those that forward differentiation finds, to rounding.
#[test]
fn derivatives_by_hand_are_those_of_forward_differentiation() {
    let of = |model: RingModel, spatial: bool, aligned: bool, tilt: f64| {
        let mut parameters = small(model);
        parameters.spatial = spatial;
        parameters.mesh.aligned = aligned;
        parameters.primary.tilt.stiffness = tilt;
        for speed in [200.0, -200.0, 0.0] {
            let (system, state) = disturbed(&parameters, speed);
            let worst = system.worst_derivative(state.view(), 1.0e4);
            assert!(worst < 1e-9, "{model:?}, in space {spatial}, {speed} rad/s: {worst:e}");
        }
    };
    of(RingModel::Ale, false, true, 7e5);
    of(RingModel::Ale, true, true, 7e5);
    of(RingModel::Ale, false, false, 7e5);
    of(RingModel::Ale0, false, true, 1e12);
    of(RingModel::Ale0, false, false, 7e5);
}

fn product(matrix: &Arrow) -> Vec<f64> {
    let x: Vec<f64> = (0..matrix.shape().len()).map(|i| 1.0 + (i % 7) as f64).collect();
    let mut product = vec![0.0; x.len()];
    matrix.multiply(&x, &mut product);
    product
}

/// Where nothing has changed derivatives are kept. A cell that begins to slip gets new slopes of its laws, with those that
/// share its face; after another step size all are differentiated again.
#[test]
fn derivatives_are_kept_until_they_change() {
    let (mut system, mut state) = disturbed(&small(RingModel::Ale), 200.0);
    let shape = system.shape();
    let renewed = |system: &mut VariatorSystem, state: &State, alpha: f64| {
        let (before, mut matrix) = (system.differentiations(), Arrow::new(shape));
        system.renew_jacobian(TIME, state.view(), alpha, 1.0 / alpha, &mut matrix);
        let after = system.differentiations();
        ([0, 1].map(|k| after[k] - before[k]), product(&matrix))
    };
    let packs = system.belt.mesh.groups.len() as u64;
    let (all, first) = renewed(&mut system, &state, 1.0e4);
    let (none, again) = renewed(&mut system, &state, 1.0e4);
    assert_eq!((all, none), ([packs, 0], [0, 0]));
    assert_eq!(first, again);
    // In the middle of the primary arc, where the belt sticks.
    let face = system.belt.layout.belt_speed(14);
    state.y[face] += 0.5;
    let ([differentiated, some], changed) = renewed(&mut system, &state, 1.0e4);
    assert_eq!(differentiated, 0);
    assert!((1..=2).contains(&some), "{some} of {packs}");
    let mut exact = Arrow::new(shape);
    system.jacobian(TIME, state.view(), 1.0e4, 1.0e-4, &mut exact);
    let exact = product(&exact)[face];
    let (before, after) = (first[face] - exact, changed[face] - exact);
    assert!(after.abs() < 0.02 * before.abs(), "{before:e}, {after:e}");
    assert_eq!(renewed(&mut system, &state, 2.0e4).0, [packs, 0]);
}

/// New slopes of the laws alone make the Jacobian of now: where laws have other slopes and the same forces, and close to where the
/// geometry was new.
#[test]
fn new_slopes_of_the_laws_make_the_jacobian_of_now() {
    let check = |system: &mut VariatorSystem, states: [&State; 2], change: &dyn Fn(&mut VariatorSystem), share: f64| {
        let slopes = [1.0e4, 1.0e-4];
        let matrix = || Arrow::new(system.shape());
        let [mut first, mut found, mut exact] = [matrix(), matrix(), matrix()];
        system.jacobian(TIME, states[0].view(), slopes[0], slopes[1], &mut first);
        change(system);
        let mut form = |geometry, out: &mut Arrow| {
            system.form_jacobian(Some(geometry), TIME, states[1].view(), slopes, out);
        };
        form(Geometry::Kept, &mut found);
        form(Geometry::All, &mut exact);
        let [first, found, exact] = [&first, &found, &exact].map(product);
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        let (changed, off) = (largest(&first, &exact), largest(&found, &exact));
        assert!(changed > 1e3 && off < share * changed, "{changed:e}, {off:e}");
    };
    for (model, spatial, aligned) in [
        (RingModel::Ale, false, true),
        (RingModel::Ale, true, true),
        (RingModel::Ale, false, false),
        (RingModel::Ale0, false, true),
        (RingModel::Ale0, false, false),
    ] {
        let mut parameters = small(model);
        parameters.spatial = spatial;
        parameters.mesh.aligned = aligned;
        let (mut system, mut state) = disturbed(&parameters, 200.0);
        // A tenth of a roughness and of a friction velocity further.
        let mut further = state.clone();
        for pulley in Pulley::BOTH {
            further.q[system.belt.layout.sheave(pulley)] += 0.1 * parameters.contact.roughness;
        }
        for at in &system.belt.cells_at {
            further.y[at.speed] += 0.1 * parameters.friction.velocity;
        }
        check(&mut system, [&state, &further], &|_| (), 1e-3);
        // At rest laws of rates have slopes and no forces.
        state.y.fill(0.0);
        state.y_dot.fill(0.0);
        let of_rates = |system: &mut VariatorSystem| {
            let law = &mut system.law;
            law.chain.damping *= 3.0;
            law.chain.film_damping *= 3.0;
            law.contact.damping *= 3.0;
            law.settling += 1.0e3;
            system.friction_velocity *= 2.0;
        };
        check(&mut system, [&state, &state], &of_rates, 1e-9);
    }
}

/// The nodes of a ring that travels are interchangeable: counted from another one, with s an element on, the
/// residual is the same.
#[test]
fn a_travelling_ring_may_be_counted_from_any_node() {
    for model in [RingModel::Rcm, RingModel::Ancf] {
        let (mut system, state) = disturbed(&small(model), 200.0);
        let (layout, n) = (system.belt.layout, state.y.len());
        let travelling = *layout.travelling().expect("it travels");
        // Index of an unknown when the nodes are counted from the one before.
        let counted_on = |i: usize| {
            let first = layout.node(0, 0);
            let nodes = first..first + travelling.nodes * travelling.block;
            if nodes.contains(&i) {
                first + (i - first + travelling.block) % nodes.len()
            } else {
                i
            }
        };
        let mut other = state.clone();
        for i in 0..n {
            other.y[counted_on(i)] = state.y[i];
            other.y_dot[counted_on(i)] = state.y_dot[i];
            other.q[counted_on(i)] = state.q[i];
        }
        for _ in 0..travelling.nodes + 1 {
            other.q[layout.drift()] -= travelling.length;
        }
        let mut residuals = [vec![0.0; n], vec![0.0; n]];
        system.residual(TIME, state.view(), &mut residuals[0]);
        system.residual(TIME, other.view(), &mut residuals[1]);
        let largest = residuals[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for i in 0..n {
            let [one, two] = [residuals[0][i], residuals[1][counted_on(i)]];
            assert!((one - two).abs() < 1e-9 * largest, "row {i}: {one} {two}, {largest}");
        }
    }
}

#[test]
fn jacobians_of_rings_that_travel_match_differences() {
    check_jacobian(&small(RingModel::Rcm), 200.0);
    check_jacobian(&small(RingModel::Ancf), -200.0);
}

#[test]
fn jacobian_of_ale_matches_differences() {
    check_jacobian(&small(RingModel::Ale), 200.0);
    check_jacobian(&small(RingModel::Ale), -200.0);
}

#[test]
fn jacobian_on_evenly_spaced_elements_matches_differences() {
    let even = |model, spatial| {
        let mut parameters = small(model);
        (parameters.mesh.aligned, parameters.spatial) = (false, spatial);
        parameters
    };
    check_jacobian(&even(RingModel::Ale, false), 200.0);
    check_jacobian(&even(RingModel::Ale, true), -200.0);
    check_jacobian(&even(RingModel::Ale0, false), 200.0);
}

#[test]
fn jacobian_in_directions_of_the_curve_matches_differences() {
    for spatial in [false, true] {
        let parameters = Parameters {
            reference_directions: true,
            spatial,
            ..small(RingModel::Ale)
        };
        // Friction bends more sharply over a step of these coordinates.
        check_jacobian_by(&parameters, if spatial { -200.0 } else { 200.0 }, 0.16);
    }
}

#[test]
fn jacobian_in_space_matches_differences() {
    let spatial = Parameters {
        spatial: true,
        ..small(RingModel::Ale)
    };
    check_jacobian_by(&spatial, 200.0, 0.2);
    check_jacobian_by(&spatial, -200.0, 0.2);
}

/// Space mirrored in the plane of the drive: sheaves on the other sides, w the other way, everything else alike.
#[test]
fn mirrored_in_the_plane() {
    let mut parameters = Parameters {
        spatial: true,
        ..Parameters::default()
    };
    parameters.geometry.pulley_offset = 7.0e-4;
    let mut system = VariatorSystem::new(&parameters);
    let start = Start {
        ratio: 1.6,
        primary_speed: 200.0,
        clamping: CLAMPING,
    };
    let mut state = kinematic_state(&system.belt, &start).unwrap();
    let mut random = noise(3);
    let mut size = vec![0.0; state.y.len()];
    system.newton_scale(1.0e-4, &mut size);
    for (i, &size) in size.iter().enumerate() {
        state.y[i] += 200.0 * size * random();
        state.q[i] += 0.1 * size * random();
    }
    let mut other = VariatorSystem::mirrored(&parameters);
    let mut mirrored = state.clone();
    let places: Vec<usize> = (0..system.belt.layout.elements)
        .flat_map(|node| [4, 5].map(|k| system.belt.layout.node(node, k)))
        .collect();
    for &i in &places {
        for values in [&mut mirrored.y, &mut mirrored.y_dot, &mut mirrored.q] {
            values[i] = -values[i];
        }
    }
    let (mut rows, mut reflected) = (vec![0.0; size.len()], vec![0.0; size.len()]);
    system.residual(TIME, state.view(), &mut rows);
    other.residual(TIME, mirrored.view(), &mut reflected);
    for &i in &places {
        reflected[i] = -reflected[i];
    }
    assert!(places.iter().any(|&i| rows[i].abs() > 1.0));
    assert_eq!(rows, reflected);
}

#[test]
fn jacobian_of_ale0_matches_differences() {
    check_jacobian(&small(RingModel::Ale0), 200.0);
    check_jacobian(&small(RingModel::Ale0), 0.0);
}
