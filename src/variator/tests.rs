//! The symmetry of the assembled system, and what the error norm refuses.

use super::belt::CellUnknowns;
use super::diagnostics::energy_balance::{EnergyBalance, Problem};
use super::settings::parameters::Parameters;
use super::steady::start::{Start, kinematic_state};
use super::system::VariatorSystem;
use crate::pulley::{PerPulley, Pulley};
use crate::solver::sdirk::Evolution;
use crate::solver::{State, System};
use pushbelt_support::noise;

/// Space mirrored in the plane of the drive: sheaves on the other sides, w the other way,
/// everything else alike.
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
        clamping: PerPulley {
            secondary: 1.0e4,
            primary: 1.3e4,
        },
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
    system.residual(0.0, state.view(), &mut rows);
    other.residual(0.0, mirrored.view(), &mut reflected);
    for &i in &places {
        reflected[i] = -reflected[i];
    }
    assert!(places.iter().any(|&i| rows[i].abs() > 1.0));
    assert_eq!(rows, reflected);
}

/// An error that is not a number is beyond the tolerance, of whichever unknown it is.
#[test]
fn no_step_with_an_error_that_is_no_number_is_accepted() {
    let parameters = Parameters::default();
    let mut system = VariatorSystem::new(&parameters);
    let mut energy = EnergyBalance::default();
    let layout = system.belt.layout;
    let CellUnknowns { speed, content } = system.belt.cells_at[3];
    let [sheave, shaft] = [layout.sheave(Pulley::Primary), layout.shaft_speed(Pulley::Secondary)];
    let tilt = layout.tilt(Pulley::Primary, 1);
    let (system, energy) = (&mut system, &mut energy);
    let problem = Problem { system, energy };
    let state = State::zero(layout.len());
    let norm = |y: &[f64], q: &[f64]| problem.error_norm(state.view(), y, q);
    let zeros = vec![0.0; layout.len()];
    assert_eq!(norm(&zeros, &zeros), 0.0);
    for i in [layout.theta(), sheave, shaft, tilt, speed, content] {
        let mut wrong = zeros.clone();
        wrong[i] = f64::NAN;
        assert!(norm(&wrong, &wrong) > 1.0, "unknown {i}");
    }
}
