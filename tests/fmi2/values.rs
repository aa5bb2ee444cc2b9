//! Settings, bad values and the messages about them.

use pushbelt::fmi::log::Status::{Discard, Error, Ok};
use pushbelt::unit::exports::c_abi::*;

use crate::importer::*;

#[test]
fn settings_read_back_as_set() {
    let importer = Importer::new(c"settings");
    importer.make_cheap();
    assert_eq!(importer.set_real("friction.pulley", 0.08), Ok);
    assert_eq!(importer.set_integer("secondary.drive", 2), Ok);
    importer.start();
    assert_eq!(importer.real("friction.pulley"), 0.08);
    assert_eq!(importer.integer("secondary.drive"), 2);
    assert_eq!(importer.integer("mesh.strand"), 4);
    assert_eq!(importer.boolean("initial.steady"), 0);
    assert_eq!(importer.set_real("friction.pulley", 0.07), Ok, "tunable");
    assert_eq!(importer.step(0.0, 0.001), Ok);
    assert_eq!(importer.real("friction.pulley"), 0.07);
}

/// Bad values, with what the message must name: variable, value, allowed range.
#[test]
fn bad_values_are_named_when_they_are_set() {
    let forever = f64::INFINITY;
    for (name, value, words) in [
        (
            "primary.clampingForce",
            -1.0,
            "primary.clampingForce = -1 is out of range: 0 to",
        ),
        (
            "secondary.torque",
            f64::NAN,
            "secondary.torque = NaN is not a finite number",
        ),
        (
            "secondary.speedSetpoint",
            forever,
            "secondary.speedSetpoint = inf is not a finite",
        ),
        (
            "friction.pulley",
            -0.1,
            "friction.pulley = -0.1 is out of range: 0 to 1",
        ),
    ] {
        let importer = Importer::running(c"bad");
        assert_eq!(importer.set_real(name, value), Discard);
        assert!(importer.last().contains(words), "{}", importer.last());
        assert_eq!(importer.step(0.0, 0.001), Ok, "the run goes on");
    }
    for (name, value, words) in [
        ("ring.model", 3, "ring.model = 3 is out of range: 1 ALE0, 2 ALE"),
        ("primary.axial", 0, "primary.axial = 0 is out of range: 1 Force, 2 Held"),
        ("mesh.strand", 0, "mesh.strand = 0 is out of range: 1 to"),
    ] {
        let importer = Importer::new(c"bad");
        assert_eq!(importer.set_integer(name, value), Discard);
        assert!(importer.last().contains(words), "{}", importer.last());
    }
}

#[test]
fn values_that_do_not_fit_each_other_are_named_when_initialising() {
    for (name, value, words) in [
        (
            "geometry.beltLength",
            0.3,
            "geometry.beltLength = 0.3 is out of range: between",
        ),
        ("initial.ratio", 5.0, "initial.ratio = 5 is out of range: 0.3"),
        ("friction.pulley", 0.3, "geometry.wedgeAngle = 0.19"),
    ] {
        let importer = Importer::new(c"misfit");
        importer.make_cheap();
        assert_eq!(importer.set_real(name, value), Ok, "{}", importer.last());
        // SAFETY: an instance.
        unsafe {
            assert_eq!(fmi2EnterInitializationMode(importer.c), Ok);
            assert_eq!(fmi2ExitInitializationMode(importer.c), Error);
            assert!(importer.last().contains(words), "{}", importer.last());
            assert_eq!(fmi2Reset(importer.c), Ok);
        }
        importer.make_cheap();
        importer.start();
        assert_eq!(importer.step(0.0, 0.001), Ok);
    }
}

/// Removed variables of earlier versions give an error that names the replacement.
#[test]
fn variables_of_earlier_versions_are_named() {
    for (reference, words) in [
        (
            1036,
            "belt.contactStrain (value reference 1036) was removed: set belt.roughness",
        ),
        (
            1045,
            "ring.elements (value reference 1045) was removed: the FMU of the comparison",
        ),
        (1048, "ring.referenceDirections (value reference 1048) was removed"),
        (1075, "mesh.aligned (value reference 1075) was removed"),
    ] {
        let importer = Importer::new(c"older");
        // SAFETY: an instance.
        assert_eq!(unsafe { fmi2SetReal(importer.c, &reference, 1, &0.0) }, Error);
        assert!(importer.last().contains(words), "{}", importer.last());
    }
}

#[test]
fn messages_carry_instance_status_and_category() {
    let importer = Importer::new(c"the 100 %s variator");
    assert_eq!(importer.step(0.0, 1.0), Error);
    let record = importer.record.0.borrow();
    let (instance, status, category, _) = record.last().expect("a message");
    assert_eq!(instance, "the 100 %s variator");
    assert_eq!((*status, category.as_str()), (3, "logStatusError"));
}

#[test]
fn reset_and_rerun_give_the_same_bits_as_a_fresh_instance() {
    let importer = Importer::running(c"twice");
    let first = importer.run();
    assert_eq!(importer.set_real("friction.ring", 0.01), Ok);
    // SAFETY: an instance.
    assert_eq!(unsafe { fmi2Reset(importer.c) }, Ok);
    importer.make_cheap();
    importer.start();
    assert_eq!(importer.real("friction.ring"), 0.05, "back to the default");
    assert_eq!(importer.real("secondary.torque"), -49.0, "back to the default");
    assert_eq!(importer.run(), first);
}

#[test]
fn instances_are_independent() {
    let alone = Importer::running(c"alone").run();
    let (one, other) = (Importer::running(c"one"), Importer::running(c"other"));
    assert_eq!(other.set_real("friction.pulley", 0.05), Ok);
    assert_eq!(other.step(0.0, 0.004), Ok);
    assert_eq!(one.run(), alone);
    assert_eq!(other.set_real("primary.torque", f64::NAN), Discard);
    assert_eq!(one.step(0.01, 0.001), Ok);
    assert!(one.record.0.borrow().iter().all(|message| message.0 == "one"));
}

/// The log has what can hardly be meant, as a warning; a hopeless start is an error that names variable and value.
#[test]
fn implausible_loads_are_logged() {
    let logged = |name: &str, value: f64| {
        let importer = Importer::new(c"implausible");
        importer.make_cheap();
        assert_eq!(importer.set_boolean("initial.steady", 1), Ok);
        assert_eq!(importer.set_real(name, value), Ok);
        // SAFETY: `c` is an instance.
        let status = unsafe {
            assert_eq!(fmi2EnterInitializationMode(importer.c), Ok);
            fmi2ExitInitializationMode(importer.c)
        };
        let record = importer.record.0.borrow();
        (status, record.last().cloned().expect("a message"))
    };
    let (status, (_, level, category, text)) = logged("initial.primarySpeed", 2000.0);
    assert_eq!((status, level, category.as_str()), (Ok, 1, "logStatusWarning"));
    assert!(text.contains("initial.primarySpeed") && text.contains("rpm"), "{text}");
    let (status, (_, level, category, text)) = logged("secondary.clampingForce", 13.5);
    assert_eq!((status, level, category.as_str()), (Error, 3, "logStatusError"));
    assert!(
        text.contains("secondary.clampingForce = 13.5 N") && text.contains("kN"),
        "{text}"
    );
}
