//! Tilt of a sheave, drag of a shaft, cylinder.

use crate::{assert_near, slope};
use pushbelt::cylinder::Cylinder;
use pushbelt::shaft::ShaftDrag;
use pushbelt::tilt::Tilt;

const TILT: Tilt = Tilt {
    stiffness: 1.79e6,
    clearance: 0.624e-3,
    time: 2e-3,
};

/// On the laboratory variator, with a lever of a uniform pressure of 36.5 mm at ratio 1: to 1 %.
#[test]
fn the_tilt_is_that_of_the_measured_opening() {
    for force in [5e3, 10e3, 20e3, 30e3] {
        let opening = (1.0 + 0.02 * (force / 1e3 - 20.0)) * 1e-3;
        let moment = |share: f64| TILT.moment([share * 1.02 * opening, 0.0], [0.0; 2])[0];
        let bounds = moment(0.99)..moment(1.01);
        assert!(bounds.contains(&(force * 0.0365)), "{force} N: {bounds:?}");
    }
}

#[test]
fn the_moment_is_the_slope_of_the_energy_in_every_direction() {
    let mut linear = TILT;
    linear.clearance = 0.0;
    for law in [TILT, linear] {
        for [x, y] in [[0.0, 0.0], [1e-6, -2e-6], [3e-4, 1e-4], [4e-4, -5e-4], [-9e-4, 8e-4]] {
            let slopes = [
                slope(|h| law.energy([x + h, y]), 1e-8),
                slope(|h| law.energy([x, y + h]), 1e-8),
            ];
            for (found, moment) in slopes.into_iter().zip(law.moment([x, y], [0.0; 2])) {
                assert_near(found, moment, 1.0, 1e-3, "moment");
            }
        }
    }
}

const DRAG: ShaftDrag = ShaftDrag {
    constant: 0.15,
    viscous: 5.0e-4,
    bearing_friction: 1.8e-3,
    bearing_radius: 0.02,
};

/// At 2000 rpm under 3 and 4 kN: seals, bearings, oil. At a standstill and far beyond any speed.
#[test]
fn drag_of_a_shaft() {
    let [speed, load] = [209.44, 5.0e3];
    let drag = DRAG.loads(speed, [3.0e3, -4.0e3]).torque;
    assert_near(drag, 0.15 + 3.6e-5 * load + 5.0e-4 * speed, 1.0, 1e-8, "drag");
    assert_eq!(DRAG.loads(-speed, [3.0e3, -4.0e3]).torque, -drag);
    assert_eq!(DRAG.loads(0.0, [0.0; 2]).torque, 0.0);
    let unloaded = DRAG.loads(1.0e4, [0.0; 2]).torque;
    assert_near(unloaded, 5.15, 1.0, 1e-12, "drag of oil and seals");
    assert_eq!(ShaftDrag::default().loads(speed, [3.0e3, -4.0e3]).torque, 0.0);
}

#[test]
fn derivatives_of_the_drag_match_differences() {
    for omega in [-150.0, -1.0, 0.0, 0.5, 3.0, 1.0e3] {
        for [x, y] in [[0.0, 0.0], [0.3, -0.8], [2.0e3, 500.0]] {
            let drag = DRAG.loads(omega, [x, y]);
            let found = [
                slope(|h| DRAG.loads(omega + h, [x, y]).torque, 1e-4),
                slope(|h| DRAG.loads(omega, [x + h, y]).torque, 1e-3),
                slope(|h| DRAG.loads(omega, [x, y + h]).torque, 1e-3),
            ];
            let [by_x, by_y] = drag.by_resultant;
            for (found, exact) in found.into_iter().zip([drag.by_speed, by_x, by_y]) {
                assert_near(found, exact, 1.0, 1e-9, "derivative");
            }
        }
    }
}

/// Half a millimetre per second is far beyond a regularisation velocity of a micrometre per second.
#[test]
fn forces_of_a_cylinder() {
    let cylinder = Cylinder {
        area: 0.012,
        spring_force: 400.0,
        spring_stiffness: 1.5e4,
        centrifugal: 0.02,
        seal: 150.0,
    };
    let push = cylinder.passive_force(0.01, -200.0);
    assert_near(push, 400.0 - 150.0 + 800.0, 1.0, 1e-9, "push");
    for z_dot in [-5e-4, 0.0, 5e-4_f64] {
        let expected = if z_dot == 0.0 { 0.0 } else { 150.0 * z_dot.signum() };
        assert_near(cylinder.drag(z_dot, 1e-6), expected, 1.0, 1e-3, "drag");
    }
    let energy = slope(|h| cylinder.energy(0.01 + h), 1e-4);
    let of_spring = cylinder.passive_force(0.01, 0.0);
    assert_near(energy, -of_spring, 1.0, 1e-6, "energy of the spring");
    let none = Cylinder::default();
    assert_eq!([none.passive_force(-0.01, 300.0), none.drag(-0.1, 5e-4)], [0.0; 2]);
    assert_eq!(none.energy(-0.01), 0.0);
}
