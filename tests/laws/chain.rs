//! The stack of push elements.

use crate::assert_near;
use pushbelt::ring::kinematics::WithRate;
use pushbelt::scalar::Dual;
use pushbelt::stack::{
    Push, PushElements, RATE_SMOOTHING, Transport, UPWIND_SMOOTHING, energy_density, flux, push_force,
};
use pushbelt_support::laws::belt;
use pushbelt_support::noise;

fn push(belt: &PushElements, value: f64, rate: f64) -> Push<f64> {
    push_force(belt, WithRate { value, rate })
}

/// Q without damping, N.
fn elastic(nu: f64) -> f64 {
    push(&belt(), nu, 0.0).force
}

/// In contact, at first touch and in a gap. The energy is zero at gaps of a tenth of the belt, the
/// largest admissible play.
#[test]
fn push_force_is_the_derivative_of_the_energy() {
    let none = energy_density(&belt(), 0.9);
    assert!(none.abs() < 1e-10 * energy_density(&belt(), 1.001), "{none} J/m");
    for strain in [5e-3, 0.0, -1e-3] {
        let energy = energy_density(&belt(), Dual::seed(1.0 + strain, 0, 1.0));
        let push = elastic(1.0 + strain);
        assert_near(energy.eps[0], push, push, 1e-9, "∂E/∂ν");
    }
}

/// The rate of strain at which the switch between separating and approaching is complete, 1/s.
const FAST: f64 = 100.0 * RATE_SMOOTHING;

fn viscous(belt: &PushElements, nu: f64, rate: f64) -> f64 {
    push(belt, nu, rate).viscous
}

#[test]
fn damping_of_the_stack_acts_in_contact() {
    let dry = PushElements {
        film_damping: 0.0,
        squeeze_damping: 0.0,
        ..belt()
    };
    let full = dry.push_stiffness * dry.damping;
    for rate in [-3.0, 3.0] {
        assert_near(viscous(&dry, 1.005, rate), full * rate, full, 1e-9, "in contact");
        let touching = viscous(&dry, 1.0, rate);
        assert_near(touching, 0.5 * full * rate, full, 1e-12, "at first touch");
        assert_near(viscous(&dry, 0.99, rate), 0.0, full, 1e-12, "none across a gap");
    }
}

/// Across a gap of n film thicknesses: 2c + d_s/(1 + n)³.
#[test]
fn oil_opposes_closing_at_every_gap() {
    for wide in [0.0, 1.0, 9.0, 999.0] {
        let belt = PushElements {
            damping: 0.0,
            roughness: 1e-10,
            ..belt()
        };
        let nu = 1.0 - wide * belt.film_thickness / belt.element_thickness;
        let expected = 2.0 * belt.film_damping + belt.squeeze_damping / (1.0 + wide).powi(3);
        assert_near(viscous(&belt, nu, FAST) / FAST, expected, expected, 1e-2, "N·s");
    }
}

/// The force of the oil has the sign of the rate and is zero at rest. Where elements separate it is
/// never stronger than cavitation allows, and across a wide gap only what smoothing leaves.
#[test]
fn oil_dissipates_and_cavitates() {
    let oil = PushElements {
        damping: 0.0,
        ..belt()
    };
    for nu in [0.99, 0.999, 1.0, 1.005] {
        assert_eq!(viscous(&oil, nu, 0.0), 0.0, "at rest");
        for rate in [1e-3, 0.1, 10.0, 1e4] {
            assert!(viscous(&oil, nu, rate) > 0.0, "ν = {nu}, {rate} 1/s");
            let suction = -viscous(&oil, nu, -rate);
            assert!((0.0..oil.suction).contains(&suction), "ν = {nu}: {suction} N");
        }
    }
    let smoothed = oil.film_damping * RATE_SMOOTHING;
    assert!(viscous(&oil, 0.5, -10.0) > -1.01 * smoothed, "across a wide gap");
    assert_near(viscous(&oil, 1.0, -1e4), -oil.suction, oil.suction, 1e-2, "cavitation");
}

fn cell(flow: f64, density: f64) -> Transport<f64> {
    Transport { flow, density }
}

#[test]
fn flux_takes_the_density_of_the_cell_upstream() {
    for (flow, density) in [(3.0, 0.98), (-3.0, 1.01)] {
        let found = flux(&cell(7.0, 0.98), &cell(flow, 1.01));
        assert_near(found, flow * density, 3.0, 1e-12, "flux");
    }
}

/// Between equal cells the flux is J ν at every speed, and the mirrored belt has the mirrored flux.
/// At rest it is bounded by the width of the switch.
#[test]
fn flux_has_no_preferred_direction() {
    let rest = flux(&cell(0.0, 0.9), &cell(0.0, 1.1));
    assert_near(rest, -0.1 * UPWIND_SMOOTHING, UPWIND_SMOOTHING, 1e-12, "flux at rest");
    let mut random = noise(3);
    for _ in 0..1000 {
        let flow = random() * (30.0 * random()).exp();
        let [before, after] = [0.98, 1.01].map(|density| cell(flow, density));
        let alike = cell(flow, 0.97);
        assert_near(flux(&alike, &alike), 0.97 * flow, flow.abs(), 1e-9, "cells alike");
        let mirrored = flux(&after, &cell(-flow, before.density));
        assert_eq!(flux(&before, &after), -mirrored, "{before:?} {after:?}");
    }
}
