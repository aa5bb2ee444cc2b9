//! Radii, torques and shift rate.

use pushbelt::pulley::PerPulley;

use super::settings;
use crate::law::{Law, State};
use crate::settings::Settings;

/// The radii are those of the detailed unit, between the stops. Between points of the table they
/// err by less than a micrometre.
#[test]
fn radii_close_the_belt_and_meet_the_stops() {
    let law = Law::new(&settings()).expect("laws");
    let parameters = &law.parameters;
    let (least, most) = parameters.ratio_range().into_inner();
    for reference in [least, 0.5, 0.77, 1.0, 2.1, most] {
        let PerPulley { primary, secondary } = parameters.pitch_radii(reference).expect("a closed belt");
        let found = law.radii((secondary / primary).ln());
        let off = [found.primary.value - primary, found.secondary.value - secondary].map(f64::abs);
        assert!(off[0].max(off[1]) < 1e-6, "{reference}: {off:?}");
    }
    for (stop, [primary, secondary]) in [(law.stops.start(), [0.082, 0.03]), (law.stops.end(), [0.03, 0.082])]
    {
        let found = law.radii(*stop);
        let off = [found.primary.value - primary, found.secondary.value - secondary].map(f64::abs);
        assert!(off[0].min(off[1]) < 1e-6, "{off:?}");
    }
}

/// T_P, T_S and ℓ' of settings at speeds of the primary and the secondary shaft, and ln i.
fn torques(settings: &Settings) -> impl Fn(f64, f64, f64) -> [f64; 3] + use<> {
    let (law, inputs) = (Law::new(settings).expect("laws"), settings.inputs);
    move |primary, secondary, log_ratio| {
        let state = State {
            speeds: PerPulley { primary, secondary },
            log_ratio,
            thrust_ratio: 1.0,
        };
        let point = law.point(&state, &inputs);
        let out = point.ratio * (point.torque() - point.torque_loss);
        [point.torque(), out, law.shift(&point).value]
    }
}

#[test]
fn reverse_running_is_the_mirror_image() {
    let found = torques(&settings());
    for (primary, secondary) in [(200.0, 150.0), (30.0, 31.0), (0.5, 0.2), (0.0, 0.3), (-3.0, 1.0)] {
        let [into, out, shift] = found(primary, secondary, 0.25);
        let [back_in, back_out, back] = found(-primary, -secondary, 0.25);
        for (one, other) in [(into, back_in), (out, back_out), (shift, -back)] {
            assert!((one + other).abs() < 1e-12 * one.abs().max(1.0), "{primary}");
        }
    }
}

#[test]
fn torque_is_continuous_and_falls_in_fast_sliding() {
    let mut settings = settings();
    let torques_of = torques(&settings);
    // Near standstill the torque grows by its capacity within 0.02 rad/s. At speed the belt slips
    // through.
    let speeds: [fn(f64) -> [f64; 2]; 2] = [|t| [2.0 * t - 1.0, 0.4], |t| [200.0, 185.0 * (1.0 - t)]];
    let [_, (most, fast)] = speeds.map(|speeds| {
        let torque = |k: i32| {
            let [primary, secondary] = speeds(f64::from(k) / 2e4);
            torques_of(primary, secondary, 0.1)[0]
        };
        let values: Vec<f64> = (0..=20_000).map(torque).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        assert!(values.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.01 * most));
        (most, values[20_000])
    });
    let fall = 1.0 - fast / most;
    assert!((fall - settings.parameters.friction.fall).abs() < 1e-3, "{fall}");
    settings.parameters.friction.pulley *= 0.7;
    assert!((torques(&settings)(200.0, 0.0, 0.1)[0] - 0.7 * fast).abs() < 1e-12 * fast);
}

/// Sliding speeds at which the belt grips and slips through, in both directions of running and
/// between them.
#[test]
fn slope_of_the_traction_is_that_of_its_values() {
    let (settings, step) = (settings(), 1e-7);
    let law = Law::new(&settings).expect("laws");
    for (primary, sliding) in [
        (200.0, 0.01),
        (200.0, -0.02),
        (200.0, 3.0),
        (-200.0, 0.013),
        (0.2, 0.001),
    ] {
        let state = State {
            speeds: PerPulley {
                primary,
                secondary: 0.9 * primary,
            },
            log_ratio: 0.1,
            thrust_ratio: 1.0,
        };
        let point = law.point(&state, &settings.inputs);
        let [before, after] = [-step, step].map(|by| law.traction(&point, sliding + by).value);
        let (found, expected) = (law.traction(&point, sliding).slope, (after - before) / (2.0 * step));
        let off = (found - expected).abs();
        assert!(
            off < 1e-4 * expected.abs(),
            "{primary} {sliding}: {found}, not {expected}"
        );
    }
}
