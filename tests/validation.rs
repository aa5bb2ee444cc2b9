//! Bad parameters and inputs: each is refused with a message that names variable, value and allowed range.

use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Inputs, ParameterError, ParameterRows, Parameters, RingModel, RowValue, range_of};

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

#[test]
fn the_defaults_are_legal() {
    assert_eq!(Parameters::default().validate(), Ok(()));
    assert_eq!(Inputs::default().validate(), Ok(()));
}

#[test]
fn every_parameter_refuses_what_is_beyond_its_range() {
    let rows = [ParameterRows::WHOLE, ParameterRows::PRIMARY, ParameterRows::SECONDARY];
    let mut numbers = 0;
    for row in rows.into_iter().flatten() {
        let named = |error: ParameterError, value: String| {
            assert_eq!((error.variable, error.value), (row.name, value));
            assert!(!error.range.is_empty());
        };
        match &row.value {
            RowValue::Real(_, _, [min, max], field) => {
                let margin = |limit: f64| 0.1 * limit.abs().max(1e-3);
                let beyond = [min - margin(*min), max + margin(*max)];
                for bad in [&beyond[..], &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]].concat() {
                    named(refused(|p| (field.set)(p, bad)), bad.to_string());
                }
                numbers += 1;
            }
            RowValue::Count(_, [min, max], field) => {
                for bad in [min - 1, max + 1, -4] {
                    named(refused(|p| (field.set)(p, bad)), bad.to_string());
                }
                numbers += 1;
            }
            RowValue::Switch(..) | RowValue::Choice(..) => {}
        }
    }
    assert!(numbers > 70, "{numbers} numbers");
}

#[test]
fn stiffness_mass_and_mesh_must_be_above_zero() {
    for name in [
        "belt.pushStiffness",
        "ring.axialStiffness",
        "ring.bendingStiffness",
        "contact.stiffness",
        "secondary.tiltStiffness",
        "belt.massPerLength",
        "primary.inertia",
        "friction.velocity",
        "solver.maxStep",
        "mesh.primaryArc",
        "mesh.cellsPerElement",
    ] {
        assert!(range_of(name).expect("a range").0 > 0.0, "{name}");
    }
    let error = refused(|p| p.mesh.secondary_arc = 7);
    assert_eq!(
        error.to_string().split(',').next(),
        Some("mesh.secondaryArc = 7 is out of range: an even number")
    );
}

#[test]
fn the_wedge_must_open_wider_than_the_friction_angle() {
    let error = refused(|p| p.friction.pulley = 0.2);
    assert_eq!(error.variable, "geometry.wedgeAngle");
    assert!(error.range.contains("friction.pulley = 0.2"), "{error}");
    assert_eq!(
        refused(|p| p.geometry.wedge_angle = 0.089).variable,
        "geometry.wedgeAngle"
    );
    accepted(|p| p.geometry.wedge_angle = 0.12);
    accepted(|p| p.friction.pulley = 0.0);
    // During a run friction can change.
    let mut variator = Variator::new(Parameters::default()).unwrap();
    let error = variator.set_friction(0.5, 0.01).expect_err("refused");
    assert_eq!(error.variable, "friction.pulley");
    assert!(error.range.starts_with("below 0.194"), "{error}");
}

#[test]
fn messages_show_booleans_as_true_and_false() {
    let error = refused(|p| {
        p.ring_model = RingModel::Ale0;
        p.spatial = true;
    });
    assert_eq!(
        error.to_string(),
        "ring.spatial = true is out of range: false, unless ring.model is ALE"
    );
}

#[test]
fn the_belt_must_reach_around_pulleys_that_do_not_touch() {
    for short in [0.1, 2.0 * 0.168, 2.0 * 0.168 + 2.0 * std::f64::consts::PI * 1e-3] {
        let error = refused(|p| p.geometry.belt_length = short);
        assert_eq!(
            (error.variable, &error.value),
            ("geometry.beltLength", &short.to_string())
        );
        assert!(error.range.starts_with("between 0.342"), "{error}");
    }
    assert_eq!(
        refused(|p| p.geometry.belt_length = 0.9).variable,
        "geometry.beltLength"
    );
    assert_eq!(
        refused(|p| p.geometry.center_distance = 0.4).variable,
        "geometry.beltLength"
    );
}

#[test]
fn play_is_at_most_a_tenth_of_the_belt() {
    accepted(|p| p.belt.play = 0.0);
    accepted(|p| p.belt.play = 0.069);
    let error = refused(|p| p.belt.play = 0.0701);
    assert_eq!(error.variable, "belt.play");
    assert!(error.range.contains("a tenth of the belt"), "{error}");
}

#[test]
fn stops_must_leave_a_range_and_the_initial_ratio_must_lie_in_it() {
    let error = refused(|p| p.primary.min_radius = p.primary.max_radius);
    assert_eq!(error.variable, "primary.minRadius");
    assert!(error.range.contains("below primary.maxRadius = 0.082"), "{error}");
    accepted(|p| p.initial.ratio = 2.2);
    accepted(|p| p.initial.ratio = 1.0 / 2.25);
    // A loaded belt rests some per cent beyond the stop.
    accepted(|p| p.initial.ratio = 2.7);
    for beyond in [3.0, 1.0 / 3.0, 90.0, 0.011] {
        let error = refused(|p| p.initial.ratio = beyond);
        assert_eq!((error.variable, &error.value), ("initial.ratio", &beyond.to_string()));
    }
    // No pair of radii within these stops closes the belt.
    let error = refused(|p| {
        p.primary.max_radius = 0.040;
        p.secondary.max_radius = 0.040;
    });
    assert!(error.range.starts_with("none"), "{error}");
}

/// The range in the message is the accepted range.
#[test]
fn the_ratios_named_in_the_message_are_accepted() {
    let error = refused(|p| p.initial.ratio = 10.0);
    let ends: Vec<f64> = error
        .range
        .split([' ', ','])
        .filter_map(|word| word.parse().ok())
        .collect();
    let [low, high] = ends[..] else { panic!("{error}") };
    // Mirrored stops have a mirrored range.
    assert!((low * high - 1.0).abs() < 1e-5, "{error}");
    // A loaded belt rests some per cent beyond.
    for (inside, outside) in [(low * 0.95, low * 0.94), (high * 1.05, high * 1.07)] {
        accepted(|p| p.initial.ratio = inside);
        refused(|p| p.initial.ratio = outside);
    }
    let parameters = Parameters::default();
    let (lowest, highest) = parameters.ratio_range();
    assert!((lowest - low).abs() < 1e-6 && (highest - high).abs() < 1e-6);
}

#[test]
fn limit_cases_of_theory_are_legal() {
    accepted(|p| {
        p.friction.pulley = 0.0;
        p.friction.ring = 0.0;
        p.belt.play = 0.0;
        p.belt.pitch_offset = 0.0;
        p.primary.tilt.stiffness = 1e30;
        p.initial.primary_speed = 0.0;
    });
    accepted(|p| p.initial.primary_speed = -100.0);
}

#[test]
fn the_published_reference_belt_is_legal() {
    accepted(|p| {
        p.geometry.center_distance = 0.155;
        p.geometry.belt_length = 0.661_195;
        p.friction.pulley = 0.11;
        p.initial.ratio = 2.5;
        p.primary.min_radius = 0.028;
    });
}

#[test]
fn inputs_must_be_finite_and_close_the_pulleys() {
    let refused = |change: fn(&mut Inputs)| {
        let mut inputs = Inputs::default();
        change(&mut inputs);
        inputs.validate().expect_err("refused")
    };
    let error = refused(|i| i.primary.clamping_force = -1.0);
    assert_eq!(
        error.to_string(),
        "primary.clampingForce = -1 is out of range: 0 to 500000"
    );
    assert_eq!(
        refused(|i| i.secondary.clamping_force = f64::NAN).variable,
        "secondary.clampingForce"
    );
    assert_eq!(refused(|i| i.primary.torque = f64::INFINITY).variable, "primary.torque");
    assert_eq!(refused(|i| i.secondary.torque = f64::NAN).variable, "secondary.torque");
    assert_eq!(
        refused(|i| i.secondary.speed_setpoint = f64::NEG_INFINITY).variable,
        "secondary.speedSetpoint"
    );
    let mut open = Inputs::default();
    open.primary.clamping_force = 0.0;
    assert_eq!(open.validate(), Ok(()), "an open pulley is legal");
}
