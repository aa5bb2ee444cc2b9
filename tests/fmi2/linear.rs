//! The linear model as a C program gets it.

use std::ffi::CStr;
use std::ptr::null_mut;

use pushbelt::fmi::log::Status::{self, Error, Ok, Warning};
use pushbelt::unit::exports::linear_c::{pushbeltFreeText, pushbeltLinearize};
use serde_json::Value;

use crate::importer::*;

/// Status and result of a call.
fn linearize(importer: &Importer, frequency: f64) -> (Status, Option<Value>) {
    // Not null before, so that an unchanged pointer is detected.
    let mut text = c"before".as_ptr().cast_mut();
    // SAFETY: an instance and a valid pointer; the text comes from the call and is read before it is freed.
    unsafe {
        let status = pushbeltLinearize(importer.c, frequency, &mut text);
        let found = (!text.is_null()).then(|| {
            let json = CStr::from_ptr(text).to_str().expect("UTF-8");
            serde_json::from_str(json).expect("JSON")
        });
        pushbeltFreeText(text);
        (status, found)
    }
}

/// An instance in the steady state of a coarse reference ring under these inputs.
fn steady(inputs: &[(&str, f64)]) -> Importer {
    let importer = Importer::new(c"steady");
    importer.make_cheap();
    assert_eq!(importer.set_boolean("initial.steady", 1), Ok);
    for (name, value) in inputs {
        assert_eq!(importer.set_real(name, *value), Ok);
    }
    importer.start();
    importer
}

/// The log has a warning with this text.
fn assert_warned(importer: &Importer, part: &str) {
    let record = importer.record.0.borrow();
    let mut warnings = record.iter().filter(|(_, status, _, _)| *status == Warning as i32);
    assert!(
        warnings.any(|(_, _, _, text)| text.contains(part)),
        "{part}: {record:?}"
    );
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn a_steady_instance_has_a_model_in_the_names_of_the_interface() {
    let (_, found) = linearize(&steady(&[]), 50.0);
    let held = found.expect("a model");
    let held: Vec<(String, f64)> = held["inputs"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|input| {
            (
                input["name"].as_str().expect("a name").to_owned(),
                input["held"].as_f64().expect("a number"),
            )
        })
        .collect();
    let held: Vec<(&str, f64)> = held.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    // Under the loads that hold the point there is no remark.
    let importer = steady(&held);
    let before = importer.readings();
    let (status, found) = linearize(&importer, 50.0);
    assert_eq!(status, Ok, "{:?}", importer.record);
    let model = found.expect("a model");
    let names: Vec<_> = held.iter().map(|(name, _)| *name).collect();
    assert_eq!(
        names,
        [
            "primary.torque",
            "primary.clampingForce",
            "secondary.torque",
            "secondary.clampingForce"
        ]
    );
    let (n, rows) = (model["states"].as_array().expect("a list").len(), real_outputs().len());
    assert!(n >= 2 && model["poles"].as_array().expect("a list").len() == n);
    for (matrix, height, width) in [("A", n, n), ("B", n, 4), ("C", rows, n), ("D", rows, 4)] {
        let found = model[matrix].as_array().expect("a matrix");
        assert!(
            found.len() == height && found.iter().all(|row| numbers(row).len() == width),
            "{matrix}"
        );
    }
    assert_eq!(model["macroSlip"], Value::Bool(false));
    assert_eq!(model["remarks"], Value::Array(Vec::new()));
    // The parser of these tests rounds in the last digit.
    let same = |found: &Value, expected: f64| {
        let found = found.as_f64().expect("a number");
        assert!((found - expected).abs() <= 1e-15 * expected.abs(), "{found} {expected}");
    };
    same(&model["slip"], importer.real("slip"));
    for output in model["outputs"].as_array().expect("a list") {
        same(
            &output["value"],
            importer.real(output["name"].as_str().expect("a name")),
        );
    }
    // The instance has not changed.
    assert_eq!(importer.readings(), before);
    assert_eq!(importer.step(0.0, 1e-3), Ok);
}

#[test]
fn a_difference_from_the_specified_point_is_a_warning() {
    let importer = steady(&[("primary.torque", 400.0)]);
    let (status, found) = linearize(&importer, 50.0);
    let model = found.expect("a model");
    assert_eq!(status, Warning);
    assert_eq!(model["macroSlip"], Value::Bool(false));
    assert!(model["slip"].as_f64().expect("a number") < 0.05);
    let primary = &model["inputs"][0];
    assert_eq!(primary["given"].as_f64(), Some(400.0));
    assert!(primary["held"].as_f64().expect("a number") < 200.0);
    assert_warned(&importer, "400 N.m is specified");
}

/// Between prescribed speeds the belt may slip through permanently.
#[test]
fn a_belt_that_slips_through_is_a_warning() {
    let importer = Importer::new(c"slipping");
    importer.make_cheap();
    assert_eq!(importer.set_boolean("initial.steady", 1), Ok);
    for (drive, setpoint, speed) in [
        ("primary.drive", "primary.speedSetpoint", 200.0),
        ("secondary.drive", "secondary.speedSetpoint", 100.0),
    ] {
        assert_eq!(importer.set_integer(drive, 2), Ok);
        assert_eq!(importer.set_real(setpoint, speed), Ok);
    }
    importer.start();
    let (status, found) = linearize(&importer, 50.0);
    let model = found.expect("a model");
    assert_eq!(status, Warning);
    assert_eq!(model["macroSlip"], Value::Bool(true));
    assert!(model["slip"].as_f64().expect("a number") > 0.4);
    assert_warned(&importer, "slips through (macroSlip)");
}

#[test]
fn a_call_without_a_model_logs_the_reason_and_the_run_continues() {
    let importer = Importer::new(c"early");
    assert_eq!(linearize(&importer, 50.0), (Error, None));
    assert!(importer.last().contains("not allowed"), "{}", importer.last());

    let cold = Importer::running(c"cold");
    assert_eq!(linearize(&cold, 50.0), (Error, None));
    assert!(cold.last().contains("friction is still soft"), "{}", cold.last());
    assert_eq!(cold.step(0.0, 1e-3), Ok);

    let warm = steady(&[]);
    for frequency in [0.0, -1.0, 1e9, f64::NAN, f64::INFINITY] {
        assert_eq!(linearize(&warm, frequency), (Error, None));
        assert!(warm.last().contains("out of range"), "{}", warm.last());
    }
    // SAFETY: null is what this is about.
    unsafe {
        assert_eq!(pushbeltLinearize(warm.c, 50.0, null_mut()), Error);
        let mut text = c"before".as_ptr().cast_mut();
        assert_eq!(pushbeltLinearize(null_mut(), 50.0, &mut text), Error);
        assert!(text.is_null());
        pushbeltFreeText(null_mut());
    }
    assert_eq!(warm.step(0.0, 1e-3), Ok);
}
