//! Starts: near another, not found, with start values in the resources.

use crate::importer::{BOTH, Handles};
use crate::variator::{Importer, reference};
use pushbelt::fmi::log::Status::{Error, Ok};
use pushbelt::fmi::start_file::FILE;
use pushbelt::fmi::unit::Experiment;
use pushbelt_library::extensions::pushbeltResetNear;
use pushbelt_support::shared_library::{Library, OK, path};
use std::fs;

/// The steady start after `pushbeltResetNear` is that after a reset, with other last digits.
#[test]
fn a_start_near_the_one_before_finds_the_same_state() {
    let importer = Importer::coarse(BOTH[0], Handles::default());
    let start = |torque: f64| {
        importer.make_coarse();
        importer.flag("initial.steady", true);
        importer.put("primary.torque", torque);
        importer.start();
        ["thrustRatio", "slip", "loss.total"].map(|name| importer.get(name))
    };
    start(30.0);
    // SAFETY: an instance that no other call uses.
    assert_eq!(unsafe { pushbeltResetNear(importer.c) }, Ok);
    let near = start(31.0);
    assert_eq!(importer.reset(), Ok);
    for (near, cold) in near.into_iter().zip(start(31.0)) {
        assert!((near / cold - 1.0).abs() < 1e-6 && near != cold, "{near} for {cold}");
    }
}

/// A belt that is clamped by pressures on no area: one warning without debug logging too, and the
/// status stays OK; or an error.
#[test]
fn a_start_that_was_not_found_is_a_warning_or_an_error() {
    for version in BOTH {
        for strict in [false, true] {
            let importer = Importer::coarse(version, Handles::default());
            assert_eq!(importer.log(false, &[]), Ok);
            importer.flag("initial.steady", true);
            importer.flag("initial.strict", strict);
            importer.put("primary.pressure", 1e6);
            importer.put("primary.clampingForce", 0.0);
            importer.put("secondary.clampingForce", 0.0);
            assert_eq!(importer.enter(Experiment::default()), Ok);
            assert_eq!(importer.exit(), if strict { Error } else { Ok });
            let messages = importer.record.messages.borrow().clone();
            let found = |text: &str| {
                let mut found = messages.iter().filter(|message| message.text.contains(text));
                let message = found.next().unwrap_or_else(|| panic!("{messages:?}"));
                assert!(found.next().is_none(), "{messages:?}");
                (message.status, message.category.clone())
            };
            let warning = (1, "logStatusWarning".to_owned());
            assert_eq!(found("primary.cylinder.area is 0"), warning);
            if strict {
                assert_eq!(found("initial.strict"), (3, "logStatusError".to_owned()));
            } else {
                assert_eq!(found("what helps"), warning);
                assert_eq!(importer.count("initial.found"), 5);
            }
        }
    }
}

/// The importer passes no location: the library looks beside itself.
#[test]
fn a_library_finds_start_values_beside_the_folder_of_binaries() {
    let unpacked = std::env::temp_dir().join(format!("pushbelt unpacked {}", std::process::id()));
    let folder = |name: &str| {
        let folder = unpacked.join(name);
        fs::create_dir_all(&folder).expect("a folder");
        folder
    };
    let binary = folder("binaries/linux64").join("PushbeltVariator.so");
    fs::copy(path(), &binary).expect("a copy");
    fs::write(folder("resources").join(FILE), "friction.pulley = 0.085").expect("a file");
    let library = Library::load_from(&binary);
    let (f, f3) = (&library.functions, &library.functions3);
    let (c, c3) = (f.instantiate(), f3.instantiate());
    let (friction, mut values) = (reference("friction.pulley"), [0.0; 2]);
    // SAFETY: instances, and places for values.
    unsafe {
        f.make_cheap(c);
        assert_eq!((f.fmi2EnterInitializationMode)(c), OK);
        assert_eq!((f.fmi2GetReal)(c, &friction, 1, &raw mut values[0]), OK);
        (f.fmi2FreeInstance)(c);
        assert_eq!((f3.fmi3GetFloat64)(c3, &friction, 1, &raw mut values[1], 1), OK);
        (f3.fmi3FreeInstance)(c3);
    }
    fs::remove_dir_all(&unpacked).expect("removed");
    assert_eq!(values, [0.085; 2]);
}
