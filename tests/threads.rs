//! Many instances in one process, on several threads.

#![allow(unsafe_code, reason = "it calls the C functions")]

use std::thread;

use pushbelt_lab::shared_library::Library;

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
    let alone: Vec<_> = (0..16).map(run).collect();
    assert_ne!(alone[0], alone[1], "the instances differ");
    let together: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..8)
            .map(|worker| scope.spawn(move || [run(2 * worker), run(2 * worker + 1)]))
            .collect();
        workers
            .into_iter()
            .flat_map(|worker| worker.join().expect("no panic"))
            .collect()
    });
    assert_eq!(together, alone);
}
