//! Hosts that trap, flush or round otherwise: the same bits as without, and their environment as it was.

use std::ptr::null_mut;

use pushbelt::fmi::log::Status::{Ok, Warning};
use pushbelt::unit::exports::c_abi::*;
use pushbelt::unit::exports::linear_c::*;

use crate::environment::{DEFAULT, HOSTS, within};
use crate::importer::*;

/// A steady start, a linear model, steps, slip through the belt, a stored state. `times` are the communication points.
fn run(times: &[f64]) -> Vec<Vec<u64>> {
    let importer = Importer::new(c"host");
    importer.make_cheap();
    assert_eq!(importer.set_boolean("initial.steady", 1), Ok);
    importer.start();
    let step = |k: usize| {
        let [from, size] = [times[k], 1e-3];
        assert_eq!(importer.step(from, size), Ok, "{:?}", importer.record);
        importer.readings()
    };
    let mut readings = vec![importer.readings()];
    let (c, mut json, mut state, mut bytes) = (importer.c, null_mut(), null_mut(), Vec::<i8>::new());
    // SAFETY: an instance, and places for the results.
    unsafe {
        assert_eq!(
            pushbeltLinearize(c, 100.0, &raw mut json),
            Warning,
            "{:?}",
            importer.record
        );
        let text = std::ffi::CStr::from_ptr(json).to_bytes();
        readings.push(text.iter().map(|byte| u64::from(*byte)).collect());
        pushbeltFreeText(json);
    }
    readings.extend((0..3).map(step));
    readings.push(importer.derivatives());
    // SAFETY: an instance, and as many bytes as it counts.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &raw mut state), Ok);
        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &raw mut size), Ok);
        bytes.resize(size, 0);
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), size), Ok);
        assert_eq!(fmi2FreeFMUstate(c, &raw mut state), Ok);
    }
    assert_eq!(importer.set_real("primary.torque", 400.0), Ok);
    readings.extend((3..20).map(step));
    assert_eq!(importer.boolean("macroSlip"), 1);
    // SAFETY: an instance, and bytes of a state of it.
    unsafe {
        let pointer = bytes.as_ptr().cast();
        assert_eq!(fmi2DeSerializeFMUstate(c, pointer, bytes.len(), &raw mut state), Ok);
        assert_eq!(fmi2SetFMUstate(c, state), Ok);
        assert_eq!(fmi2FreeFMUstate(c, &raw mut state), Ok);
    }
    readings.extend((3..6).map(step));
    readings
}

#[test]
fn a_host_that_traps_flushes_or_rounds_upward_gets_the_same_bits() {
    let times: Vec<f64> = (0..30).map(|k| f64::from(k) * 1e-3).collect();
    let expected = within(DEFAULT, || run(&times));
    for host in HOSTS {
        assert!(within(host, || run(&times)) == expected, "{host:?}");
    }
}
