//! Types, arrays, bad values.

use std::ptr::{null, null_mut};

use pushbelt::fmi::log::Status::{Discard, Error, Ok};
use pushbelt::unit::exports::c_abi3::*;

use crate::importer::*;

#[test]
fn settings_read_back_as_set() {
    let importer = Importer::new(Handles::default());
    importer.make_cheap();
    assert_eq!(importer.set_real("friction.pulley", 0.08), Ok);
    assert_eq!(importer.set_choice("secondary.drive", 2), Ok);
    importer.start(false);
    let (c, mut choice, mut number) = (importer.c, 0, 0);
    // SAFETY: an instance and places for values.
    unsafe {
        assert_eq!(
            fmi3GetInt64(c, &reference("secondary.drive"), 1, &raw mut choice, 1),
            Ok
        );
        assert_eq!(fmi3GetInt32(c, &reference("mesh.strand"), 1, &raw mut number, 1), Ok);
    }
    assert_eq!((choice, number, importer.boolean("initial.steady")), (2, 4, 0));
    assert_eq!(importer.real("friction.pulley"), 0.08);
    assert_eq!(importer.set_real("friction.pulley", 0.07), Ok, "tunable");
    assert_eq!(importer.step(0.0, 1e-3).status, Ok);
    assert_eq!(importer.real("friction.pulley"), 0.07);
    assert_eq!(importer.set_boolean("initial.steady", 1), Error, "fixed");
}

#[test]
fn bad_values_are_named() {
    for (set, words) in [
        (
            (|i: &Importer| i.set_real("primary.clampingForce", -1.0)) as fn(&Importer) -> _,
            "fmi3SetFloat64: primary.clampingForce = -1 is out of range: 0 to",
        ),
        (
            |i| i.set_real("secondary.torque", f64::NAN),
            "secondary.torque = NaN is not a finite number",
        ),
        (
            |i| i.set_choice("ring.model", 3),
            "fmi3SetInt64: ring.model = 3 is out of range: 1 ALE0, 2 ALE",
        ),
        (
            |i| i.set_choice("ring.model", 1 << 40),
            "ring.model = 1099511627776 is out of range",
        ),
        (
            |i| i.set_integer("mesh.strand", 0),
            "fmi3SetInt32: mesh.strand = 0 is out of range: 1 to",
        ),
        (|i| i.set_integer("ring.model", 1), "has another type"),
        (|i| i.set_choice("mesh.strand", 4), "has another type"),
        (
            |i| i.set_real("profile.pushForce", 1.0),
            "1 values for 1 variables, which have 72",
        ),
    ] {
        let importer = Importer::new(Handles::default());
        // A bad value is discarded; a bad reference is an error.
        let of_value = words.contains("finite") || words.contains("out of range");
        assert_eq!(set(&importer), if of_value { Discard } else { Error });
        assert!(importer.last().contains(words), "{}", importer.last());
    }
}

/// An array has the values of its elements, at its position among scalars and the time.
#[test]
fn arrays_lie_between_scalars_and_the_time() {
    let importer = Importer::running(Handles::default());
    assert_eq!(importer.step(0.0, 3e-3).status, Ok);
    let c = importer.c;
    let references = [
        reference("thrustRatio"),
        reference("profile.position"),
        0,
        reference("belt.speed"),
    ];
    let mut values = [f64::NAN; 75];
    // SAFETY: an instance, and as many values as the variables have.
    let status = unsafe { fmi3GetFloat64(c, references.as_ptr(), 4, values.as_mut_ptr(), values.len()) };
    assert_eq!(status, Ok, "{}", importer.last());
    assert_eq!(values[0], importer.real("thrustRatio"));
    assert_eq!(values[73..], [3e-3, importer.real("belt.speed")]);
    let places = &values[1..73];
    assert_eq!(places[0], 0.0);
    let spacing = places[1];
    assert!(spacing > 5e-3 && spacing < 2e-2, "{spacing} m between places");
    for (k, place) in (0..).zip(places) {
        assert!((place - f64::from(k) * spacing).abs() < 1e-9, "{k}");
    }
    let force = {
        let mut values = [f64::NAN; 72];
        // SAFETY: an instance, and as many values as the array has.
        let status = unsafe { fmi3GetFloat64(c, &reference("profile.pushForce"), 1, values.as_mut_ptr(), 72) };
        assert_eq!(status, Ok);
        values.into_iter().fold(0.0, f64::max)
    };
    let most = importer.real("pushForce.max");
    assert!(force <= most * (1.0 + 1e-12) && force > 0.5 * most, "{force} of {most}");
}

#[test]
fn counts_elements_and_types_must_fit() {
    let importer = Importer::running(Handles::default());
    let (c, mut value) = (importer.c, [0.0; 2]);
    let ratio = reference("thrustRatio");
    let assert_logged = |words: &str| assert!(importer.last().contains(words), "{}", importer.last());
    // SAFETY: an instance; arrays have the given lengths, or are null.
    unsafe {
        assert_eq!(fmi3GetFloat64(c, &ratio, 1, value.as_mut_ptr(), 2), Error);
        assert_logged("2 values for 1 variables");
        let second = reference("profile.pushForce") + 1;
        assert_eq!(fmi3GetFloat64(c, &second, 1, value.as_mut_ptr(), 1), Error);
        assert_logged("element of profile.pushForce");
        assert_eq!(fmi3GetFloat64(c, &77, 1, value.as_mut_ptr(), 1), Error);
        assert_logged("no variable has the value reference 77");
        assert_eq!(fmi3SetFloat64(c, &0, 1, value.as_ptr(), 1), Error);
        assert_logged("time can't be set");
        assert_eq!(fmi3GetFloat64(c, null(), 1, value.as_mut_ptr(), 1), Error);
        assert_eq!(fmi3GetFloat64(c, &ratio, 1, null_mut(), 1), Error);
        assert_eq!(fmi3GetFloat64(c, null(), 0, null_mut(), 0), Ok);
        assert_eq!(fmi3GetInt32(c, &ratio, 1, &raw mut *[0].as_mut_ptr(), 1), Error);
        assert_eq!(fmi3GetFloat32(c, &ratio, 1, [0.0_f32].as_mut_ptr(), 1), Error);
        assert_logged("no 32-bit real has the value reference 1");
        assert_eq!(fmi3GetString(c, null(), 0, null_mut(), 0), Ok, "none of none");
        assert_eq!(fmi3SetBinary(c, &1, 1, &1, &null(), 1), Error);
        assert_logged("no binary");
        assert_eq!(fmi3GetClock(c, &1, 1, [0_u8].as_mut_ptr()), Error);
        assert_logged("no clock");
        assert_eq!(
            fmi3GetIntervalDecimal(c, &1, 1, value.as_mut_ptr(), [0].as_mut_ptr()),
            Error
        );
        assert_eq!(fmi3SetShiftFraction(c, &1, 1, &1, &1), Error);
        // A Boolean that is neither 0 nor 1 is true.
        assert_eq!(fmi3GetOutputDerivatives(c, &ratio, 1, &1, value.as_mut_ptr(), 2), Error);
        assert_eq!(fmi3GetOutputDerivatives(c, &ratio, 1, &2, value.as_mut_ptr(), 1), Error);
        assert_logged("maxOutputDerivativeOrder");
    }
    assert_eq!(importer.step(0.0, 1e-3).status, Ok, "and nothing has changed");
}
