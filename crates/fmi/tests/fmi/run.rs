//! The states of a run: calls in each of them, steps, failures, in both versions.

use pushbelt_fmi::Version::{self, Three, Two};
use pushbelt_fmi::log::Status::{self, Discard, Error, Ok};
use pushbelt_fmi::state::State;
use pushbelt_fmi::unit::Experiment;

use crate::importer::{BOTH, Ended, Handles, experiment};
use crate::tank::*;

pub fn running(version: Version) -> Importer {
    let importer = Importer::new(version);
    importer.start();
    importer
}

pub fn ended(event: bool, early: bool, time: f64) -> Ended {
    Ended {
        status: Ok,
        event,
        early,
        time,
    }
}

#[test]
fn a_run_goes_through_its_states() {
    for version in BOTH {
        let importer = Importer::new(version);
        assert_eq!(importer.enter(experiment(3.0, Some(5.0))), Ok);
        assert_eq!(importer.real(LEVEL), 1.0);
        assert_eq!(importer.set(START, 4.0), Ok);
        assert_eq!(importer.real(LEVEL), 4.0, "set in initialization mode, it starts again");
        assert_eq!(importer.exit(), Ok);
        assert_eq!(importer.step(3.0, 1.0), ended(false, false, 4.0));
        assert_eq!(importer.real(LEVEL), 6.0);
        assert_eq!(importer.set(INFLOW, 1.0), Ok);
        assert_eq!(importer.step(4.0, 1.0), ended(false, false, 5.0));
        importer.assert(importer.step(5.0, 1.0).status, Error, "stop time 5 s");
        assert_eq!(importer.terminate(), Ok);
        assert_eq!(importer.real(LEVEL), 7.0, "last values can be read after the end");
        assert_eq!(importer.reset(), Ok);
        importer.start();
        importer.assert_reals(&[LEVEL, START, INFLOW], &[1.0, 1.0, 2.0]);
        assert_eq!(importer.step(0.0, 1.0), ended(false, false, 1.0));
    }
}

use State::{
    Error as Failed, Event, Initialisation, Instantiated, StepComplete as Step, StepFailed as Discarded,
    Terminated,
};

fn in_state(version: Version, state: State) -> Importer {
    let importer = match state {
        Event => Importer::handling(version, Handles::EVENTS),
        _ => Importer::new(version),
    };
    if state != Instantiated {
        assert_eq!(importer.enter(experiment(0.0, None)), Ok);
    }
    if ![Instantiated, Initialisation].contains(&state) {
        assert_eq!(importer.exit(), Ok);
    }
    match state {
        Discarded => {
            assert_eq!(importer.set(BRIM, 0.0), Ok);
            assert_eq!(importer.step(0.0, 1.0).status, Discard);
            assert_eq!(importer.set(BRIM, 1e9), Ok);
        }
        Failed => {
            assert_eq!(importer.set(INFLOW, BURST), Ok);
            assert_eq!(importer.step(0.0, 1.0).status, Error);
        }
        Terminated => assert_eq!(importer.terminate(), Ok),
        _ => {}
    }
    importer
}

/// A call and the states in which it is allowed: table 4.2.4 of FMI 2.0, sections 2.3 and 4.2 of
/// FMI 3.0.
type Rule = (&'static str, fn(&Importer) -> Status, &'static [State]);

fn status<T>(result: Result<T, Status>) -> Status {
    result.err().unwrap_or(Ok)
}

const BEGIN: &[State] = &[Instantiated, Initialisation];
const STEPS: &[State] = &[Step, Discarded];
const INPUTS: &[State] = &[Instantiated, Initialisation, Step, Discarded, Event];
const RUN: &[State] = &[Step, Discarded, Event, Terminated];
const WITH_OUTPUTS: &[State] = &[Initialisation, Step, Discarded, Event, Terminated];

const RULES: [Rule; 12] = [
    ("initialise", |i| i.enter(experiment(0.0, None)), &[Instantiated]),
    ("exit initialisation mode", |i| i.exit(), &[Initialisation]),
    ("terminate", |i| i.terminate(), &[Step, Discarded, Event]),
    ("step", |i| i.step(0.0, 0.1).status, STEPS),
    ("set an input", |i| i.set(BRIM, 9.0), INPUTS),
    ("set a parameter", |i| i.set(START, 1.0), BEGIN),
    ("set a choice", |i| i.set_number(SHAPE, 1), BEGIN),
    ("set an output", |i| i.set(LEVEL, 1.0), &[]),
    ("read an output", |i| status(i.reals(&[LEVEL], 1)), WITH_OUTPUTS),
    ("derive", |i| status(i.derivatives(&[LEVEL], 1)), RUN),
    ("log", |i| i.log(true, &[]), &State::STORED),
    ("reset", |i| i.reset(), &State::STORED),
];

#[test]
fn a_call_is_done_where_the_standard_allows_it_and_changes_nothing_elsewhere() {
    for version in BOTH {
        for state in State::STORED {
            if (version, state) == (Two, Event) {
                continue;
            }
            for (name, call, allowed) in RULES {
                let importer = in_state(version, state);
                let before = importer.bytes();
                let found = call(&importer);
                let expected = if allowed.contains(&state) { Ok } else { Error };
                assert_eq!(found, expected, "{version:?}, {state:?}: {name}: {}", importer.last());
                if found == Error {
                    assert_eq!(importer.bytes(), before, "{version:?}, {state:?}: {name}");
                }
            }
        }
    }
}

#[test]
fn times_are_compared_with_tolerance() {
    for version in BOTH {
        let importer = running(version);
        let mut time = 0.0;
        for _ in 0..10 {
            assert_eq!(importer.step(time, 0.1).status, Ok);
            time += 0.1;
        }
        assert_ne!(time, 1.0, "the sum is not exact, which is why");
        assert_eq!(importer.step(1.0, 0.1).status, Ok);
        for wrong in [1.0, 1.2, 1.1 + 1e-4, f64::NAN, f64::INFINITY] {
            assert_eq!(importer.step(wrong, 0.1).status, Error, "{wrong}");
        }
        importer.assert_logged("inf s");
        for wrong in [0.0, -0.1, 101.0, f64::NAN, f64::INFINITY] {
            assert_eq!(importer.step(1.1, wrong).status, Error, "{wrong}");
        }
        assert_eq!(importer.step(1.1, 0.1).status, Ok, "refused steps change nothing");
        let [late, latest] = [1e6, 1e11].map(|start| {
            let importer = Importer::new(version);
            importer.start_at(start);
            importer
        });
        let steps = [1e6, 1e6, 1e6 + 1e-3].map(|from| late.step(from, 1e-3).status);
        assert_eq!((steps, latest.step(1e11, 1.0).status), ([Ok, Error, Ok], Error));
    }
}

#[test]
fn after_a_discarded_step_all_is_as_before_and_the_step_can_be_repeated() {
    for version in BOTH {
        let importer = running(version);
        assert_eq!(importer.set(BRIM, 2.0), Ok);
        let Ended {
            status, early, time, ..
        } = importer.step(0.0, 1.0);
        importer.assert((status, early, time), (Discard, false, 0.0), "DoStep: full");
        assert_eq!(importer.real(LEVEL), 1.0);
        assert_eq!(importer.step(0.0, 0.25), ended(false, false, 0.25), "a shorter one");
        // And one with other inputs.
        assert_eq!(importer.set(BRIM, 100.0), Ok);
        assert_eq!(importer.step(0.25, 0.75), ended(false, false, 1.0));
        assert_eq!(importer.real(LEVEL), 3.0);
        // A setting that the unit refuses.
        assert_eq!(importer.set(MARK, -1.0), Ok);
        importer.assert(importer.step(1.0, 0.5).status, Discard, "mark is below 0");
    }
}

#[test]
fn a_panic_fails_its_own_instance_only() {
    for version in BOTH {
        let (broken, sound) = (running(version), running(version));
        let state = broken.stored();
        assert_eq!(broken.set(INFLOW, BURST), Ok);
        broken.assert(
            broken.step(0.0, 1.0).status,
            Error,
            "DoStep: internal error, please report: the tank burst",
        );
        broken.assert(
            broken.step(0.0, 1.0).status,
            Error,
            "in the error state; reset it or restore a stored state",
        );
        assert_eq!(sound.step(0.0, 1.0).status, Ok);
        assert_eq!(broken.restore(state), Ok);
        assert_eq!(broken.step(0.0, 1.0).status, Ok);
    }
}

#[test]
fn a_start_that_fails_can_be_tried_again_after_reset() {
    for version in BOTH {
        let importer = Importer::new(version);
        assert_eq!(importer.set(GAIN, 0.5), Ok, "checked as a whole later");
        assert_eq!(importer.enter(experiment(0.0, None)), Ok);
        importer.assert(
            importer.exit(),
            Error,
            "ExitInitializationMode: gain = 0.5 does not fit",
        );
        assert_eq!(importer.reals(&[LEVEL], 1), Err(Error));
        assert_eq!(importer.exit(), Error);
        assert_eq!(importer.reset(), Ok);
        importer.start();
    }
}

#[test]
fn invalid_experiments_are_refused() {
    let good = experiment(1.0, Some(2.0));
    let with_start = |start| experiment(start, None);
    let with_stop = |stop| experiment(1.0, Some(stop));
    let with_tolerance = |tolerance| Experiment {
        tolerance: Some(tolerance),
        ..good
    };
    let bad = [
        [f64::NAN, f64::INFINITY, 1e14, -1e14].map(with_start),
        [f64::NAN, f64::NEG_INFINITY, 0.5, -1.0].map(with_stop),
        [f64::NAN, f64::INFINITY, 0.0, -1.0].map(with_tolerance),
    ];
    for version in BOTH {
        let importer = Importer::new(version);
        for bad in bad.iter().flatten() {
            assert_eq!(importer.enter(*bad), Error, "{bad:?}");
        }
        assert_eq!(importer.enter(good), Ok);
        assert_eq!(importer.exit(), Ok);
        assert_eq!(importer.step(1.0, 1.0).status, Ok);
        assert_eq!(importer.step(2.0, 1.0).status, Error);
        for (stop, step) in [(f64::INFINITY, 100.0), (1.0, 1e-9)] {
            assert_eq!(importer.reset(), Ok);
            assert_eq!(importer.enter(with_stop(stop)), Ok, "none, or the start");
            assert_eq!(importer.exit(), Ok);
            let expected = if stop > 1.0 { Ok } else { Error };
            assert_eq!(
                importer.step(1.0, step).status,
                expected,
                "the longest step, or one too many"
            );
        }
    }
}

/// Derivatives of outputs, and of inputs in FMI 2.0.
#[test]
fn derivatives_are_those_of_the_unit() {
    for version in BOTH {
        let importer = running(version);
        assert_eq!(importer.step(0.0, 1.0).status, Ok);
        assert_eq!(importer.derivatives(&[LEVEL], 1), Result::Ok(vec![2.0]));
        assert_eq!(importer.derivatives(&[], 1), Result::Ok(vec![]));
        for (reference, order, why) in [
            (LEVEL, 0, "level: the order of a derivative is 1, not 0"),
            (LEVEL, 2, "not 2"),
            (INFLOW, 1, "inflow is not an output"),
            (FULL, 1, "full (value reference 20) has another type"),
            (DEPTH, 1, "not an output"),
            (NONE, 1, "value reference 99"),
        ] {
            importer.assert(importer.derivatives(&[reference], order), Err(Error), why);
        }
        if version == Three {
            continue;
        }
        for (reference, order, value, why) in [
            (INFLOW, 0, 1.0, "derivative is 1, not 0"),
            (INFLOW, 2, 1.0, "derivative is 1, not 2"),
            (GAIN, 1, 1.0, "gain is not an input"),
            (LEVEL, 1, 1.0, "level is not an input"),
            (NONE, 1, 1.0, "value reference 99"),
            (INFLOW, 1, f64::NAN, "the derivative of inflow = NaN"),
        ] {
            importer.assert(importer.set_derivative(reference, order, value), Error, why);
        }
        assert_eq!(importer.set_derivative(INFLOW, 1, 1.0), Ok);
        assert_eq!(importer.step(1.0, 1.0).status, Ok);
        assert_eq!(importer.real(LEVEL), 5.5, "3 + 2 + 1/2");
        assert_eq!(importer.derivatives(&[LEVEL], 1), Result::Ok(vec![3.0]));
        assert_eq!(importer.real(INFLOW), 2.0, "an input reads back what was set");
        assert_eq!(importer.set_derivative(BRIM, 1, 0.0), Ok, "that of another input");
        assert_eq!(importer.step(2.0, 1.0).status, Ok);
        assert_eq!(importer.real(LEVEL), 7.5, "derivatives last for one step");
        // A discarded step leaves them in force.
        assert_eq!(importer.set_derivative(INFLOW, 1, 1.0), Ok);
        assert_eq!(importer.set(BRIM, 1.0), Ok);
        assert_eq!(importer.step(3.0, 1.0).status, Discard);
        assert_eq!(importer.set(BRIM, 100.0), Ok);
        assert_eq!(importer.step(3.0, 1.0).status, Ok);
        assert_eq!(importer.real(LEVEL), 10.0);
    }
}

/// A step that goes to an internal step's end on its own, a stored state, an overflow, a number
/// that is none: the same bits in every environment, to which all calls and callbacks return.
#[cfg(target_arch = "x86_64")]
#[test]
fn every_floating_point_environment_gives_the_same_bits_and_stays_as_it_is() {
    use crate::environment::{DEFAULT, HOSTS, call_in, present};
    use std::cell::RefCell;
    use std::rc::Rc;

    let run = |version| {
        let importer = Importer::handling(version, Handles::updates(&[INFLOW, LEVEL]));
        let seen = Rc::new(RefCell::new(Vec::new()));
        let (alias, record, heard) = (importer.alias(), Rc::clone(&seen), Rc::clone(&seen));
        *importer.record.hears.borrow_mut() = Some(Box::new(move || heard.borrow_mut().push(present())));
        importer.answer(move |_| {
            let before = present();
            // A call within the callback returns to the host's environment too.
            alias.real(LEVEL);
            record.borrow_mut().extend([before, present()]);
            None
        });
        assert_eq!(importer.set_reals(&[GAIN, INFLOW], &[1.0 / 3.0, 0.1]), Ok);
        importer.start();
        assert_eq!(importer.step(0.0, 0.7).status, Ok);
        let mut bits = vec![importer.real(LEVEL).to_bits()];
        let state = importer.stored();
        assert_eq!(importer.set(INFLOW, 5e-324), Ok);
        assert_eq!(importer.step(0.7, 0.1).status, Ok);
        bits.push(importer.real(INFLOW).to_bits());
        assert_eq!(importer.set_reals(&[INFLOW, GAIN], &[f64::MAX, 10.0]), Ok);
        importer.step(0.7999999999999999, 0.1);
        assert_eq!(importer.set(INFLOW, f64::NAN), Discard);
        assert_eq!(importer.restore(state), Ok);
        assert_eq!(importer.step(0.7, 0.3).status, Ok);
        bits.push(importer.real(LEVEL).to_bits());
        drop(importer);
        (bits, seen.take())
    };
    for version in BOTH {
        let (expected, _) = call_in(DEFAULT, || run(version));
        for host in HOSTS {
            let (bits, seen) = call_in(host, || run(version));
            assert_eq!(bits, expected, "{host:?}");
            assert!(seen.len() > if version == Two { 0 } else { 6 });
            assert!(seen.iter().all(|of_callback| *of_callback == host), "{host:?} {seen:?}");
        }
    }
}

/// What the host changes in a callback, flags included, stays.
#[cfg(target_arch = "x86_64")]
#[test]
fn an_environment_that_is_set_in_a_callback_is_the_hosts() {
    use crate::environment::{DEFAULT, HOSTS, present, set};

    for host in HOSTS {
        let importer = Importer::handling(Three, Handles::updates(&[LEVEL]));
        importer.start();
        importer.answer(move |_| {
            set(host);
            None
        });
        let ended = importer.step(0.0, LONGEST);
        let after = present();
        set(DEFAULT);
        assert_eq!((ended.status, after), (Ok, host));
    }
}
