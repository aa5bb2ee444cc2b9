//! The state machine on a toy unit, called from Rust.

use std::cell::RefCell;
use std::rc::Rc;

use pushbelt_fmi::log::{Category, Sink, Status};
use pushbelt_fmi::slave::{StatusKind, Type};
use pushbelt_fmi::state::State;
use pushbelt_fmi::unit::Experiment;
use pushbelt_fmi::{Snapshot, guid, model_description};

use crate::tank::{BRIM, BURST, GAIN, INFLOW, LEVEL, START, Tank};

/// A slave whose calls return what the C functions of FMI 2.0 return.
struct Slave(pushbelt_fmi::Slave<Tank>);

macro_rules! calls {
    ($($function:literal $name:ident($($argument:ident: $type:ty),*);)*) => {
        impl Slave {
            $(fn $name(&mut self, $($argument: $type),*) -> Status {
                self.0.call($function, |slave| slave.$name($($argument),*))
            })*
        }
    };
}

calls! {
    "fmi2SetDebugLogging" set_debug_logging(on: bool, categories: &[&str]);
    "fmi2SetupExperiment" setup_experiment(experiment: Experiment);
    "fmi2EnterInitializationMode" enter_initialization_mode();
    "fmi2ExitInitializationMode" exit_initialization_mode();
    "fmi2Terminate" terminate();
    "fmi2Reset" reset();
    "fmi2SetRealInputDerivatives" set_input_derivatives(references: &[u32], orders: &[i32], values: &[f64]);
    "fmi2GetRealOutputDerivatives" get_output_derivatives(references: &[u32], orders: &[i32], values: &mut [f64]);
    "fmi2DoStep" do_step(current: f64, step: f64);
    "fmi2CancelStep" cancel_step();
    "fmi2SetFMUstate" restore(snapshot: &Snapshot<Tank>);
}

impl Slave {
    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status {
        self.0
            .call("fmi2GetReal", |slave| slave.get(Type::Real, references, values))
    }

    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        self.0
            .call("fmi2SetReal", |slave| slave.set(Type::Real, references, values))
    }

    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.0.call("fmi2GetInteger", |slave| {
            slave.get(Type::IntegerOrEnumeration, references, values)
        })
    }

    /// A call with a result; the result only if it was done.
    fn result<T>(
        &mut self,
        call: impl FnOnce(&mut pushbelt_fmi::Slave<Tank>) -> Result<T, pushbelt_fmi::slave::CallError>,
    ) -> (Status, Option<T>) {
        let mut found = None;
        let status = self.0.call("call", |slave| {
            found = Some(call(slave)?);
            Ok(())
        });
        (status, found)
    }

    fn save(&mut self) -> (Status, Option<Snapshot<Tank>>) {
        self.result(pushbelt_fmi::Slave::save)
    }

    fn serialize(&mut self, snapshot: &Snapshot<Tank>) -> (Status, Option<Vec<u8>>) {
        self.result(|slave| slave.serialize(snapshot))
    }

    fn deserialize(&mut self, bytes: &[u8]) -> (Status, Option<Snapshot<Tank>>) {
        self.result(|slave| slave.deserialize(bytes))
    }

    fn last_successful_time(&mut self) -> (Status, Option<f64>) {
        self.result(|slave| slave.last_successful_time(StatusKind::LastSuccessfulTime as i32))
    }

    fn state(&self) -> State {
        self.0.state()
    }
}

type Messages = Rc<RefCell<Vec<(Status, Category, String)>>>;

struct MessageSink(Messages);

impl Sink for MessageSink {
    fn send(&self, status: Status, category: Category, text: &str) {
        self.0.borrow_mut().push((status, category, text.into()));
    }
}

fn slave() -> (Slave, Messages) {
    let messages = Messages::default();
    (
        Slave(pushbelt_fmi::Slave::new(
            Some(Box::new(MessageSink(messages.clone()))),
            false,
        )),
        messages,
    )
}

/// A slave in step mode at 0 s.
fn running() -> (Slave, Messages) {
    let (mut slave, messages) = slave();
    assert_eq!(slave.enter_initialization_mode(), Status::Ok);
    assert_eq!(slave.exit_initialization_mode(), Status::Ok);
    (slave, messages)
}

fn level(slave: &mut Slave) -> f64 {
    let mut value = [f64::NAN];
    assert_eq!(slave.get_real(&[LEVEL], &mut value), Status::Ok);
    value[0]
}

fn last(messages: &Messages) -> String {
    messages.borrow().last().expect("a message").2.clone()
}

#[test]
fn a_run_goes_through_its_states() {
    let (mut slave, messages) = slave();
    assert_eq!(slave.state(), State::Instantiated);
    assert_eq!(
        slave.setup_experiment(Experiment {
            tolerance: None,
            start: 3.0,
            stop: Some(5.0)
        }),
        Status::Ok
    );
    assert_eq!(slave.enter_initialization_mode(), Status::Ok);
    assert_eq!(level(&mut slave), 1.0);
    assert_eq!(slave.set_real(&[START], &[4.0]), Status::Ok);
    assert_eq!(
        level(&mut slave),
        4.0,
        "set again in initialization mode, it starts again"
    );
    assert_eq!(slave.exit_initialization_mode(), Status::Ok);
    assert_eq!(slave.do_step(3.0, 1.0), Status::Ok);
    assert_eq!(level(&mut slave), 6.0);
    assert_eq!(slave.do_step(4.0, 1.0), Status::Ok);
    assert_eq!(slave.do_step(5.0, 1.0), Status::Error);
    assert!(last(&messages).contains("stop time 5 s"), "{}", last(&messages));
    assert_eq!(slave.terminate(), Status::Ok);
    assert_eq!(level(&mut slave), 8.0, "last values can be read after the end");
    assert_eq!(slave.reset(), Status::Ok);
    assert_eq!(slave.state(), State::Instantiated);
}

#[test]
fn settings_read_back_as_set() {
    let (mut slave, _) = slave();
    assert_eq!(slave.set_real(&[START, INFLOW], &[7.0, 8.0]), Status::Ok);
    slave.enter_initialization_mode();
    let mut values = [0.0; 3];
    assert_eq!(slave.get_real(&[START, INFLOW, GAIN], &mut values), Status::Ok);
    assert_eq!(values, [7.0, 8.0, 1.0]);
}

#[test]
fn calls_in_the_wrong_state_are_refused_and_change_nothing() {
    let (mut slave, messages) = slave();
    assert_eq!(slave.do_step(0.0, 1.0), Status::Error);
    assert_eq!(
        last(&messages),
        "fmi2DoStep: not allowed while the instance is instantiated"
    );
    assert_eq!(slave.exit_initialization_mode(), Status::Error);
    assert_eq!(slave.terminate(), Status::Error);
    assert_eq!(slave.cancel_step(), Status::Error);
    assert_eq!(slave.get_real(&[LEVEL], &mut [0.0]), Status::Error);
    assert_eq!(slave.last_successful_time().0, Status::Error);
    assert_eq!(slave.state(), State::Instantiated);

    let (mut slave, messages) = running();
    assert_eq!(slave.enter_initialization_mode(), Status::Error);
    assert_eq!(slave.setup_experiment(Experiment::default()), Status::Error);
    assert_eq!(slave.set_real(&[START], &[1.0]), Status::Error);
    assert!(last(&messages).contains("start is fixed"), "{}", last(&messages));
    assert_eq!(slave.set_real(&[LEVEL], &[1.0]), Status::Error);
    assert!(last(&messages).contains("level is calculated"), "{}", last(&messages));
    assert_eq!(slave.set_real(&[99], &[1.0]), Status::Error);
    assert!(last(&messages).contains("value reference 99"), "{}", last(&messages));
    assert_eq!(slave.get_integer(&[LEVEL], &mut [0]), Status::Error);
    assert!(last(&messages).contains("another type"), "{}", last(&messages));
    assert_eq!(slave.state(), State::StepComplete);
    assert_eq!(slave.do_step(0.0, 1.0), Status::Ok);
}

#[test]
fn a_bad_value_is_discarded_and_nothing_changes() {
    let (mut other, _) = running();
    assert_eq!(other.do_step(0.0, 1.0), Status::Ok);
    for bad in [f64::NAN, f64::INFINITY, -1e4] {
        let (mut slave, messages) = running();
        assert_eq!(slave.set_real(&[BRIM, INFLOW], &[5.0, bad]), Status::Discard);
        assert!(
            last(&messages).contains(&format!("inflow = {bad}")),
            "{}",
            last(&messages)
        );
        assert_eq!(slave.state(), State::StepComplete);
        let mut values = [0.0; 2];
        assert_eq!(slave.get_real(&[BRIM, INFLOW], &mut values), Status::Ok);
        assert_eq!(values, [1e9, 2.0]);
        assert_eq!(slave.do_step(0.0, 1.0), Status::Ok, "the run goes on");
        assert_eq!(level(&mut slave), level(&mut other));
    }
}

#[test]
fn messages_name_the_range() {
    let (mut slave, messages) = running();
    slave.set_real(&[GAIN], &[11.0]);
    assert_eq!(last(&messages), "fmi2SetReal: gain = 11 is out of range: -1000 to 10");
    let (mut slave, messages) = running();
    slave.set_real(&[INFLOW], &[-1001.0]);
    assert_eq!(
        last(&messages),
        "fmi2SetReal: inflow = -1001 is out of range: at least -1000"
    );
}

#[test]
fn a_tunable_parameter_is_checked_against_the_others_at_once() {
    let (mut slave, messages) = running();
    assert_eq!(slave.set_real(&[GAIN], &[3.0]), Status::Ok);
    assert_eq!(slave.do_step(0.0, 1.0), Status::Ok);
    assert_eq!(level(&mut slave), 7.0);
    assert_eq!(slave.set_real(&[GAIN], &[0.5]), Status::Discard);
    assert!(last(&messages).contains("does not fit"));
    let mut gain = [0.0];
    slave.get_real(&[GAIN], &mut gain);
    assert_eq!(gain, [3.0]);
    assert_eq!(slave.do_step(1.0, 1.0), Status::Ok, "the run goes on");
}

#[test]
fn times_are_compared_with_tolerance() {
    let (mut slave, _) = running();
    let mut time = 0.0;
    for _ in 0..10 {
        assert_eq!(slave.do_step(time, 0.1), Status::Ok);
        time += 0.1;
    }
    assert_ne!(time, 1.0, "the sum is not exact, which is why");
    assert_eq!(slave.do_step(1.0, 0.1), Status::Ok);
    for wrong in [1.0, 1.2, 1.1 + 1e-4, f64::NAN, f64::INFINITY] {
        assert_eq!(slave.do_step(wrong, 0.1), Status::Error, "{wrong}");
    }
    for wrong in [0.0, -0.1, 101.0, 1e-30, f64::NAN, f64::INFINITY] {
        assert_eq!(slave.do_step(1.1, wrong), Status::Error, "{wrong}");
    }
    assert_eq!(slave.do_step(1.1, 0.1), Status::Ok, "refused steps change nothing");
}

#[test]
fn late_times_keep_small_steps_apart() {
    let (mut slave, _) = slave();
    slave.setup_experiment(Experiment {
        tolerance: None,
        start: 1e6,
        stop: None,
    });
    slave.enter_initialization_mode();
    slave.exit_initialization_mode();
    assert_eq!(slave.do_step(1e6, 1e-3), Status::Ok);
    assert_eq!(slave.do_step(1e6, 1e-3), Status::Error, "this step has been done");
    assert_eq!(slave.do_step(1e6 + 1e-3, 1e-3), Status::Ok);
}

#[test]
fn after_a_discarded_step_all_is_as_before_and_the_step_can_be_repeated() {
    let (mut slave, messages) = running();
    slave.set_real(&[BRIM], &[2.0]);
    assert_eq!(slave.do_step(0.0, 1.0), Status::Discard);
    assert_eq!(messages.borrow().last().map(|m| m.1), Some(Category::Discard));
    assert_eq!(slave.last_successful_time(), (Status::Ok, Some(0.0)));
    assert_eq!(level(&mut slave), 1.0);
    let step = slave.result(|slave| slave.step_status(StatusKind::DoStep as i32));
    assert_eq!(step, (Status::Ok, Some(Status::Discard)));
    let ended = slave.result(|slave| slave.requests_termination(StatusKind::Terminated as i32));
    assert_eq!(ended, (Status::Ok, Some(false)));
    let pending = slave.result(|slave| slave.no_status(StatusKind::Pending as i32));
    assert_eq!(pending.0, Status::Discard);
    assert_eq!(slave.set_real(&[BRIM], &[100.0]), Status::Ok);
    assert_eq!(slave.do_step(0.0, 1.0), Status::Ok);
    assert_eq!(level(&mut slave), 3.0);
}

#[test]
fn a_discarded_step_can_be_repeated_smaller_from_a_stored_state() {
    let (mut slave, _) = running();
    slave.set_real(&[BRIM], &[2.0]);
    let stored = slave.save().1.expect("stored");
    assert_eq!(slave.do_step(0.0, 1.0), Status::Discard);
    assert_eq!(slave.restore(&stored), Status::Ok);
    assert_eq!(slave.do_step(0.0, 0.25), Status::Ok);
    assert_eq!(level(&mut slave), 1.5);
}

#[test]
fn a_stored_state_holds_everything_and_fits_another_instance() {
    let (mut slave, _) = running();
    slave.set_real(&[GAIN], &[2.0]);
    slave.do_step(0.0, 1.0);
    let stored = slave.save().1.expect("stored");
    slave.set_real(&[GAIN, INFLOW], &[9.0, 9.0]);
    slave.do_step(1.0, 1.0);
    let (mut other, _) = self::slave();
    for slave in [&mut slave, &mut other] {
        assert_eq!(slave.restore(&stored), Status::Ok);
        let mut values = [0.0; 3];
        assert_eq!(slave.get_real(&[GAIN, INFLOW, LEVEL], &mut values), Status::Ok);
        assert_eq!(values, [2.0, 2.0, 5.0]);
        assert_eq!(slave.do_step(1.0, 1.0), Status::Ok);
        assert_eq!(level(slave), 9.0);
    }
}

#[test]
fn bytes_hold_everything_and_fit_another_instance() {
    let (mut slave, _) = running();
    slave.set_real(&[GAIN], &[2.0]);
    slave.do_step(0.0, 1.0);
    assert_eq!(slave.set_input_derivatives(&[INFLOW], &[1], &[1.0]), Status::Ok);
    let stored = slave.save().1.expect("stored");
    let bytes = slave.serialize(&stored).1.expect("bytes");
    let (mut other, messages) = self::slave();
    let (status, found) = other.deserialize(&bytes);
    assert_eq!(status, Status::Ok, "{messages:?}");
    assert_eq!(other.restore(&found.expect("a state")), Status::Ok);
    for slave in [&mut slave, &mut other] {
        assert_eq!(slave.do_step(1.0, 1.0), Status::Ok);
        assert_eq!(level(slave), 10.0);
    }
    let (status, found) = other.deserialize(&bytes[1..]);
    assert_eq!((status, found.is_none()), (Status::Error, true));
    assert!(last(&messages).contains("not a stored state"), "{}", last(&messages));
}

#[test]
fn the_stop_time_of_the_instance_counts_not_that_of_a_stored_state() {
    let experiment = |stop| Experiment {
        stop,
        ..Experiment::default()
    };
    let (mut slave, _) = slave();
    assert_eq!(slave.setup_experiment(experiment(Some(1.0))), Status::Ok);
    slave.enter_initialization_mode();
    slave.exit_initialization_mode();
    assert_eq!(slave.do_step(0.0, 1.0), Status::Ok);
    let stored = slave.save().1.expect("stored");
    let bytes = slave.serialize(&stored).1.expect("bytes");

    let (mut other, messages) = self::slave();
    assert_eq!(other.setup_experiment(experiment(Some(2.0))), Status::Ok);
    let found = other.deserialize(&bytes).1.expect("a state");
    for state in [&stored, &found] {
        assert_eq!(other.restore(state), Status::Ok);
        assert_eq!(other.do_step(1.0, 1.0), Status::Ok, "{messages:?}");
        assert_eq!(other.do_step(2.0, 1.0), Status::Error);
        assert!(last(&messages).contains("stop time 2 s"), "{}", last(&messages));
    }
    // The host goes straight from instantiation to the stored state: no stop time.
    let (mut fresh, messages) = self::slave();
    assert_eq!(fresh.restore(&found), Status::Ok);
    let again = fresh.save().1.expect("stored");
    assert!(fresh.serialize(&again).1 == Some(bytes), "stored again bit for bit");
    assert_eq!(fresh.do_step(1.0, 5.0), Status::Ok, "{messages:?}");
    // A stop time of an instance holds for a state of an earlier run too.
    assert_eq!(slave.reset(), Status::Ok);
    assert_eq!(slave.setup_experiment(experiment(Some(3.0))), Status::Ok);
    assert_eq!(slave.restore(&stored), Status::Ok);
    assert_eq!(slave.do_step(1.0, 2.0), Status::Ok);
    assert_eq!(slave.do_step(3.0, 1.0), Status::Error);
}

#[test]
fn input_derivatives_last_for_one_step() {
    let (mut slave, _) = running();
    assert_eq!(slave.set_input_derivatives(&[INFLOW], &[1], &[1.0]), Status::Ok);
    assert_eq!(slave.do_step(0.0, 1.0), Status::Ok);
    assert_eq!(level(&mut slave), 3.5, "2 + 1/2");
    let mut flow = [f64::NAN];
    assert_eq!(slave.get_output_derivatives(&[LEVEL], &[1], &mut flow), Status::Ok);
    assert_eq!(flow, [3.0], "at the end of the step");
    let mut inflow = [f64::NAN];
    assert_eq!(slave.get_real(&[INFLOW], &mut inflow), Status::Ok);
    assert_eq!(inflow, [2.0], "an input reads back what was set");
    assert_eq!(slave.do_step(1.0, 1.0), Status::Ok);
    assert_eq!(level(&mut slave), 5.5);
}

#[test]
fn derivatives_are_allowed_where_the_standard_says() {
    let (mut slave, _) = slave();
    assert_eq!(
        slave.set_input_derivatives(&[INFLOW], &[1], &[1.0]),
        Status::Ok,
        "instantiated"
    );
    assert_eq!(slave.get_output_derivatives(&[LEVEL], &[1], &mut [0.0]), Status::Error);
    slave.enter_initialization_mode();
    assert_eq!(
        slave.set_input_derivatives(&[INFLOW], &[1], &[1.0]),
        Status::Ok,
        "initialising"
    );
    assert_eq!(slave.get_output_derivatives(&[LEVEL], &[1], &mut [0.0]), Status::Error);
    slave.exit_initialization_mode();
    assert_eq!(slave.get_output_derivatives(&[LEVEL], &[1], &mut [0.0]), Status::Ok);
    slave.terminate();
    assert_eq!(
        slave.get_output_derivatives(&[LEVEL], &[1], &mut [0.0]),
        Status::Ok,
        "terminated"
    );
    assert_eq!(slave.set_input_derivatives(&[INFLOW], &[1], &[1.0]), Status::Error);
}

#[test]
fn a_panic_fails_its_own_instance_only() {
    let ((mut broken, messages), (mut sound, _)) = (running(), running());
    let stored = broken.save().1.expect("stored");
    broken.set_real(&[INFLOW], &[BURST]);
    assert_eq!(broken.do_step(0.0, 1.0), Status::Error);
    assert_eq!(
        last(&messages),
        "fmi2DoStep: internal error, please report: the tank burst"
    );
    assert_eq!(broken.state(), State::Error);
    assert_eq!(broken.get_real(&[LEVEL], &mut [0.0]), Status::Error);
    assert_eq!(sound.do_step(0.0, 1.0), Status::Ok);
    assert_eq!(broken.restore(&stored), Status::Ok);
    assert_eq!(broken.do_step(0.0, 1.0), Status::Ok);
    assert_eq!(broken.reset(), Status::Ok);
    assert_eq!(broken.enter_initialization_mode(), Status::Ok);
}

#[test]
fn a_start_that_fails_can_be_tried_again_after_reset() {
    let (mut slave, messages) = slave();
    assert_eq!(slave.set_real(&[GAIN], &[0.5]), Status::Ok, "checked as a whole later");
    assert_eq!(slave.enter_initialization_mode(), Status::Ok);
    assert_eq!(slave.exit_initialization_mode(), Status::Error);
    assert_eq!(last(&messages), "fmi2ExitInitializationMode: gain = 0.5 does not fit");
    assert_eq!(slave.state(), State::Error);
    assert_eq!(slave.get_real(&[LEVEL], &mut [0.0]), Status::Error);
    slave.reset();
    slave.enter_initialization_mode();
    assert_eq!(slave.exit_initialization_mode(), Status::Ok);
}

#[test]
fn invalid_experiments_are_refused() {
    let (mut slave, _) = slave();
    let good = Experiment {
        tolerance: Some(1e-4),
        start: 1.0,
        stop: Some(2.0),
    };
    for bad in [
        Experiment {
            start: f64::NAN,
            ..good
        },
        Experiment {
            stop: Some(0.5),
            ..good
        },
        Experiment {
            stop: Some(f64::NAN),
            ..good
        },
        Experiment {
            stop: Some(f64::NEG_INFINITY),
            ..good
        },
        Experiment {
            start: 1e14,
            stop: None,
            ..good
        },
        Experiment {
            tolerance: Some(0.0),
            ..good
        },
        Experiment {
            tolerance: Some(f64::NAN),
            ..good
        },
    ] {
        assert_eq!(slave.setup_experiment(bad), Status::Error, "{bad:?}");
    }
    assert_eq!(slave.setup_experiment(good), Status::Ok);
}

#[test]
fn errors_and_warnings_are_logged_always_and_the_rest_on_request() {
    let (mut slave, messages) = slave();
    slave.enter_initialization_mode();
    slave.set_real(&[START], &[6.0]);
    slave.exit_initialization_mode();
    assert_eq!(messages.borrow().last().map(|m| m.1), Some(Category::Warning));
    slave.reset();
    messages.borrow_mut().clear();
    slave.enter_initialization_mode();
    slave.exit_initialization_mode();
    assert!(
        messages.borrow().is_empty(),
        "events are not logged without debug logging"
    );

    slave.reset();
    assert_eq!(slave.set_debug_logging(true, &["logEvents"]), Status::Ok);
    slave.enter_initialization_mode();
    slave.exit_initialization_mode();
    assert_eq!(last(&messages), "filled to 100%s 1");
    assert_eq!(slave.set_debug_logging(true, &["noise"]), Status::Error);
    assert!(last(&messages).contains("logEvents"), "{}", last(&messages));
    assert_eq!(slave.set_debug_logging(true, &["logAll"]), Status::Ok);
    assert_eq!(slave.set_debug_logging(true, &[]), Status::Ok);
}

#[test]
fn the_description_contains_the_guid() {
    assert!(model_description::<Tank>().contains(&guid::<Tank>()));
}

/// The unit steps to the same times, bit for bit, however a master sums up its steps.
#[test]
fn sums_and_products_of_steps_give_the_same_times() {
    for size in [1e-3, 1e-2 / 3.0, 0.25, 7e-6] {
        let ((mut sums, _), (mut products, _)) = (running(), running());
        let mut time = 0.0;
        for k in 0..1000 {
            assert_eq!(sums.do_step(time, size), Status::Ok, "{size}, {k}");
            let product = f64::from(k) * size;
            assert_eq!(products.do_step(product, f64::from(k + 1) * size - product), Status::Ok);
            let reached = [level(&mut sums), level(&mut products)];
            assert_eq!(reached[0].to_bits(), reached[1].to_bits(), "{size}, {k}");
            assert!((reached[0] - 1.0 - 2.0 * (product + size)).abs() < 1e-5 * size + 1e-9);
            time += size;
        }
    }
}

#[test]
fn a_short_step_can_follow_a_long_one() {
    let (mut slave, _) = running();
    let mut time = 0.0;
    for size in [0.123_456_789_123, 1e-5, 1e-8, 1.0 / 3.0, 1e-10, 1e-7] {
        assert_eq!(slave.do_step(time, size), Status::Ok, "{size}");
        time += size;
        assert_eq!(slave.last_successful_time().1, Some(time));
    }
    assert!((level(&mut slave) - 1.0 - 2.0 * time).abs() < 1e-6);
}
