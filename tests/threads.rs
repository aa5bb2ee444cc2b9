//! Many instances in one process, on several threads.

#![allow(unsafe_code, reason = "it calls the C functions")]

use std::fmt::Debug;
use std::thread;

use pushbelt::fmi::fmi3::{Boolean, Environment, Instance};
use pushbelt_support::shared_library::{Library, OK, reference};
use pushbelt_support::shared_library3::{Functions3, Watches};

/// Sixteen runs have the same results one after the other and two on each of eight threads; the first two runs differ.
fn assert_same_on_threads<T: PartialEq + Debug + Send>(run: impl Fn(u32) -> T + Copy + Send + Sync) {
    let alone: Vec<_> = (0..16).map(run).collect();
    assert_ne!(alone[0], alone[1], "the instances differ");
    let together: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..8)
            .map(|worker| scope.spawn(move || [run(2 * worker), run(2 * worker + 1)]))
            .collect();
        let joined = workers.into_iter().map(|worker| worker.join().expect("no panic"));
        joined.flatten().collect()
    });
    assert_eq!(together, alone);
}

#[test]
fn sixteen_instances_on_eight_threads_give_the_sequential_bits() {
    let library = Library::load();
    let f = library.functions;
    let run = move |number: u32| {
        let c = f.instantiate();
        // SAFETY: an instance, not used any more when it is freed.
        unsafe {
            f.make_cheap(c);
            f.start(c);
            let result = f.run(c, f64::from(number), 40);
            (f.fmi2FreeInstance)(c);
            result
        }
    };
    assert_same_on_threads(run);
}

/// A master that reads a speed at each internal step of the unit; its environment is the instance and the functions.
struct Watcher {
    functions: Functions3,
    c: Instance,
    seen: f64,
}

unsafe extern "C" fn watch(
    environment: Environment,
    _time: f64,
    _set: Boolean,
    _get: Boolean,
    _finished: Boolean,
    _can_return: Boolean,
    _wanted: *mut Boolean,
    _until: *mut f64,
) {
    // SAFETY: the environment is the `Watcher` of the instance that calls.
    unsafe {
        let watcher = &mut *environment.cast::<Watcher>();
        let speed = reference("primary.speed");
        let status = (watcher.functions.fmi3GetFloat64)(watcher.c, &speed, 1, &raw mut watcher.seen, 1);
        assert_eq!(status, OK);
    }
}

#[test]
fn sixteen_instances_of_fmi_3_with_updates_on_eight_threads_give_the_sequential_bits() {
    let library = Library::load();
    let functions = library.functions3;
    let run = move |number: u32| {
        let mut watcher = Watcher {
            functions,
            c: std::ptr::null_mut(),
            seen: 0.0,
        };
        let environment = &raw mut watcher;
        let c = functions.instantiate(Watches {
            early_return: true,
            update: number.is_multiple_of(2).then_some((watch, environment.cast())),
            ..Watches::default()
        });
        // SAFETY: the watcher lives longer than the instance, and is used by its callbacks only; the instance is not used any
        // more when it is freed.
        unsafe {
            (*environment).c = c;
            functions.make_cheap(c);
            functions.start(c);
            let result = functions.run(c, f64::from(number), 40);
            (functions.fmi3FreeInstance)(c);
            assert_eq!(
                (*environment).seen > 0.0,
                number.is_multiple_of(2),
                "every second instance has intermediate updates"
            );
            result
        }
    };
    assert_same_on_threads(run);
}
