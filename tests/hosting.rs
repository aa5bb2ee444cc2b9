//! Effects of the loaded library on its host process: memory, threads, other instances, unloading.
//!
//! `PUSHBELT_STEPS=1000000 PUSHBELT_CYCLES=1000 cargo test --test hosting` is the long run.

#![allow(unsafe_code, reason = "it calls the C functions")]

use pushbelt::fmi::fmi2::Component;
use pushbelt_support::shared_library::{Functions, Library, OK, count, path};
use std::path::Path;

/// Bytes of memory of this process that are in use.
fn resident() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    let resident = pages.split_whitespace().nth(1).expect("two numbers");
    4096 * resident.parse::<u64>().expect("a number of pages")
}

fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").expect("Linux").count()
}

fn is_mapped(path: &Path) -> bool {
    let maps = std::fs::read_to_string("/proc/self/maps").expect("Linux");
    maps.contains(&*path.to_string_lossy())
}

/// After everything has been used once, memory does not grow.
fn assert_steady(what: &str, before: u64) {
    let grown = resident().saturating_sub(before);
    assert!(grown < 1 << 20, "{what}: {grown} bytes more");
}

fn running(f: &Functions, steps: u32) -> Component {
    let c = f.instantiate();
    // SAFETY: an instance.
    unsafe {
        f.make_cheap(c);
        f.start(c);
        f.run(c, steps);
    }
    c
}

fn cycle(f: &Functions, steps: u32) {
    // SAFETY: an instance, not used any more when it is freed.
    unsafe { (f.fmi2FreeInstance)(running(f, steps)) };
}

/// One test, because memory is measured for the whole process.
#[cfg(target_os = "linux")]
#[test]
fn instances_steps_and_loading_leave_no_memory_or_threads() {
    let before_loading = threads();
    let library = Library::load();
    let f = &library.functions;

    (0..20).for_each(|_| cycle(f, 2));
    let before = resident();
    (0..count("PUSHBELT_CYCLES", 200)).for_each(|_| cycle(f, 2));
    assert_steady("instances", before);

    let c = running(f, 1);
    let mut done = 1_u32;
    let mut go_on = |count: u32| {
        for _ in 0..count {
            // SAFETY: an instance.
            let status = unsafe { (f.fmi2DoStep)(c, f64::from(done) * 1e-3, 1e-3, 1) };
            assert_eq!(status, OK);
            done += 1;
        }
    };
    go_on(1000);
    let before = resident();
    go_on(count("PUSHBELT_STEPS", 20_000));
    assert_steady("steps", before);
    // SAFETY: the instance is not used any more.
    unsafe { (f.fmi2FreeInstance)(c) };

    let path = path();
    assert!(is_mapped(&path));
    drop(library);
    let reload = || {
        let library = Library::load();
        cycle(&library.functions, 1);
        assert_eq!(threads(), before_loading, "the library starts no thread");
    };
    (0..5).for_each(|_| reload());
    let before = resident();
    (0..50).for_each(|_| reload());
    assert_steady("loading", before);
    assert!(!is_mapped(&path), "the library is still mapped");
}
