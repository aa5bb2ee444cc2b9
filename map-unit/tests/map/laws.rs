//! Radii, torques and shift rate.

use std::f64::consts::PI;

use pushbelt::pulley::PerPulley;
use pushbelt_map_unit::law::{Acting, Law, Radii, State};
use pushbelt_map_unit::settings::Settings;

use crate::settings;

/// The radii are pitch radii, and their quotient is the ratio. Between places of the table they err by less than a micrometre.
#[test]
fn radii_close_the_belt_and_meet_the_stops() {
    let parameters = settings().parameters;
    let radii = Radii::new(&parameters).expect("radii");
    for (stop, [primary, secondary]) in radii.stops.into_iter().zip([[0.082, 0.03], [0.03, 0.082]]) {
        let (found, _) = radii.at(stop).primary;
        let off = (found - primary).abs().min((stop.exp() * found - secondary).abs());
        assert!(off < 1e-6, "{off:e}");
    }
    for ratio in [0.4, 0.77, 1.0, 2.3_f64] {
        let (primary, _) = radii.at(ratio.ln()).primary;
        let [p, s] = [primary, ratio * primary].map(|radius| radius + parameters.belt.pitch_offset);
        let distance = parameters.geometry.center_distance;
        let angle = ((p - s) / distance).acos();
        let length = 2.0 * ((distance.powi(2) - (p - s).powi(2)).sqrt() + p * (PI - angle) + s * angle);
        let off = length - parameters.geometry.belt_length;
        assert!(off.abs() < 6e-6, "{ratio}: {length}");
    }
}

/// T_P, T_S and ℓ' of settings at speeds of the primary and the secondary shaft, and ln i.
fn torques(settings: &Settings) -> impl Fn(f64, f64, f64) -> [f64; 3] + use<> {
    let law = Law::new(settings).expect("laws");
    let acting = Acting {
        inputs: settings.inputs,
        thrust_ratio: 1.0,
    };
    move |primary, secondary, log_ratio| {
        let speeds = PerPulley { primary, secondary };
        let frame = law.frame(&State { speeds, log_ratio }, &acting);
        let point = law.point(&frame, frame.sliding(speeds));
        let torque = frame.torque * point.traction.value;
        let (shift, _) = law.shift(&frame, &point);
        [torque, frame.ratio * (torque - point.torque_loss), shift]
    }
}

#[test]
fn reverse_running_is_the_mirror_image() {
    let of = torques(&settings());
    for (primary, secondary) in [(200.0, 150.0), (30.0, 31.0), (0.5, 0.2), (0.0, 0.3), (-3.0, 1.0)] {
        let [into, out, shift] = of(primary, secondary, 0.25);
        let [back_in, back_out, back] = of(-primary, -secondary, 0.25);
        for (one, other) in [(into, back_in), (out, back_out), (shift, -back)] {
            assert!((one + other).abs() < 1e-12 * one.abs().max(1.0), "{primary}");
        }
    }
}

#[test]
fn torque_is_continuous_and_falls_in_fast_sliding() {
    let mut settings = settings();
    let of = torques(&settings);
    // Near standstill the torque grows by its capacity within 0.02 rad/s. At speed the belt slips through.
    let speeds: [fn(f64) -> [f64; 2]; 2] = [|t| [2.0 * t - 1.0, 0.4], |t| [200.0, 185.0 * (1.0 - t)]];
    let [_, (most, fast)] = speeds.map(|speeds| {
        let at = |k: i32| of(speeds(f64::from(k) / 2e4)[0], speeds(f64::from(k) / 2e4)[1], 0.1)[0];
        let values: Vec<f64> = (0..=20_000).map(at).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        assert!(values.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.01 * most));
        (most, values[20_000])
    });
    let fall = 1.0 - fast / most;
    assert!((fall - settings.parameters.friction.fall).abs() < 1e-3, "{fall}");
    settings.parameters.friction.pulley *= 0.7;
    assert!((torques(&settings)(200.0, 0.0, 0.1)[0] - 0.7 * fast).abs() < 1e-12 * fast);
}
