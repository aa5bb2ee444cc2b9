//! The linear model as a C program gets it.

use crate::importer::Handles;
use crate::variator::{Importer, real_outputs};
use pushbelt::fmi::Version::Two;
use pushbelt::fmi::log::Status::{self, Error, Ok, Warning};
use pushbelt_library::extensions::{pushbeltFreeText, pushbeltGradient, pushbeltLinearize};
use serde_json::Value;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

fn text(importer: &Importer, frequency: f64) -> (Status, Option<String>) {
    // Not null before, so that an unchanged pointer is detected.
    let mut text = c"before".as_ptr().cast_mut();
    // SAFETY: an instance and a valid pointer; the text comes from the call and is read before it
    // is freed.
    unsafe {
        let status = pushbeltLinearize(importer.c, frequency, &mut text);
        let found = (!text.is_null()).then(|| CStr::from_ptr(text).to_str().expect("UTF-8").to_owned());
        pushbeltFreeText(text);
        (status, found)
    }
}

/// The standard's functions are tested on a toy.
#[cfg(target_arch = "x86_64")]
#[test]
fn every_host_gets_the_same_model_and_keeps_its_environment() {
    use crate::environment::{DEFAULT, HOSTS, call_in};
    let model = || text(&steady(&[]), 100.0);
    let expected = call_in(DEFAULT, model);
    for host in HOSTS {
        assert!(call_in(host, model) == expected, "{host:?}");
    }
}

fn linearize(importer: &Importer) -> (Status, Value) {
    let (status, text) = text(importer, 50.0);
    let text = text.unwrap_or_else(|| panic!("{}", importer.last()));
    (status, serde_json::from_str(&text).expect("JSON"))
}

/// An instance in the steady state of a coarse reference ring under these inputs.
fn steady(inputs: &[(&str, f64)]) -> Importer {
    let importer = Importer::coarse(Two, Handles::default());
    importer.flag("initial.steady", true);
    inputs.iter().for_each(|(name, value)| importer.put(name, *value));
    importer.start();
    importer
}

fn assert_warned(importer: &Importer, part: &str) {
    let messages = importer.record.messages.borrow();
    let mut warnings = messages.iter().filter(|message| message.status == Warning as i32);
    assert!(
        warnings.any(|message| message.text.contains(part)),
        "{part}: {messages:?}"
    );
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn a_steady_instance_has_a_model_in_the_names_of_the_interface() {
    let (_, found) = linearize(&steady(&[]));
    let held = list(&found["inputs"])
        .iter()
        .map(|input| (input["name"].as_str(), number(&input["held"])));
    let held: Vec<_> = held.map(|(name, held)| (name.expect("a name"), held)).collect();
    // Under the loads that hold the point there is no remark.
    let importer = steady(&held);
    let before = importer.readings();
    let (status, model) = linearize(&importer);
    assert_eq!(status, Ok, "{}", importer.last());
    let expected = [
        "primary.torque",
        "primary.clampingForce",
        "secondary.torque",
        "secondary.clampingForce",
    ];
    assert!(held.iter().map(|(name, _)| *name).eq(expected));
    let (n, rows) = (list(&model["states"]).len(), real_outputs().len());
    assert!(n >= 2 && list(&model["poles"]).len() == n);
    for (matrix, height, width) in [("A", n, n), ("B", n, 4), ("C", rows, n), ("D", rows, 4)] {
        let found = list(&model[matrix]);
        let is_full = |row: &Value| list(row).len() == width && list(row).iter().all(Value::is_number);
        assert!(found.len() == height && found.iter().all(is_full), "{matrix}");
    }
    assert_eq!(model["macroSlip"], Value::Bool(false));
    assert!(list(&model["remarks"]).is_empty());
    for output in list(&model["outputs"]) {
        let (found, name) = (number(&output["value"]), output["name"].as_str().expect("a name"));
        let expected = importer.get(name);
        // The parser of these tests rounds in the last digit.
        assert!((found / expected - 1.0).abs() <= 1e-15 || found == expected, "{name}");
    }
    assert_eq!(importer.readings(), before, "the instance has not changed");
    importer.advance(0.0, 1e-3);
}

#[test]
fn a_difference_from_the_specified_point_is_a_warning() {
    let importer = steady(&[("primary.torque", 400.0)]);
    let (status, model) = linearize(&importer);
    assert_eq!((status, &model["macroSlip"]), (Warning, &Value::Bool(false)));
    assert!(number(&model["slip"]) < 0.05);
    let primary = &model["inputs"][0];
    assert!(number(&primary["given"]) == 400.0 && number(&primary["held"]) < 200.0);
    assert_warned(&importer, "400 N.m is specified");
}

/// Between prescribed speeds the belt may slip through permanently.
#[test]
fn a_belt_that_slips_through_is_a_warning() {
    let importer = Importer::coarse(Two, Handles::default());
    importer.flag("initial.steady", true);
    for (pulley, speed) in [("primary", 200.0), ("secondary", 100.0)] {
        importer.choose(&format!("{pulley}.drive"), 2);
        importer.put(&format!("{pulley}.speedSetpoint"), speed);
    }
    importer.start();
    let (status, model) = linearize(&importer);
    assert_eq!((status, &model["macroSlip"]), (Warning, &Value::Bool(true)));
    assert!(number(&model["slip"]) > 0.4);
    assert_warned(&importer, "slips through (macroSlip)");
}

#[test]
fn a_call_without_a_model_logs_the_reason_and_the_run_continues() {
    let refuses = |importer: &Importer, frequency, why| {
        assert_eq!(text(importer, frequency), (Error, None));
        importer.assert_logged(why);
    };
    refuses(&Importer::new(Two), 50.0, "not allowed");
    let cold = Importer::running(Two);
    refuses(&cold, 50.0, "friction is still soft");
    cold.advance(0.0, 1e-3);
    let warm = steady(&[]);
    for frequency in [0.0, -1.0, 1e9, f64::NAN, f64::INFINITY] {
        refuses(&warm, frequency, "out of range");
    }
    // SAFETY: null is what this is about.
    unsafe {
        assert_eq!(pushbeltLinearize(warm.c, 50.0, null_mut()), Error);
        let mut text = c"before".as_ptr().cast_mut();
        assert_eq!(pushbeltLinearize(null_mut(), 50.0, &mut text), Error);
        assert!(text.is_null());
        let none = u32::MAX;
        for (references, count, part) in [(null(), 1, "null"), (&raw const none, 1, "value reference")] {
            assert_eq!(pushbeltGradient(warm.c, references, count, &raw mut text), Error);
            warm.assert_logged(part);
        }
        assert_eq!(pushbeltGradient(warm.c, null(), 0, &raw mut text), Ok);
        pushbeltFreeText(text);
        pushbeltFreeText(null_mut());
    }
    warm.advance(0.0, 1e-3);
}
