//! Intermediate update mode: reading, setting and early return at the unit's own steps.

use pushbelt::fmi::log::Status::{Discard, Error, Ok};
use pushbelt::unit::exports::c_abi3::*;
use std::cell::RefCell;
use std::rc::Rc;

use crate::importer::*;

const WATCHED: Handles<'_> = Handles {
    events: false,
    early_return: true,
    required: &["primary.torque", "primary.speed", "thrustRatio"],
};

#[test]
fn outputs_can_be_read_at_the_units_own_steps() {
    let importer = Importer::running(WATCHED);
    let c = importer.c;
    let seen = Rc::new(RefCell::new(Vec::new()));
    let store = Rc::clone(&seen);
    importer.answer(move |update| {
        assert!(update.get && update.finished);
        assert_eq!(read(c, "time"), update.time);
        store.borrow_mut().push((update.time, read(c, "primary.speed")));
        None
    });
    let ended = importer.step(0.0, 5e-3);
    assert_eq!((ended.status, ended.early, ended.time), (Ok, false, 5e-3));
    let seen = seen.borrow();
    assert!(seen.len() > 3, "{} own steps", seen.len());
    assert!(seen.windows(2).all(|pair| pair[0].0 < pair[1].0), "times rise");
    assert_eq!(*seen.last().expect("some"), (5e-3, importer.real("primary.speed")));
    let updates = importer.record.updates.borrow();
    let (last, others) = updates.split_last().expect("some");
    assert!(
        !last.set && !last.can_return,
        "at the end there is nothing left to change"
    );
    assert!(others.iter().all(|update| update.set && update.can_return));
}

#[test]
fn an_update_can_use_announced_variables_only_and_call_nothing_else() {
    let importer = Importer::running(WATCHED);
    let c = importer.c;
    importer.answer(move |update| {
        let mut value = 0.0;
        let torque = reference("primary.torque");
        // SAFETY: the instance that calls back, and places for values.
        unsafe {
            for name in ["belt.speed", "profile.pushForce"] {
                assert_eq!(fmi3GetFloat64(c, &reference(name), 1, &raw mut value, 1), Error);
            }
            assert_eq!(fmi3SetFloat64(c, &reference("secondary.torque"), 1, &1.0, 1), Error);
            assert_eq!(
                fmi3SetFloat64(c, &torque, 1, &f64::from(update.set), 1) == Ok,
                update.set
            );
            assert_eq!(fmi3SetFloat64(c, &torque, 1, &50.0, 1) == Ok, update.set);
            assert_eq!(
                fmi3GetOutputDerivatives(c, &reference("thrustRatio"), 1, &1, &raw mut value, 1),
                Ok
            );
            assert!(value.is_finite());
            assert_eq!(
                fmi3GetBoolean(c, &reference("macroSlip"), 1, [0].as_mut_ptr(), 1),
                Error
            );
            let mut state = std::ptr::null_mut();
            assert_eq!(fmi3GetFMUState(c, &raw mut state), Error);
            assert_eq!(fmi3Reset(c), Error);
            assert_eq!(fmi3Terminate(c), Error);
            assert_eq!(fmi3EnterEventMode(c), Error);
            // No effect, because a step is in progress.
            fmi3FreeInstance(c);
            let mut flag = [0; 3];
            let [a, b, d] = flag.each_mut().map(std::ptr::from_mut);
            assert_eq!(fmi3DoStep(c, 0.0, 1e-3, 1, a, b, d, &raw mut value), Error);
        }
        None
    });
    assert_eq!(importer.step(0.0, 5e-3).status, Ok);
    assert!(importer.record.updates.borrow().len() > 3);
    assert_eq!(
        importer.set_real("secondary.torque", -40.0),
        Ok,
        "afterwards all is as before"
    );
}

/// A torque that rises within the step and is set at each internal step is more accurate than one that is held.
#[test]
fn inputs_can_change_within_a_step() {
    let torque = |time: f64| 50.0 + 2e4 * time;
    let run = |size: f64, watched: bool| {
        let importer = Importer::new(WATCHED);
        importer.make_cheap();
        assert_eq!(importer.set_real("inputs.ramp", 0.0), Ok);
        assert_eq!(importer.set_real("solver.maxStep", 2e-4), Ok);
        importer.start(false);
        let c = importer.c;
        if watched {
            importer.answer(move |update| {
                // SAFETY: the instance that calls back, one reference, one value.
                let set = || unsafe { fmi3SetFloat64(c, &reference("primary.torque"), 1, &torque(update.time), 1) };
                assert!(!update.set || set() == Ok);
                None
            });
        }
        let mut time = 0.0;
        while time < 0.0399 {
            assert_eq!(importer.set_real("primary.torque", torque(time)), Ok);
            assert_eq!(importer.step(time, size).status, Ok, "{}", importer.last());
            time += size;
        }
        importer.real("primary.speed")
    };
    let exact = run(1e-4, false);
    let [held, followed] = [false, true].map(|watched| (run(1e-2, watched) - exact).abs());
    assert!(followed < 0.1 * held, "{followed} against {held}");
}

#[test]
fn a_master_can_return_early_here_or_a_little_later() {
    for (later, allowed) in [(0.0, true), (1.3e-4, true), (f64::NAN, true), (1.0, true), (0.0, false)] {
        let importer = Importer::running(Handles {
            early_return: allowed,
            ..WATCHED
        });
        let asked = Rc::new(RefCell::new(None));
        let store = Rc::clone(&asked);
        importer.answer(move |update| {
            let here = update.time > 2e-3 && store.borrow().is_none();
            if here {
                *store.borrow_mut() = Some(update.time);
            }
            here.then_some(update.time + later)
        });
        let ended = importer.step(0.0, 5e-3);
        assert_eq!(ended.status, Ok, "{}", importer.last());
        let asked = asked.borrow().expect("asked");
        if !allowed || later == 1.0 {
            assert_eq!((ended.early, ended.time), (false, 5e-3), "{later}");
            continue;
        }
        let requested = if later.is_nan() { asked } else { asked + later };
        assert!(
            ended.early && !ended.event && (ended.time - requested).abs() < 1e-12,
            "{later}: {ended:?}"
        );
        assert_eq!(importer.real("time"), ended.time);
        importer.answer(|_| None);
        let rest = importer.step(ended.time, 5e-3 - ended.time);
        assert_eq!((rest.status, rest.early), (Ok, false));
        assert!((rest.time - 5e-3).abs() < 1e-12);
    }
}

/// An input out of range at an intermediate update is discarded, as between steps: the old value remains, and the step continues.
#[test]
fn a_bad_input_within_a_step_is_discarded() {
    let importer = Importer::running(WATCHED);
    let c = importer.c;
    importer.answer(move |update| {
        if update.set {
            // SAFETY: the instance that calls back, one reference, one value.
            let status = unsafe { fmi3SetFloat64(c, &reference("primary.torque"), 1, &f64::NAN, 1) };
            assert_eq!(status, Discard);
        }
        None
    });
    let ended = importer.step(0.0, 5e-3);
    let told = importer.record.messages.borrow();
    assert!(told.iter().any(|(_, _, text)| text.contains("primary.torque = NaN")));
    assert_eq!((ended.status, ended.time), (Ok, 5e-3));
    assert!(importer.real("primary.torque").is_finite());
}

/// A step that takes too much work is discarded, after updates in it too: all is as before, the last successful time is its start, and it
/// can be repeated.
#[test]
fn a_discarded_step_leaves_all_as_before() {
    for handles in [Handles::default(), WATCHED] {
        let watched = handles.early_return;
        let importer = Importer::new(handles);
        assert_eq!(importer.set_real("friction.velocity", 1e-6), Ok);
        assert_eq!(importer.set_real("inputs.ramp", 0.0), Ok);
        importer.start(false);
        let updates = Rc::new(RefCell::new(0));
        let count = Rc::clone(&updates);
        importer.answer(move |_| {
            *count.borrow_mut() += 1;
            None
        });
        assert_eq!(importer.step(0.0, 1e-3).status, Ok, "{}", importer.last());
        let before = importer.readings();
        let loads = [
            "primary.clampingForce",
            "secondary.clampingForce",
            "primary.torque",
            "secondary.torque",
        ];
        let gentle = loads.map(|name| importer.real(name));
        for (name, load) in loads.into_iter().zip([5e5, 5e5, 1e4, -1e4]) {
            assert_eq!(importer.set_real(name, load), Ok);
        }
        *updates.borrow_mut() = 0;
        let ended = importer.step(1e-3, 2e-3);
        assert_eq!(
            (ended.status, ended.event, ended.early, ended.time),
            (Discard, false, false, 1e-3)
        );
        assert!(importer.last().contains("was given up at 0.001"), "{}", importer.last());
        assert_eq!(*updates.borrow() > 0, watched);
        assert_eq!((importer.readings(), importer.real("time")), (before, 1e-3));
        for (name, load) in loads.into_iter().zip(gentle) {
            assert_eq!(importer.set_real(name, load), Ok);
        }
        let ended = importer.step(1e-3, 2e-3);
        assert_eq!((ended.status, ended.time), (Ok, 3e-3), "{}", importer.last());
    }
}
