//! Events: slip that begins and ends, end stops; early return and event mode.

use std::ptr::null_mut;

use pushbelt::fmi::log::Status::{Error, Ok};
use pushbelt::unit::exports::c_abi3::*;

use crate::importer::*;

const EVENTS: Handles<'_> = Handles {
    events: true,
    early_return: true,
    required: &[],
};

/// After 20 ms at constant inputs, a load and clamping forces for the following steps.
fn loaded(handles: Handles<'_>, torque: f64, forces: [f64; 2]) -> Importer {
    let importer = Importer::running(handles);
    for k in 0..20 {
        let ended = importer.step(f64::from(k) * 1e-3, 1e-3);
        assert_eq!((ended.status, ended.event), (Ok, false));
    }
    assert_eq!(importer.set_real("primary.torque", torque), Ok);
    for (name, force) in ["primary.clampingForce", "secondary.clampingForce"]
        .into_iter()
        .zip(forces)
    {
        assert_eq!(importer.set_real(name, force), Ok);
    }
    importer
}

/// An over-torque.
fn overloaded(handles: Handles<'_>) -> Importer {
    loaded(handles, 400.0, [13e3, 10e3])
}

/// Steps on the grid of 1 ms until the first event, at most to 100 ms; how the step ended.
fn first_event(importer: &Importer) -> (f64, Ended) {
    let mut time = 0.02_f64;
    while time < 0.1 {
        let end = ((time * 1e3 + 1e-6).floor() + 1.0) * 1e-3;
        let ended = importer.step(time, end - time);
        assert_eq!(ended.status, Ok, "{}", importer.last());
        if ended.event {
            return (end, ended);
        }
        assert!(!ended.early);
        time = ended.time;
    }
    panic!("no event");
}

#[test]
fn a_step_ends_where_the_belt_begins_to_slip_through() {
    let importer = overloaded(EVENTS);
    let (end, ended) = first_event(&importer);
    assert!(ended.early && ended.time < end && ended.time > end - 1e-3, "{ended:?}");
    assert_eq!(importer.real("time"), ended.time);
    assert_eq!(importer.boolean("macroSlip"), 1);
    let words = "the belt begins to slip through (macro-slip)";
    assert_eq!(importer.last(), format!("event at {} s: {words}", ended.time));
    // The master lowers the torque in event mode.
    unsafe { assert_eq!(fmi3EnterEventMode(importer.c), Ok) };
    assert_eq!(
        importer.step(ended.time, 1e-3).status,
        Error,
        "a step before event mode"
    );
    assert_eq!(importer.set_real("primary.torque", 20.0), Ok);
    importer.handle_event(false);
    let rest = importer.step(ended.time, end - ended.time);
    assert_eq!((rest.status, rest.time), (Ok, end));
}

#[test]
fn a_step_ends_where_a_sheave_reaches_its_stop() {
    let importer = loaded(EVENTS, 50.0, [60e3, 6e3]);
    let mut time = 0.02_f64;
    let mut reached = false;
    while time < 0.06 && !reached {
        let ended = importer.step(time, 1e-3);
        assert_eq!(ended.status, Ok, "{}", importer.last());
        reached = ended.event
            && importer
                .last()
                .contains("the secondary sheave reaches its opening stop");
        if ended.event {
            importer.handle_event(true);
        }
        time = ended.time;
    }
    assert!(reached);
    // A sheave that rests at its stop causes no further event.
    for _ in 0..100 {
        let ended = importer.step(time, 1e-4);
        assert!(!importer.last().contains("stop") || !ended.event, "{}", importer.last());
        if ended.event {
            importer.handle_event(true);
        }
        time = ended.time;
    }
}

#[test]
fn without_early_return_the_event_is_reported_at_the_end_of_the_step() {
    let [early, late] = [true, false].map(|early_return| {
        let importer = overloaded(Handles { early_return, ..EVENTS });
        first_event(&importer)
    });
    assert_eq!(early.0, late.0, "in the same communication step");
    assert!(early.1.early && !late.1.early);
    assert_eq!(late.1.time, late.0);
}

#[test]
fn without_event_mode_there_is_no_event() {
    let importer = overloaded(Handles {
        events: false,
        ..EVENTS
    });
    for k in 20..40 {
        let ended = importer.step(f64::from(k) * 1e-3, 1e-3);
        assert_eq!((ended.status, ended.event, ended.early), (Ok, false, false));
    }
    assert_eq!(importer.boolean("macroSlip"), 1);
}

/// After a rollback to a time before the event it occurs again; steps that end at the event reach the same end.
#[test]
fn an_early_return_can_be_rolled_back() {
    let importer = overloaded(EVENTS);
    let mut state = null_mut();
    // SAFETY: an instance and a state of it.
    unsafe {
        assert_eq!(fmi3GetFMUState(importer.c, &raw mut state), Ok);
        let (_, first) = first_event(&importer);
        let there = importer.readings();
        assert_eq!(fmi3SetFMUState(importer.c, state), Ok);
        let (_, again) = first_event(&importer);
        assert_eq!(
            (again, importer.readings()),
            (first, there),
            "the same event, the same bits"
        );
        assert_eq!(fmi3SetFMUState(importer.c, state), Ok);
        assert_eq!(importer.real("time"), 0.02);
        // A step that ends before the event has none. Slip is detected at the end of a step of the integrator, so it began up
        // to 1 ms before.
        let ended = importer.step(0.02, first.time - 0.02 - 1e-3);
        assert_eq!((ended.status, ended.event, ended.early), (Ok, false, false));
        assert_eq!(importer.boolean("macroSlip"), 0);
        assert_eq!(fmi3FreeFMUState(importer.c, &raw mut state), Ok);
    }
}
