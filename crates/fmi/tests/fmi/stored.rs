//! Stored states, and their bytes, in both versions.

use std::ptr::null_mut;

use pushbelt_fmi::Version::{Three, Two};
use pushbelt_fmi::hash;
use pushbelt_fmi::log::Status::{Error, Ok};
use pushbelt_fmi::unit::Experiment;

use crate::importer::{BOTH, Handles, experiment, token};
use crate::run::{ended, running};
use crate::tank::*;

fn go_on(importer: &Importer, from: f64) -> u64 {
    assert_eq!(importer.step(from, 0.9).status, Ok, "{}", importer.last());
    assert_eq!(importer.set(INFLOW, 0.3), Ok);
    assert_eq!(importer.step(from + 0.9, 0.9).status, Ok);
    importer.real(LEVEL).to_bits()
}

#[test]
fn a_state_holds_everything_and_fits_every_instance() {
    for version in BOTH {
        let early = Importer::new(version);
        assert_eq!(early.set_reals(&[GAIN, MARK], &[1.0 / 3.0, 7.0]), Ok);
        assert_eq!([early.set_number(FLOORS, 5), early.set_number(LOCKED, 1)], [Ok; 2]);
        // A state before the start is one, too.
        let importer = Importer::new(version);
        assert_eq!(importer.continue_from(&early.bytes()), Ok);
        importer.start();
        assert_eq!(importer.step(0.0, 0.7).status, Ok);
        if version == Two {
            assert_eq!(importer.set_derivative(INFLOW, 1, 0.1), Ok);
        }
        let (mut state, bytes) = (importer.stored(), importer.bytes());
        let expected = go_on(&importer, 0.7);
        assert_eq!(importer.restore(state), Ok);
        importer.assert_reals(&[GAIN, MARK, INFLOW], &[1.0 / 3.0, 7.0, 2.0]);
        assert_eq!([FLOORS, LOCKED].map(|of| importer.number(of)), [5, 1].map(Result::Ok));
        assert_eq!(importer.bytes(), bytes, "a state at rest is itself");
        assert_eq!(go_on(&importer, 0.7), expected);
        let handle = state;
        assert_eq!(importer.store(&mut state), Ok);
        assert_eq!(state, handle, "a state that is not null is used again");
        assert_eq!(importer.restore(state), Ok);
        assert_eq!(importer.step(2.5, 0.1).status, Ok, "and holds the later time");
        // The bytes have the same meaning in both versions.
        for other in BOTH.map(Importer::new) {
            assert_eq!(other.continue_from(&bytes), Ok);
            assert_eq!(other.bytes(), bytes);
            assert_eq!(go_on(&other, 0.7), expected);
        }
        assert_eq!(importer.free(&mut null_mut()), Ok, "null is legal");
        assert_eq!(importer.restore(null_mut()), Error);
        assert_eq!(importer.read_bytes(&[]), Err(Error));
        assert_eq!(importer.write_bytes(null_mut(), &mut []), Error);
    }
}

#[test]
fn a_state_of_event_mode_fits_every_instance() {
    let importer = Importer::handling(Three, Handles::EVENTS);
    assert_eq!(importer.enter(experiment(0.0, None)), Ok);
    assert_eq!(importer.exit(), Ok);
    let bytes = importer.bytes();
    importer.handle_event();
    assert_eq!(importer.continue_from(&bytes), Ok);
    assert_eq!(importer.step(0.0, 0.5).status, Error, "in event mode again");
    for other in BOTH.map(Importer::new) {
        assert_eq!(other.continue_from(&bytes), Ok);
        assert_eq!(other.step(0.0, 0.5).status, Ok);
    }
}

#[test]
fn the_stop_time_of_the_instance_counts_not_that_of_a_stored_state() {
    for version in BOTH {
        let [importer, other] = [1.0, 2.0].map(|stop| {
            let importer = Importer::new(version);
            assert_eq!(importer.enter(experiment(0.0, Some(stop))), Ok);
            importer
        });
        assert_eq!(importer.exit(), Ok);
        assert_eq!(importer.step(0.0, 1.0).status, Ok);
        let bytes = importer.bytes();
        assert_eq!(other.continue_from(&bytes), Ok);
        assert_eq!(other.step(1.0, 1.0).status, Ok);
        other.assert(other.step(2.0, 1.0).status, Error, "stop time 2 s");
        // The host goes straight from instantiation to the stored state: no stop time.
        let fresh = Importer::new(version);
        assert_eq!(fresh.continue_from(&bytes), Ok);
        assert_eq!(fresh.bytes(), bytes, "stored again bit for bit");
        assert_eq!(fresh.step(1.0, 5.0), ended(false, false, 6.0));
    }
}

/// The tolerance is one of the values that are stored before the start.
#[test]
fn the_tolerance_is_stored() {
    for version in BOTH {
        let [importer, other] = [version; 2].map(Importer::new);
        let tolerance = Some(0.25);
        assert_eq!(
            importer.enter(Experiment {
                tolerance,
                ..experiment(0.0, None)
            }),
            Ok
        );
        assert_eq!(other.continue_from(&importer.bytes()), Ok);
        for started in [importer, other] {
            assert_eq!(started.log(true, &[]), Ok);
            assert_eq!(started.exit(), Ok);
            started.assert_logged("filled within 0.25");
        }
    }
}

/// Another hash is another layout: raise `VERSION` in `instance/bytes.rs` and pin it again.
#[test]
fn the_layout_of_stored_values_is_pinned() {
    let importer = Importer::new(Two);
    importer.start_at(5.0);
    assert_eq!(importer.step(5.0, 1.0).status, Ok);
    assert_eq!(importer.set_derivative(INFLOW, 1, 0.5), Ok);
    let bytes = importer.bytes();
    let found = hash::of_bytes(&bytes[28..bytes.len() - 16]);
    assert_eq!(found, 0xd0fe_3012_986d_6227_e9d3_0162_384c_84fb);
}

#[test]
fn wrong_bytes_are_refused_and_change_nothing() {
    for version in BOTH {
        let importer = running(version);
        let bytes = importer.bytes();
        let refuses = |bytes: &[u8], why: &str| importer.assert(importer.read_bytes(bytes), Err(Error), why);
        let damaged = |at: usize| {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            damaged
        };
        let guid = hash::of_bytes(token::<Tank>(Two).as_bytes());
        assert_eq!(bytes[12..28], guid.to_le_bytes(), "after the version");
        refuses(&bytes[1..], "not a stored state");
        refuses(&[&bytes[..], b"x"].concat(), "checksum");
        // Those of another version of the layout by both versions: the present one, and that with
        // the changed bit.
        refuses(
            &damaged(8),
            "has version 7 of the layout, and this FMU reads version 23",
        );
        refuses(&damaged(12), "GUID");
        refuses(&damaged(bytes.len() - 1), "checksum");
        for at in 0..bytes.len() {
            assert_eq!(importer.read_bytes(&damaged(at)), Err(Error), "byte {at}");
            assert_eq!(importer.read_bytes(&bytes[..at]), Err(Error), "{at} bytes");
        }
        let state = importer.stored();
        let mut short = vec![0; bytes.len() - 1];
        importer.assert(importer.write_bytes(state, &mut short), Error, "but only");
        assert_eq!(importer.bytes(), bytes);
    }
}

/// Each number of a stored state in turn is NaN, infinite or of another time.
#[test]
fn wild_numbers_in_a_stored_state_are_refused() {
    let importer = Importer::new(Two);
    importer.start_at(5.0);
    assert_eq!(importer.step(5.0, 1.0).status, Ok);
    let good = importer.bytes();
    let content = good.len() - 16;
    let forged = |at: usize, number: f64| {
        let mut bytes = good[..content].to_vec();
        bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
        bytes.extend(hash::of_words(&bytes).to_le_bytes());
        importer.continue_from(&bytes)
    };
    let places = |number: f64| -> Vec<usize> {
        let is_there = |at: &usize| good[*at..at + 8] == number.to_le_bytes();
        (28..content - 7).filter(is_there).collect()
    };
    // Start, point and origin; elapsed and the tank's time; level; flow and inflow.
    for (number, count) in [(5.0, 2), (6.0, 1), (1.0, 2), (3.0, 1), (2.0, 2)] {
        assert!(places(number).len() >= count, "{number}: {:?}", places(number));
        for at in places(number) {
            for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert_eq!(forged(at, wild), Error, "{number} at {at}: {wild}");
            }
        }
    }
    for at in places(5.0).into_iter().chain(places(6.0)) {
        assert_eq!(forged(at, 1e14), Error, "a late time at {at}");
    }
    for at in places(1e9) {
        assert_eq!(forged(at, -2e3), Error, "an input out of range at {at}");
    }
    let last = *places(1.0).last().expect("the tank's time");
    for time in [1e14, 2.0, -1.0] {
        assert_eq!(forged(last, time), Error, "{time}");
    }
    assert_eq!(forged(last, 1.0), Ok, "nothing has changed");
}
