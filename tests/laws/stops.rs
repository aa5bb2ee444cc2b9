//! End stops of the movable sheaves.

use crate::assert_near;
use pushbelt::pulley::{STOP_DAMPING, STOP_SMOOTHING, STOP_STIFFNESS};
use pushbelt_support::laws::{Travel, integral};

const TRAVEL: Travel = Travel {
    open: -8e-3,
    closed: 11e-3,
};

/// Elastic force at a place, N.
fn force(z: f64) -> f64 {
    TRAVEL.stop_force(z, 0.0).force
}

/// 20 µm beyond a stop: stiffness times penetration, towards the middle.
#[test]
fn stops_push_towards_the_middle() {
    let expected = STOP_STIFFNESS * 20e-6;
    for (z, sign) in [(TRAVEL.closed + 20e-6, -1.0), (TRAVEL.open - 20e-6, 1.0)] {
        assert_near(force(z), sign * expected, expected, 1e-3, "force");
    }
}

/// Half a millimetre from a stop its smoothed force is below a newton.
#[test]
fn a_sheave_between_the_stops_is_free() {
    for z in [TRAVEL.open + 5e-4, 0.0, TRAVEL.closed - 5e-4] {
        let found = TRAVEL.stop_force(z, 0.1);
        assert!(found.force.abs().max(found.viscous.abs()) < 1.0, "{found:?}");
    }
}

/// From beyond each stop into the travel.
#[test]
fn energy_integrates_the_force() {
    for ends in [
        [TRAVEL.closed - 1e-4, TRAVEL.closed + 2e-5],
        [TRAVEL.open + 1e-4, TRAVEL.open - 2e-5],
    ] {
        let stored = TRAVEL.energy(ends[1]) - TRAVEL.energy(ends[0]);
        assert_near(-integral(force, ends, 1000), stored, stored, 1e-10, "work");
    }
}

#[test]
fn damping_dissipates_energy_at_a_stop_only() {
    let full = STOP_STIFFNESS * STOP_DAMPING;
    for z_dot in [-0.1, 0.1] {
        for z in [TRAVEL.open - 20e-6, TRAVEL.closed + 20e-6] {
            let found = TRAVEL.stop_force(z, z_dot).viscous;
            assert_near(found, -full * z_dot, full, 1e-3, "damping");
        }
        for z in [TRAVEL.open, TRAVEL.open + STOP_SMOOTHING, 0.0, TRAVEL.closed] {
            assert!(TRAVEL.stop_force(z, z_dot).viscous * z_dot < 0.0, "at {z} m");
        }
    }
}
