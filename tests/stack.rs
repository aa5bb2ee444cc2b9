//! The stack that a host's thread must have.

#![allow(unsafe_code, reason = "it calls the C functions")]

use std::ffi::CString;
use std::ptr::{null, null_mut};
use std::thread;

use pushbelt::unit::VariatorUnit;
use pushbelt_lab::shared_library::{Functions, Library, OK, WARNING, count, reference};

/// Stack that `docs/interface.md` asks of hosts, kB, and that of the dev profile, which inlines less.
const STACK: u32 = if cfg!(debug_assertions) { 512 } else { 256 };

/// What a host knows from the model description: token and value references.
struct Description {
    guid: CString,
    /// Ring, mode of the solver.
    choices: [u32; 2],
    spatial: u32,
    torque: u32,
    output: u32,
}

/// The life of an instance: start, linear model, steps, a stored state as bytes.
fn life(f: &Functions, of: &Description, choices: [i32; 2], spatial: bool) {
    let (mut text, mut state, mut read, mut size, mut value) = (null_mut(), null_mut(), null_mut(), 0, 0.0);
    // SAFETY: valid strings, an instance that is not used any more when it is freed, and places for the results.
    unsafe {
        let c = (f.fmi2Instantiate)(c"variator".as_ptr(), 1, of.guid.as_ptr(), null(), null(), 0, 0);
        assert_eq!((f.fmi2SetInteger)(c, of.choices.as_ptr(), 2, choices.as_ptr()), OK);
        assert_eq!((f.fmi2SetBoolean)(c, &raw const of.spatial, 1, &spatial.into()), OK);
        f.start(c);
        assert!([OK, WARNING].contains(&(f.pushbeltLinearize)(c, 100.0, &raw mut text)));
        (f.pushbeltFreeText)(text);
        for k in 0..10 {
            assert_eq!(
                (f.fmi2SetReal)(c, &raw const of.torque, 1, &(10.0 * f64::from(k % 3))),
                OK
            );
            assert_eq!((f.fmi2DoStep)(c, 1e-3 * f64::from(k), 1e-3, 1), OK);
            assert_eq!((f.fmi2GetReal)(c, &raw const of.output, 1, &raw mut value), OK);
        }
        assert_eq!((f.fmi2GetFMUstate)(c, &raw mut state), OK);
        assert_eq!((f.fmi2SerializedFMUstateSize)(c, state, &raw mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!((f.fmi2SerializeFMUstate)(c, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!((f.fmi2DeSerializeFMUstate)(c, bytes.as_ptr(), size, &raw mut read), OK);
        assert_eq!((f.fmi2SetFMUstate)(c, read), OK);
        (f.fmi2FreeFMUstate)(c, &raw mut read);
        (f.fmi2FreeFMUstate)(c, &raw mut state);
        (f.fmi2FreeInstance)(c);
    }
}

/// Rings, modes and planes. A stack that is too small ends the process; `PUSHBELT_STACK` is another size, kB.
#[test]
fn an_instance_fits_on_a_small_stack() {
    let library = Library::load();
    let f = &library.functions;
    let description = Description {
        guid: CString::new(pushbelt::fmi::guid::<VariatorUnit>()).expect("no zero inside"),
        choices: ["ring.model", "solver.mode"].map(reference),
        spatial: reference("ring.spatial"),
        torque: reference("primary.torque"),
        output: reference("thrustRatio"),
    };
    let size = 1024 * count("PUSHBELT_STACK", STACK) as usize;
    for (choices, spatial) in [([1, 1], false), ([2, 1], false), ([2, 2], false), ([2, 1], true)] {
        thread::scope(|scope| {
            let host = thread::Builder::new().stack_size(size);
            let host = host.spawn_scoped(scope, || life(f, &description, choices, spatial));
            host.expect("a thread").join().expect("no panic");
        });
    }
}
