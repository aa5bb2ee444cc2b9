//! Events of a belt in FMI 3.0: slip that begins and ends, end stops; early return and event mode.

use crate::importer::{Ended, Handles};
use crate::variator::Importer;
use pushbelt::fmi::Version::Three;
use pushbelt::fmi::log::Status::Ok;

/// After 20 ms at constant inputs, a load and clamping forces for the following steps.
fn loaded(handles: Handles<'_>, torque: f64, [primary, secondary]: [f64; 2]) -> Importer {
    let importer = Importer::coarse(Three, handles);
    importer.start();
    for k in 0..20 {
        let ended = importer.step(f64::from(k) * 1e-3, 1e-3);
        assert_eq!((ended.status, ended.event), (Ok, false));
    }
    importer.put("primary.torque", torque);
    importer.put("primary.clampingForce", primary);
    importer.put("secondary.clampingForce", secondary);
    importer
}

fn overloaded(handles: Handles<'_>) -> Importer {
    loaded(handles, 400.0, [13e3, 10e3])
}

/// Steps on the grid of 1 ms until the first event, at most to 100 ms: the end of the last
/// communication step, and how it ended.
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
    let importer = overloaded(Handles::EVENTS);
    let (end, ended) = first_event(&importer);
    assert!(ended.early && ended.time < end && ended.time > end - 1e-3, "{ended:?}");
    assert_eq!(importer.get("time"), ended.time);
    assert!(importer.is("macroSlip"));
    let words = "the belt begins to slip through (macro-slip)";
    assert_eq!(importer.last(), format!("event at {} s: {words}", ended.time));
    // The importer lowers the torque in event mode.
    assert_eq!(importer.enter_event_mode(), Ok);
    importer.put("primary.torque", 20.0);
    importer.handle_event();
    let rest = importer.step(ended.time, end - ended.time);
    assert_eq!((rest.status, rest.time), (Ok, end));
}

#[test]
fn a_step_ends_where_a_sheave_reaches_its_stop() {
    let importer = loaded(Handles::EVENTS, 50.0, [60e3, 6e3]);
    let (mut time, mut reached) = (0.02, false);
    let mut step = |size: f64| {
        let ended = importer.step(time, size);
        assert_eq!(ended.status, Ok, "{}", importer.last());
        if ended.event {
            assert_eq!(importer.enter_event_mode(), Ok);
            importer.handle_event();
        }
        time = ended.time;
        (time, ended.event && importer.last().contains("stop"))
    };
    while !reached {
        let (time, stopped) = step(1e-3);
        assert!(time < 0.06, "no stop is reached");
        reached = stopped;
    }
    importer.assert_logged("the secondary sheave reaches its opening stop");
    for _ in 0..100 {
        importer.record.messages.borrow_mut().clear();
        assert!(!step(1e-4).1, "a sheave that rests at its stop: {}", importer.last());
    }
}

/// After a rollback to a time before the event it occurs again; steps that end at the event reach
/// the same end.
#[test]
fn an_early_return_can_be_rolled_back() {
    let importer = overloaded(Handles::EVENTS);
    let state = importer.stored();
    let (_, first) = first_event(&importer);
    let there = importer.readings();
    assert_eq!(importer.restore(state), Ok);
    let (_, again) = first_event(&importer);
    assert_eq!((again, importer.readings()), (first, there));
    assert_eq!(importer.restore(state), Ok);
    assert_eq!(importer.get("time"), 0.02);
    // A step that ends before the event has none. Slip is detected at the end of a step of the
    // integrator, so it began up to 1 ms before.
    let ended = importer.step(0.02, first.time - 0.02 - 1e-3);
    assert_eq!((ended.status, ended.event, ended.early), (Ok, false, false));
    assert!(!importer.is("macroSlip"));
}
