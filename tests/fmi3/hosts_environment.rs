//! Hosts that trap, flush or round otherwise: the same bits as without, in callbacks too, and their environment as it was.

use std::cell::RefCell;
use std::rc::Rc;

use pushbelt::fmi::log::Status::Ok;

use crate::environment::{DEFAULT, Environment, HOSTS, present, within};
use crate::importer::*;

const UPDATES: Handles<'_> = Handles {
    events: true,
    early_return: true,
    required: &["primary.torque", "primary.speed"],
};

/// A steady start, and steps to slip through the belt, with an output read in each intermediate update.
fn run(times: &[f64]) -> (Vec<Vec<u64>>, Vec<Environment>) {
    let importer = Importer::new(UPDATES);
    importer.make_cheap();
    assert_eq!(importer.set_boolean("initial.steady", 1), Ok);
    importer.start(true);
    let (seen, speeds) = (Rc::new(RefCell::new(Vec::new())), Rc::new(RefCell::new(Vec::new())));
    let (c, environments, record) = (importer.c, Rc::clone(&seen), Rc::clone(&speeds));
    importer.answer(move |_| {
        environments.borrow_mut().push(present());
        record.borrow_mut().push(read(c, "primary.speed").to_bits());
        environments.borrow_mut().push(present());
        None
    });
    assert_eq!(importer.set_real("primary.torque", 400.0), Ok);
    let mut readings = Vec::new();
    for time in times {
        let ended = importer.step(*time, 1e-3);
        assert_eq!(ended.status, Ok, "{}", importer.last());
        readings.push(importer.readings());
        if ended.event {
            break;
        }
    }
    assert_eq!(importer.boolean("macroSlip"), 1);
    drop(importer);
    readings.push(speeds.take());
    (readings, seen.take())
}

#[test]
fn a_host_that_traps_flushes_or_rounds_upward_gets_the_same_bits() {
    let times: Vec<f64> = (0..30).map(|k| f64::from(k) * 1e-3).collect();
    let (expected, updates) = within(DEFAULT, || run(&times));
    assert!(!updates.is_empty());
    for host in HOSTS {
        let (readings, seen) = within(host, || run(&times));
        assert!(readings == expected, "{host:?}");
        assert!(seen.iter().all(|of_callback| *of_callback == host), "{host:?}");
    }
}
