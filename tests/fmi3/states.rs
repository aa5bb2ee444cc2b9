//! Stored states, also between the versions.

use std::ptr::{null, null_mut};

use pushbelt::fmi::fmi2::{Component, FmuState};
use pushbelt::fmi::log::Status::{Error, Ok};
use pushbelt::unit::exports::c_abi::*;
use pushbelt::unit::exports::c_abi3::*;

use crate::importer::*;

/// Ten steps of 1 ms from a time on, with a load that grows; the readings after each.
fn run(importer: &Importer, from: u32) -> Vec<Vec<u64>> {
    let step = |k: u32| {
        assert_eq!(importer.set_real("secondary.torque", -f64::from(k)), Ok);
        assert_eq!(
            importer.step(f64::from(k) * 1e-3, 1e-3).status,
            Ok,
            "{}",
            importer.last()
        );
        let mut readings = importer.readings();
        readings.extend(importer.derivatives());
        readings
    };
    (from..from + 10).map(step).collect()
}

fn serialized(importer: &Importer, state: FmuState) -> Vec<u8> {
    let mut size = 0;
    // SAFETY: an instance, a state of it, and as many bytes as its size.
    unsafe {
        assert_eq!(fmi3SerializedFMUStateSize(importer.c, state, &raw mut size), Ok);
        let mut bytes = vec![0_u8; size];
        assert_eq!(
            fmi3SerializeFMUState(importer.c, state, bytes.as_mut_ptr(), size - 1),
            Error
        );
        assert_eq!(fmi3SerializeFMUState(importer.c, state, bytes.as_mut_ptr(), size), Ok);
        bytes
    }
}

#[test]
fn a_stored_state_is_continued_bit_for_bit_in_the_same_and_another_instance() {
    let handles = Handles {
        events: true,
        early_return: false,
        required: &["thrustRatio"],
    };
    let importer = Importer::running(handles);
    run(&importer, 0);
    let mut state = null_mut();
    // SAFETY: instances and their states.
    unsafe {
        assert_eq!(fmi3GetFMUState(importer.c, &raw mut state), Ok);
        let expected = run(&importer, 10);
        assert_eq!(fmi3SetFMUState(importer.c, state), Ok);
        assert_eq!(run(&importer, 10), expected);
        let bytes = serialized(&importer, state);
        let handle = state;
        assert_eq!(fmi3GetFMUState(importer.c, &raw mut state), Ok);
        assert_eq!(state, handle, "a state that is not null is used again");
        // Another instance, without intermediate updates.
        let other = Importer::new(Handles::default());
        let mut found = null_mut();
        assert_eq!(
            fmi3DeserializeFMUState(other.c, bytes.as_ptr(), bytes.len(), &raw mut found),
            Ok
        );
        assert_eq!(fmi3SetFMUState(other.c, found), Ok);
        assert_eq!(run(&other, 10), expected);
        assert_eq!(fmi3FreeFMUState(other.c, &raw mut found), Ok);
        let mut damaged = bytes;
        let middle = damaged.len() / 2;
        damaged[middle] ^= 1;
        assert_eq!(
            fmi3DeserializeFMUState(other.c, damaged.as_ptr(), damaged.len(), &raw mut found),
            Error
        );
        assert!(other.last().contains("checksum"), "{}", other.last());
        assert_eq!(fmi3FreeFMUState(importer.c, &raw mut state), Ok);
        assert!(state.is_null());
        assert_eq!(fmi3FreeFMUState(importer.c, &raw mut state), Ok, "null is legal");
        assert_eq!(fmi3SetFMUState(importer.c, null_mut()), Error);
        assert_eq!(fmi3GetFMUState(importer.c, null_mut()), Error);
        assert_eq!(fmi3DeserializeFMUState(importer.c, null(), 9, &raw mut state), Error);
    }
}

/// A state stored in event mode is in step mode after it is restored in an instance without event mode.
#[test]
fn a_state_of_event_mode_fits_every_instance() {
    let importer = Importer::running(Handles {
        events: true,
        ..Handles::default()
    });
    let plain = Importer::new(Handles::default());
    let mut state = null_mut();
    // SAFETY: instances and a state.
    unsafe {
        assert_eq!(fmi3EnterEventMode(importer.c), Ok);
        assert_eq!(fmi3GetFMUState(importer.c, &raw mut state), Ok);
        assert_eq!(fmi3SetFMUState(plain.c, state), Ok);
        assert_eq!(plain.step(0.0, 1e-3).status, Ok);
        importer.handle_event(false);
        assert_eq!(fmi3SetFMUState(importer.c, state), Ok);
        assert_eq!(importer.step(0.0, 1e-3).status, Error, "in event mode again");
        importer.handle_event(false);
        assert_eq!(importer.step(0.0, 1e-3).status, Ok);
        assert_eq!(fmi3FreeFMUState(importer.c, &raw mut state), Ok);
    }
}

/// Bytes of an instance of FMI 2.0 continue in one of FMI 3.0: the binary and the variable table are the same.
#[test]
fn bytes_of_one_version_continue_in_the_other() {
    let guid = std::ffi::CString::new(pushbelt::fmi::guid::<pushbelt::unit::VariatorUnit>()).expect("no zero inside");
    let importer = Importer::running(Handles::default());
    let mut state = null_mut();
    // SAFETY: instances, their states and as many bytes as they take.
    unsafe {
        let old: Component = fmi2Instantiate(c"old".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        run(&importer, 0);
        assert_eq!(fmi3GetFMUState(importer.c, &raw mut state), Ok);
        let bytes = serialized(&importer, state);
        let expected = run(&importer, 10);
        let mut found = null_mut();
        assert_eq!(
            fmi2DeSerializeFMUstate(old, bytes.as_ptr().cast(), bytes.len(), &raw mut found),
            Ok
        );
        assert_eq!(fmi2SetFMUstate(old, found), Ok);
        assert_eq!(fmi2SetReal(old, &reference("secondary.torque"), 1, &-10.0), Ok);
        assert_eq!(fmi2DoStep(old, 0.01, 1e-3, 1), Ok);
        let mut ratio = 0.0;
        assert_eq!(fmi2GetReal(old, &reference("thrustRatio"), 1, &raw mut ratio), Ok);
        assert!(expected[0].contains(&ratio.to_bits()));
        assert_eq!(fmi2FreeFMUstate(old, &raw mut found), Ok);
        fmi2FreeInstance(old);
        assert_eq!(fmi3FreeFMUState(importer.c, &raw mut state), Ok);
    }
}
