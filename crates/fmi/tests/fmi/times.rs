//! Start, stop and step times of hosts, in both versions of the standard, and times in stored states.

use std::cell::RefCell;
use std::ptr::null_mut;
use std::rc::Rc;

use pushbelt_fmi::hash;
use pushbelt_fmi::log::{Category, Log, Sink, Status};
use pushbelt_fmi::slave::{CallError, Environment, Master, Next, Outcome, Type};
use pushbelt_fmi::unit::Experiment;

use crate::tank::{INFLOW, LEVEL, Tank, Valves};

type Slave = pushbelt_fmi::Slave<Tank>;

/// Seconds since 1970, some day in 2023.
const TODAY: f64 = 1.7e9;

fn experiment(start: f64, stop: Option<f64>) -> Experiment {
    Experiment {
        tolerance: None,
        start,
        stop,
    }
}

fn running(start: f64, stop: Option<f64>) -> Result<Slave, CallError> {
    let mut slave = Slave::new(None, false);
    slave.initialize(experiment(start, stop))?;
    slave.exit_initialization_mode()?;
    Ok(slave)
}

fn level(slave: &mut Slave) -> f64 {
    let mut value = [f64::NAN];
    slave.get(Type::Real, &[LEVEL], &mut value).expect("a level");
    value[0]
}

/// Levels after steps of 0.1 ms under an inflow that changes, by a host that counts time in its way.
fn levels(start: f64, mut next: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
    let mut slave = running(start, None).expect("a run");
    let mut time = start;
    let step = |k: usize| {
        slave.set(Type::Real, &[INFLOW], &[(k % 7) as f64]).expect("an inflow");
        slave
            .do_step(time, 1e-4)
            .unwrap_or_else(|error| panic!("{k}, {time}: {error}"));
        time = next(time, start + 1e-4 * (k + 1) as f64);
        level(&mut slave)
    };
    (0..3000).map(step).collect()
}

#[test]
fn a_late_run_equals_one_from_zero() {
    let expected = levels(0.0, |time, _| time + 1e-4);
    for sums in [true, false] {
        let found = levels(TODAY, |time, product| if sums { time + 1e-4 } else { product });
        let worst = found
            .iter()
            .zip(&expected)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-9, "{sums}: {worst}");
    }
}

#[test]
fn times_without_room_for_a_step_are_refused() {
    for start in [1e14, -1e14, 1e300, f64::NAN, f64::INFINITY] {
        assert!(
            Slave::new(None, false)
                .setup_experiment(experiment(start, None))
                .is_err(),
            "{start}"
        );
        assert!(running(start, None).is_err(), "{start}");
    }
    let mut slave = running(1e11, None).expect("the latest start");
    assert!(slave.do_step(1e11, 1.0).is_err(), "the end is too late");
    let mut slave = running(1e10, None).expect("a start");
    for size in [1e-300, 1e-6, 1e-5] {
        let refused = slave.do_step(1e10, size).expect_err("below the rounding").to_string();
        assert!(
            refused.contains(&format!("{size} s")) && refused.contains("10000000000 s"),
            "{refused}"
        );
    }
    slave.do_step(1e10, 1e-3).expect("some times the rounding");
    for size in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        assert!(slave.do_step(slave.time(), size).is_err(), "{size}");
    }
}

#[test]
fn an_infinite_stop_time_is_none() {
    let set_up = |start, stop| -> [Outcome; 2] {
        [Slave::setup_experiment, Slave::initialize]
            .map(|call| call(&mut Slave::new(None, false), experiment(start, Some(stop))))
    };
    let mut slave = running(-3.0, Some(f64::INFINITY)).expect("a run");
    slave.do_step(-3.0, 50.0).expect("no stop");
    let stored = slave.save().expect("a state");
    let bytes = slave.serialize(&stored).expect("bytes");
    slave.deserialize(&bytes).expect("the same state");
    for (start, stop) in [(0.0, -1.0), (0.0, f64::NEG_INFINITY), (0.0, f64::NAN), (5.0, 4.0)] {
        assert!(set_up(start, stop).iter().all(Result::is_err), "{start} to {stop}");
    }
    assert!(set_up(-2.0, -1.0).iter().all(Result::is_ok));
    assert!(set_up(0.0, f64::MAX).iter().all(Result::is_ok));
}

/// Each number of a stored state in turn is NaN, infinite or of another time.
#[test]
fn wild_numbers_in_a_stored_state_are_refused() {
    let mut slave = running(5.0, None).expect("a run");
    slave.do_step(5.0, 1.0).expect("a step");
    let stored = slave.save().expect("a state");
    let good = slave.serialize(&stored).expect("bytes");
    let head = 36;
    let content = good.len() - 16;
    let forged = |at: usize, number: f64| {
        let mut bytes = good[..content].to_vec();
        bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
        let checksum = hash::of_words(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    };
    let places = |number: f64| -> Vec<usize> {
        let is_there = |at: &usize| good[*at..at + 8] == number.to_le_bytes();
        (head..content - 7).filter(is_there).collect()
    };
    // Start, point and origin; elapsed and the tank's time; level; flow and inflow.
    for (number, count) in [(5.0, 2), (6.0, 1), (1.0, 2), (3.0, 1), (2.0, 2)] {
        assert!(places(number).len() >= count, "{number}: {:?}", places(number));
        for at in places(number) {
            for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(
                    slave.deserialize(&forged(at, wild)).is_err(),
                    "{number} at {at}: {wild}"
                );
            }
        }
    }
    for at in places(5.0).into_iter().chain(places(6.0)) {
        assert!(slave.deserialize(&forged(at, 1e14)).is_err(), "a late time at {at}");
    }
    let last = *places(1.0).last().expect("the tank's time");
    for time in [1e14, 2.0, -1.0] {
        assert!(slave.deserialize(&forged(last, time)).is_err(), "{time}");
    }
    slave.deserialize(&forged(last, 1.0)).expect("nothing has changed");
}

extern "C" fn never(_: Environment, _: f64, _: u8, _: u8, _: u8, _: u8, _: *mut u8, _: *mut f64) {}

type Messages = Rc<RefCell<Vec<String>>>;

struct MessageSink(Messages);

impl Sink for MessageSink {
    fn send(&self, _: Status, _: Category, text: &str) {
        self.0.borrow_mut().push(text.into());
    }
}

/// A master with callback has its own times in the updates, in an early return and in messages.
#[test]
fn intermediate_updates_have_the_masters_times() {
    let messages = Messages::default();
    let master = Master {
        early_return: true,
        update: Some((never, null_mut())),
        ..Master::default()
    };
    let log = Log::new(Some(Box::new(MessageSink(messages.clone()))), true);
    let mut slave = Slave::with(master, log, Valves::default());
    slave.initialize(experiment(TODAY, None)).expect("a start");
    slave.exit_initialization_mode().expect("a start");
    assert!(
        messages
            .borrow()
            .last()
            .is_some_and(|text| text.contains("start at 1700000000 s"))
    );
    let mut next = slave.begin_step(TODAY, 1.0).expect("a step");
    assert!(matches!(next, Next::Advance));
    next = slave.advance_step().expect("an internal step");
    let Next::Update(update) = next else { panic!("{next:?}") };
    assert_eq!((update.time, slave.time()), (TODAY + 0.25, TODAY + 0.25));
    slave.resume_step(Some(TODAY + 0.375)).expect("an early end");
    next = slave.advance_step().expect("an internal step");
    let Next::Update(update) = next else { panic!("{next:?}") };
    assert_eq!(update.time, TODAY + 0.375);
    next = slave.resume_step(None).expect("an end");
    let Next::Ended(ended) = next else { panic!("{next:?}") };
    assert_eq!(
        (ended.early, ended.time, slave.time()),
        (true, TODAY + 0.375, TODAY + 0.375)
    );
    slave.begin_step(TODAY + 0.375, 0.5).expect("the next step");
}
