//! The stack that a host's thread must have, and a host without memory.

#![allow(unsafe_code, reason = "it calls the C functions")]

use pushbelt::fmi::Version;
use pushbelt_support::shared_library::{ERROR, Functions, Library, OK, WARNING, count, reference, token};
use std::ffi::CStr;
use std::process::Command;
use std::ptr::{null, null_mut};
use std::thread;

/// Stack that `docs/interface.md` asks of hosts, kB: less than 288 is too little. The dev profile,
/// whose need was not measured, inlines less.
const STACK: u32 = if cfg!(debug_assertions) { 1024 } else { 320 };

/// The life of an instance: start, linear model, steps, a stored state as bytes. The host knows
/// token and value references from the model description.
fn life(f: &Functions, guid: &CStr, references: [u32; 5], choices: [i32; 2], is_spatial: bool) {
    let [ring, mode, spatial, torque, output] = references;
    let (mut text, mut state, mut read, mut size, mut value) = (null_mut(), null_mut(), null_mut(), 0, 0.0);
    // SAFETY: valid strings, an instance that is not used any more when it is freed, and places for
    // the results.
    unsafe {
        let c = (f.fmi2Instantiate)(c"variator".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        assert_eq!((f.fmi2SetInteger)(c, [ring, mode].as_ptr(), 2, choices.as_ptr()), OK);
        assert_eq!((f.fmi2SetBoolean)(c, &raw const spatial, 1, &is_spatial.into()), OK);
        f.start(c);
        assert!([OK, WARNING].contains(&(f.pushbeltLinearize)(c, 100.0, &raw mut text)));
        (f.pushbeltFreeText)(text);
        for k in 0..10 {
            let load = 10.0 * f64::from(k % 3);
            assert_eq!((f.fmi2SetReal)(c, &raw const torque, 1, &raw const load), OK);
            assert_eq!((f.fmi2DoStep)(c, 1e-3 * f64::from(k), 1e-3, 1), OK);
            assert_eq!((f.fmi2GetReal)(c, &raw const output, 1, &raw mut value), OK);
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

/// Rings, modes and planes. A stack that is too small ends the process; `PUSHBELT_STACK` is another
/// size, kB.
#[test]
fn an_instance_fits_on_a_small_stack() {
    let library = Library::load();
    let f = &library.functions;
    let guid = token(Version::Two);
    let names = [
        "ring.model",
        "solver.mode",
        "ring.spatial",
        "primary.torque",
        "thrustRatio",
    ];
    let references = names.map(reference);
    let size = 1024 * count("PUSHBELT_STACK", STACK) as usize;
    for (choices, spatial) in [([1, 1], false), ([2, 1], false), ([2, 2], false), ([2, 1], true)] {
        thread::scope(|scope| {
            let host = thread::Builder::new().stack_size(size);
            let host = host.spawn_scoped(scope, || life(f, &guid, references, choices, spatial));
            host.expect("a thread").join().expect("no panic");
        });
    }
}

/// Name of the test below, and of the variable that makes a process its child.
const WITHOUT_MEMORY: &str = "a_mesh_without_memory_is_an_error";

/// A child process has 100 MB more of address space than it uses: too little for the largest mesh,
/// which takes 230 MB.
#[cfg(target_os = "linux")]
#[test]
fn a_mesh_without_memory_is_an_error() {
    if std::env::var_os(WITHOUT_MEMORY).is_none() {
        let test = std::env::current_exe().expect("a test has a path");
        let mut child = Command::new(test);
        let status = child.args(["--exact", WITHOUT_MEMORY]).env(WITHOUT_MEMORY, "").status();
        assert!(status.expect("the child starts").success());
        return;
    }
    let library = Library::load();
    let f = &library.functions;
    let mesh = ["primaryArc", "secondaryArc", "strand", "cellsPerElement"];
    let mesh = mesh.map(|name| reference(&format!("mesh.{name}")));
    let c = f.instantiate();
    let memory = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    let pages: u64 = memory.split(' ').next().expect("a number").parse().expect("pages");
    let limit = pages * 4096 + 100_000_000;
    let limit = libc::rlimit {
        rlim_cur: limit,
        rlim_max: limit,
    };
    // SAFETY: a limit, an instance that is not used any more when it is freed, and as many values
    // as references.
    unsafe {
        assert_eq!(libc::setrlimit(libc::RLIMIT_AS, &raw const limit), 0);
        let status = (f.fmi2SetInteger)(c, mesh.as_ptr(), 4, [200, 200, 200, 16].as_ptr());
        assert_eq!(status, OK);
        assert_eq!((f.fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!((f.fmi2EnterInitializationMode)(c), OK);
        assert_eq!((f.fmi2ExitInitializationMode)(c), ERROR);
        assert_eq!((f.fmi2Reset)(c), OK);
        f.make_cheap(c);
        f.start(c);
        (f.fmi2FreeInstance)(c);
    }
}
