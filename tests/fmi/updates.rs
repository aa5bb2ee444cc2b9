//! Intermediate updates at the variator's own steps.

use crate::importer::Handles;
use crate::variator::{Importer, reference};
use pushbelt::fmi::Version::Three;
use pushbelt::fmi::log::Status::Ok;
use std::cell::RefCell;
use std::rc::Rc;

/// An importer that is called back and may return early.
fn watching() -> Importer {
    let required = ["primary.torque", "primary.speed", "primary.externalTorque"].map(reference);
    Importer::coarse(Three, Handles::updates(&required))
}

#[test]
fn outputs_can_be_read_at_own_steps() {
    let importer = watching();
    importer.start();
    importer.put("primary.torque", 80.0);
    let seen = Rc::new(RefCell::new(Vec::new()));
    let (alias, record) = (importer.alias(), Rc::clone(&seen));
    // The torque is that of the ramp at the time of the update.
    let outputs = |of: &Importer| ["primary.speed", "primary.externalTorque"].map(|name| of.get(name));
    importer.answer(move |update| {
        assert_eq!(alias.get("time"), update.time);
        record.borrow_mut().push((update.time, outputs(&alias)));
        None
    });
    let ended = importer.step(0.0, 5e-3);
    assert_eq!((ended.status, ended.early, ended.time), (Ok, false, 5e-3));
    let seen = seen.borrow();
    assert!(seen.len() > 3, "{} own steps", seen.len());
    assert!(seen.windows(2).all(|pair| pair[0].0 < pair[1].0), "times rise");
    assert_eq!(*seen.last().expect("some"), (5e-3, outputs(&importer)));
}

/// A torque that rises within the step and is set at each own step is more accurate than one that
/// is held.
#[test]
fn inputs_can_change_within_a_step() {
    let torque = |time: f64| 50.0 + 2e4 * time;
    let run = |size: f64, watched: bool| {
        let importer = watching();
        importer.put("inputs.ramp", 0.0);
        importer.put("solver.maxStep", 2e-4);
        importer.start();
        if watched {
            let alias = importer.alias();
            importer.answer(move |update| {
                if update.set {
                    alias.put("primary.torque", torque(update.time));
                }
                None
            });
        }
        let mut time = 0.0;
        while time < 0.0399 {
            importer.put("primary.torque", torque(time));
            importer.advance(time, size);
            time += size;
        }
        importer.get("primary.speed")
    };
    let exact = run(1e-4, false);
    let [held, followed] = [false, true].map(|watched| (run(1e-2, watched) - exact).abs());
    assert!(followed < 0.1 * held, "{followed} against {held}");
}

/// At a time between the belt's own steps.
#[test]
fn an_importer_can_return_a_little_later() {
    let importer = watching();
    importer.start();
    let asked = Rc::new(RefCell::new(None));
    let record = Rc::clone(&asked);
    importer.answer(move |update| {
        let here = update.time > 2e-3 && record.borrow().is_none();
        here.then(|| *record.borrow_mut().insert(update.time) + 1.3e-4)
    });
    let ended = importer.step(0.0, 5e-3);
    let asked = asked.borrow().expect("asked");
    assert_eq!((ended.status, ended.early, ended.event), (Ok, true, false));
    assert!((ended.time - asked - 1.3e-4).abs() < 1e-12, "{ended:?}");
    assert_eq!(importer.get("time"), ended.time);
    let rest = importer.step(ended.time, 5e-3 - ended.time);
    assert_eq!((rest.status, rest.early), (Ok, false));
    assert!((rest.time - 5e-3).abs() < 1e-12);
}
