//! Bad parameters and inputs: each is refused with a message that names variable, value and allowed
//! range.

use pushbelt::fmi::table::{Access, Kind};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{
    Inputs, ParameterError, Parameters, RingModel, Setting, inputs, parameters,
};

fn refused(change: impl FnOnce(&mut Parameters)) -> ParameterError {
    let mut parameters = Parameters::default();
    change(&mut parameters);
    let error = parameters.validate().expect_err("refused");
    let built = Variator::new(parameters).map(drop);
    assert!(built.is_err(), "a variator is built from refused parameters");
    error
}

fn accepted(change: impl FnOnce(&mut Parameters)) {
    let mut parameters = Parameters::default();
    change(&mut parameters);
    assert_eq!(parameters.validate(), Ok(()));
}

/// Sets each number beyond its range: the error that `refused` returns names variable and value.
/// How many numbers there are.
fn refuse_beyond<S>(
    all: impl Iterator<Item = Setting<S>>,
    refused: impl Fn(&dyn Fn(&mut S)) -> ParameterError,
) -> usize {
    let mut numbers = 0;
    for one in all {
        let (name, range) = (one.name(), one.range());
        let named = |error: ParameterError, value: String| {
            assert_eq!((&error.variable, error.value), (&name, value));
            assert!(!error.range.is_empty());
        };
        match (one.variable().kind, range) {
            (
                Kind::Real {
                    access: Access::Setting { set, .. },
                    ..
                },
                Some(range),
            ) => {
                let (min, max) = range.into_inner();
                let margin = |limit: f64| 0.1 * limit.abs().max(1e-3);
                let beyond = [min - margin(min), max + margin(max)];
                for bad in [&beyond[..], &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]].concat() {
                    named(refused(&|of| set(of, bad)), bad.to_string());
                }
                numbers += 1;
            }
            (
                Kind::Integer {
                    access: Access::Setting { set, .. },
                    range: Some((min, max)),
                },
                _,
            ) => {
                for bad in [min - 1, max + 1, -4] {
                    named(refused(&|of| set(of, bad)), bad.to_string());
                }
                numbers += 1;
            }
            _ => {}
        }
    }
    numbers
}

#[test]
fn every_parameter_and_input_refuses_what_is_beyond_its_range() {
    let numbers = refuse_beyond(parameters(), |change| refused(change));
    assert!(numbers > 70, "{numbers} numbers");
    let of_inputs = refuse_beyond(inputs(), |change| {
        let mut inputs = Inputs::default();
        change(&mut inputs);
        inputs.validate().expect_err("refused")
    });
    assert_eq!(of_inputs, 8);
    let mut open = Inputs::default();
    open.primary.clamping_force = 0.0;
    assert_eq!(open.validate(), Ok(()), "an open pulley is legal");
}

/// Parameters that don't fit each other: a change, the variable and value that the error names, and
/// a part of the range.
#[test]
fn what_does_not_fit_is_named_with_variable_value_and_range() {
    type Case = (fn(&mut Parameters), &'static str, &'static str, &'static str);
    #[rustfmt::skip]
    let cases: [Case; 13] = [
        (|p| p.mesh.secondary_arc = 7, "mesh.secondaryArc", "7", "an even number"),
        // The wedge must open wider than the friction angle.
        (|p| p.friction.pulley = 0.2, "geometry.wedgeAngle", "", "friction.pulley = 0.2"),
        (|p| p.geometry.wedge_angle = 0.089, "geometry.wedgeAngle", "0.089", ""),
        (|p| (p.ring_model, p.spatial) = (RingModel::Ale0, true), "ring.spatial", "true", "unless ring.model"),
        // The belt must reach around pulleys that do not touch.
        (|p| p.geometry.belt_length = 0.336, "geometry.beltLength", "0.336", "between 0.342"),
        (|p| p.geometry.belt_length = 0.3422, "geometry.beltLength", "0.3422", "between 0.342"),
        (|p| p.geometry.belt_length = 0.9, "geometry.beltLength", "0.9", ""),
        (|p| p.geometry.center_distance = 0.4, "geometry.beltLength", "", ""),
        (|p| p.belt.play = 0.0701, "belt.play", "0.0701", "a tenth of the belt"),
        (|p| p.primary.min_radius = 0.082, "primary.minRadius", "", "below primary.maxRadius = 0.082"),
        (|p| p.initial.ratio = 90.0, "initial.ratio", "90", ""),
        (|p| p.initial.ratio = 0.011, "initial.ratio", "0.011", ""),
        // No pair of radii within these stops closes the belt.
        (|p| (p.primary.max_radius, p.secondary.max_radius) = (0.040, 0.040), "", "", "none"),
    ];
    for (change, variable, value, range) in cases {
        let error = refused(change);
        assert!(variable.is_empty() || error.variable == variable, "{error}");
        assert!(value.is_empty() || error.value == value, "{error}");
        assert!(error.range.contains(range), "{error}");
    }
    let text = refused(|p| p.mesh.secondary_arc = 7).to_string();
    assert!(
        text.starts_with("mesh.secondaryArc = 7 is out of range: an even number"),
        "{text}"
    );
    // During a run friction can change.
    let mut variator = Variator::new(Parameters::default()).unwrap();
    let error = variator.set_friction(0.5, 0.01).expect_err("refused");
    assert_eq!(error.variable, "friction.pulley");
    assert!(error.range.starts_with("below 0.194"), "{error}");
}

/// Limits, limit cases of theory, a loaded belt that rests some per cent beyond the stop, and the
/// published reference belt.
#[test]
fn what_fits_is_accepted() {
    accepted(|p| p.geometry.wedge_angle = 0.12);
    accepted(|p| p.belt.play = 0.069);
    for ratio in [2.2, 1.0 / 2.25, 2.7] {
        accepted(|p| p.initial.ratio = ratio);
    }
    accepted(|p| {
        (p.friction.pulley, p.friction.ring) = (0.0, 0.0);
        (p.belt.play, p.belt.pitch_offset) = (0.0, 0.0);
        p.primary.tilt.stiffness = 1e30;
        p.initial.primary_speed = 0.0;
    });
    accepted(|p| p.initial.primary_speed = -100.0);
    accepted(|p| {
        (p.geometry.center_distance, p.geometry.belt_length) = (0.155, 0.661_195);
        (p.friction.pulley, p.initial.ratio) = (0.11, 2.5);
        p.primary.min_radius = 0.028;
    });
}

#[test]
fn the_ratios_named_in_the_message_are_accepted() {
    let error = refused(|p| p.initial.ratio = 10.0);
    let words = error.range.split([' ', ',']);
    let ends: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
    let [low, high] = ends[..] else { panic!("{error}") };
    // Mirrored stops have a mirrored range.
    assert!((low * high - 1.0).abs() < 1e-5, "{error}");
    // A loaded belt rests some per cent beyond.
    for (inside, outside) in [(low * 0.95, low * 0.94), (high * 1.05, high * 1.07)] {
        accepted(|p| p.initial.ratio = inside);
        refused(|p| p.initial.ratio = outside);
    }
    let range = Parameters::default().ratio_range();
    assert!((range.start() - low).abs() < 1e-6 && (range.end() - high).abs() < 1e-6);
}
