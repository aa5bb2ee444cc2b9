//! The stack of push elements.

use num_dual::Dual64;
use pushbelt::chain::{
    CLOSING_SMOOTHING, PushElements, SQUEEZE_SMOOTHING, Transport, UPWIND_SMOOTHING, collision_force, energy_density,
    flux, lag, push_force, upwinding,
};
use pushbelt_lab::laws::{belt, integral};
use pushbelt_lab::noise;

use crate::assert_near;

/// Q without damping, N.
fn elastic(nu: f64) -> f64 {
    push_force(&belt(), nu, 0.0).force
}

fn assert_push_is_the_derivative_of_the_energy(strain: f64) {
    let energy = energy_density(&belt(), Dual64::from_re(1.0 + strain).derivative());
    let push = elastic(1.0 + strain);
    assert_near(energy.eps, push, push, 1e-9, "∂E/∂ν");
}

#[test]
fn push_force_is_the_derivative_of_the_energy_in_contact() {
    assert_push_is_the_derivative_of_the_energy(5e-3);
}

#[test]
fn push_force_is_the_derivative_of_the_energy_at_first_touch() {
    assert_push_is_the_derivative_of_the_energy(0.0);
}

#[test]
fn push_force_is_the_derivative_of_the_energy_in_a_gap() {
    assert_push_is_the_derivative_of_the_energy(-1e-3);
}

/// The energy is zero at gaps of a tenth of the belt, the largest admissible play, and is ∫Q dν from there.
#[test]
fn energy_integrates_the_push_force() {
    let none = energy_density(&belt(), 0.9);
    for strain in [-1e-3, 0.0, 1e-3, 1e-2] {
        let found = energy_density(&belt(), 1.0 + strain);
        // Panels get smaller towards the density at which elements touch.
        let ends = [-0.1, -1e-2, -1e-3, strain];
        let work: f64 = ends
            .windows(2)
            .map(|ends| integral(|x| elastic(1.0 + x), [ends[0], ends[1]], 500))
            .sum();
        assert_near(found - none, work, energy_density(&belt(), 1.001), 1e-10, "∫Q dν");
        assert!(none.abs() < 1e-10 * energy_density(&belt(), 1.001), "{none} J/m");
    }
}

/// The work to shorten a cell of constant amount N and length N/ν is N∫Q/ν² dν, which is ν∫Q/ν² dν per length. The law has
/// ∫Q dν instead. With Q = k_e x and x = ν − 1 it is too large by the share x/3 + O(x²).
#[test]
fn energy_is_that_of_a_cell_that_shortens_to_first_order() {
    for strain in [5e-3, 1e-2, 2e-2] {
        let nu = 1.0 + strain;
        let work = nu * integral(|x| elastic(1.0 + x) / (1.0 + x).powi(2), [-1e-2, strain], 3000);
        let found = energy_density(&belt(), nu) - energy_density(&belt(), 0.99);
        let share = found / work - 1.0;
        println!("ν − 1 = {strain}: energy too large by {share:.2e}");
        assert_near(share, strain / 3.0, strain / 3.0, 0.03, "what the expansion leaves");
    }
}

/// Damping opposes the rate at which elements close up or separate: that of the stack in contact, that of the film in a gap too.
#[test]
fn damping_of_the_stack_acts_in_contact_and_that_of_the_film_everywhere() {
    let full = belt().push_stiffness * belt().damping;
    for rate in [-3.0, 3.0] {
        let push = push_force(&belt(), 1.005, rate);
        assert_near(
            push.contact,
            1.0,
            1.0,
            2e-2,
            "in contact, where the film bears a little more",
        );
        let both = (full * push.contact + belt().film_damping) * rate + squeezed(1.0, rate);
        assert_near(push.viscous, both, full, 1e-2, "damping in contact");
        assert_near(
            push.force - push.viscous,
            elastic(1.005),
            full,
            1e-9,
            "the elastic rest",
        );
        let dry = PushElements {
            film_force: 0.0,
            film_damping: 0.0,
            squeeze_damping: 0.0,
            ..belt()
        };
        let touching = push_force(&dry, 1.0, rate);
        assert_near(touching.viscous, 0.5 * full * rate, full, 1e-12, "half at first touch");
        let apart = push_force(&belt(), 0.99, rate).viscous;
        let film = belt().film_damping * rate + squeezed(1.0 + 0.01 * 1.5e-3 / belt().film_thickness, rate);
        assert_near(apart, film, belt().film_damping, 1e-3, "the film's across a gap");
    }
}

/// Force of oil that is squeezed out of a gap, N; `wide` is 1 + gap/(film thickness).
fn squeezed(wide: f64, rate: f64) -> f64 {
    let closing = 0.5 * (rate + rate.hypot(SQUEEZE_SMOOTHING) - SQUEEZE_SMOOTHING);
    belt().squeeze_damping * closing / wide.powi(3)
}

/// Oil that is squeezed out of a gap dissipates power at any rate and none at rest, and cavitates where the elements separate.
#[test]
fn squeezed_oil_dissipates_and_cavitates() {
    let dry = PushElements {
        damping: 0.0,
        film_damping: 0.0,
        ..belt()
    };
    for nu in [0.99, 0.999, 1.0, 1.005] {
        let force = |rate: f64| push_force(&dry, nu, rate).viscous;
        assert_eq!(force(0.0), 0.0, "at rest");
        for rate in [1e-3, 0.1, 10.0] {
            assert!(force(rate) > 0.0 && force(-rate) < 0.0, "ν = {nu}, {rate} 1/s");
            assert!(
                force(-rate) > -0.5 * SQUEEZE_SMOOTHING * dry.squeeze_damping,
                "ν = {nu}: {} N of tension at {rate} 1/s",
                force(-rate)
            );
        }
        assert!(force(10.0) > 50.0 * -force(-10.0), "closing, not parting");
    }
}

fn collision(nu: f64, flow: f64, difference: f64) -> f64 {
    collision_force(&belt(), nu, flow, difference, upwinding(flow, difference))
}

/// ½ m_e ν |J| ΔV.
#[test]
fn collision_force_is_that_of_inelastic_impacts_where_elements_close_up() {
    for flow in [-30.0, 30.0] {
        let difference = -50.0 * CLOSING_SMOOTHING;
        let expected = 0.5 * belt().mass_per_length * 0.98 * 30.0 * difference;
        assert_near(
            collision(0.98, flow, difference),
            expected,
            expected.abs(),
            1e-3,
            "collision force",
        );
    }
}

/// The remaining share is the weight (J/3 m/s)⁻² of the flow, one in a hundred.
#[test]
fn separating_elements_are_free_in_a_fast_flow() {
    let difference = 50.0 * CLOSING_SMOOTHING;
    let full = 0.5 * belt().mass_per_length * 0.98 * 30.0 * difference;
    let share = collision(0.98, 30.0, difference) / full;
    assert!(share > 0.0 && share < 0.011, "{share}");
}

#[test]
fn convection_is_upwind_near_standstill() {
    for difference in [-1.0, -1e-3, 0.0, 1e-3, 1.0] {
        assert_near(upwinding(0.0, difference), 1.0, 1.0, 1e-15, "weight");
    }
}

#[test]
fn collision_force_dissipates() {
    let mut random = noise(2);
    for _ in 0..10_000 {
        let [nu, flow, difference] = [1.0 + 0.2 * random(), 200.0 * random(), 4.0 * random()];
        assert!(
            collision(nu, flow, difference) * difference > 0.0,
            "{nu} {flow} {difference}"
        );
    }
}

fn cell(flow: f64, density: f64, lag: f64) -> Transport<f64> {
    Transport { flow, density, lag }
}

#[test]
fn flux_takes_the_density_of_the_cell_before_when_flowing_forward() {
    let found = flux(&cell(7.0, 0.98, 0.0), &cell(3.0, 1.01, 0.0));
    assert_near(found, 3.0 * 0.98, 3.0, 1e-12, "flux");
}

#[test]
fn flux_takes_the_density_of_the_cell_after_when_flowing_backward() {
    let found = flux(&cell(7.0, 0.98, 0.0), &cell(-3.0, 1.01, 0.0));
    assert_near(found, -3.0 * 1.01, 3.0, 1e-12, "flux");
}

/// A lag takes J of the middle of the cell upstream.
#[test]
fn flux_lags_where_elements_separate_freely() {
    let forward = flux(&cell(7.0, 0.98, 0.2), &cell(3.0, 1.01, 0.4));
    assert_near(forward, 2.8 * 0.98, 3.0, 1e-12, "forward");
    let backward = flux(&cell(7.0, 0.98, 0.2), &cell(-3.0, 1.01, 0.4));
    assert_near(backward, -2.6 * 1.01, 3.0, 1e-12, "backward");
}

/// At rest the flux between equal cells is zero, and between others it is bounded by the width of the switch.
#[test]
fn flux_at_rest_conserves() {
    assert_eq!(flux(&cell(0.0, 1.02, 0.0), &cell(0.0, 1.02, 0.0)), 0.0);
    let found = flux(&cell(0.0, 0.9, 0.0), &cell(0.0, 1.1, 0.0));
    assert_near(found, -0.1 * UPWIND_SMOOTHING, UPWIND_SMOOTHING, 1e-12, "flux at rest");
}

/// Between equal cells the flux is J ν at every speed, and the mirrored belt has the mirrored flux.
#[test]
fn flux_has_no_preferred_direction() {
    let mut random = noise(3);
    for _ in 0..1000 {
        let flow = random() * (30.0 * random()).exp();
        let [before, after] = [0.98, 1.01].map(|density| cell(flow, density, 0.1 * random()));
        let alike = cell(flow, 0.97, 0.0);
        assert_near(flux(&alike, &alike), 0.97 * flow, flow.abs(), 1e-9, "cells alike");
        let mirrored = flux(&after, &cell(-flow, before.density, before.lag));
        assert_eq!(flux(&before, &after), -mirrored, "{before:?} {after:?}");
    }
}

/// There is a lag only where elements separate in a fast flow without contact.
#[test]
fn elements_separate_freely_without_contact_only() {
    let difference = 0.4;
    assert_eq!(lag(difference, 1.0, 0.0), 0.0);
    assert_eq!(lag(difference, 0.0, 1.0), 0.0);
    assert_eq!(lag(difference, 0.0, 0.0), 0.5 * difference);
}
