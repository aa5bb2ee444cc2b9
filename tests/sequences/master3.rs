//! A master of FMI 3.0 that makes calls and compares the instance with a model of the standard's state machine (its sections 2.3
//! and 4.2; a refused call leaves the instance unchanged).

use std::cell::Cell;
use std::ffi::{c_char, c_int};
use std::ptr::{null, null_mut};

use pushbelt::fmi::Unit;
use pushbelt::fmi::fmi3::{Boolean, Environment, Instance};
use pushbelt::fmi::table::Kind;
use pushbelt::unit::VariatorUnit;
use pushbelt_lab::shared_library::{DISCARD, ERROR, OK, reference};
use pushbelt_lab::shared_library3::{Functions3, Watches};

use crate::calls::{Flaw, INPUTS, INTEGERS, PARAMETERS, TUNABLE, UNKNOWN};
use crate::calls3::{Answer, Call};
use crate::machine::{Expected, Model, Stage, is_experiment};
use crate::slots::Slots;

/// States of the standard's state machine that last between calls.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Initialisation,
    Step,
    Event,
    Terminated,
    Error,
}

use State::{Error, Event, Initialisation, Instantiated, Step, Terminated};

const BEFORE: &[State] = &[Instantiated, Initialisation];
const SET: &[State] = &[Instantiated, Initialisation, Step, Event];
/// Readings; settings can be read in `Instantiated` too.
const GET: &[State] = &[Initialisation, Step, Event, Terminated, Error];
const GET_SETTING: &[State] = &[Instantiated, Initialisation, Step, Event, Terminated, Error];
const RUNNING: &[State] = &[Step, Event];
const DERIVATIVES: &[State] = &[Step, Event, Terminated, Error];
const ANY: &[State] = GET_SETTING;

impl Stage for State {
    const INSTANTIATED: Self = Instantiated;
    const ERROR: Self = Error;
}

/// A real variable or array: its reference, its number of values, whether it is a setting.
#[derive(Clone, Copy, Debug)]
pub struct Real {
    reference: u32,
    size: usize,
    setting: bool,
}

/// All of them.
pub fn reals() -> Vec<Real> {
    let table = VariatorUnit::table();
    let variables = table.variables().iter();
    let real = variables.filter(|variable| matches!(variable.kind, Kind::Real { .. }));
    real.filter_map(|variable| {
        let size = match table.array_of(variable.reference) {
            None => 1,
            Some(array) if array.first == variable.reference => usize::try_from(array.size).expect("72"),
            Some(_) => return None,
        };
        Some(Real {
            reference: variable.reference,
            size,
            setting: variable.causality.is_setting(),
        })
    })
    .collect()
}

/// Data of the callback, and its observations.
struct Watcher {
    f: Functions3,
    c: Instance,
    answer: Answer,
    last: f64,
    asked: bool,
    declined: bool,
}

unsafe extern "C" fn update(
    environment: Environment,
    time: f64,
    set: Boolean,
    get: Boolean,
    finished: Boolean,
    can_return: Boolean,
    requested: *mut Boolean,
    until: *mut f64,
) {
    // SAFETY: the environment is the `Watcher` of the instance that calls, and nobody else uses it meanwhile; the places are
    // those of the unit.
    unsafe {
        let watcher = &mut *environment.cast::<Watcher>();
        let Watcher { f, c, answer, .. } = *watcher;
        assert!((get, finished) == (1, 1) && time >= watcher.last);
        watcher.last = time;
        let (torque, speed, mut value) = (reference("primary.torque"), reference("primary.speed"), f64::NAN);
        assert_eq!((f.fmi3GetFloat64)(c, &speed, 1, &raw mut value, 1), OK);
        assert!(value.is_finite());
        match answer {
            Answer::Nothing => {}
            Answer::Set(input) => {
                let status = (f.fmi3SetFloat64)(c, &torque, 1, &input, 1);
                let wanted = match (set == 1, input.is_finite()) {
                    (true, true) => OK,
                    (true, false) => DISCARD,
                    _ => ERROR,
                };
                assert_eq!(status, wanted);
                watcher.declined |= status == DISCARD;
            }
            Answer::Return(later) => {
                requested.write(1);
                until.write(time + later);
                watcher.asked |= can_return == 1;
            }
            Answer::Meddle => {
                let other = reference("belt.speed");
                let (mut state, mut size) = (null_mut(), 0);
                assert_eq!((f.fmi3GetFloat64)(c, &other, 1, &raw mut value, 1), ERROR);
                assert_eq!((f.fmi3SetFloat64)(c, &reference("secondary.torque"), 1, &1.0, 1), ERROR);
                assert_eq!((f.fmi3Reset)(c), ERROR);
                assert_eq!((f.fmi3EnterEventMode)(c), ERROR);
                assert_eq!((f.fmi3Terminate)(c), ERROR);
                assert_eq!((f.fmi3GetFMUState)(c, &raw mut state), ERROR);
                assert_eq!((f.fmi3SerializedFMUStateSize)(c, null_mut(), &raw mut size), ERROR);
                assert_eq!(f.step(c, time, 1e-3).status, ERROR);
                (f.fmi3FreeInstance)(c);
            }
        }
    }
}

/// Counts of situations in the sequences, so that a test can require each of them.
#[derive(Debug, Default)]
pub struct Seen {
    pub events: Cell<u32>,
    pub asked: Cell<u32>,
    pub declined: Cell<u32>,
    pub discarded: Cell<u32>,
}

fn count(seen: &Cell<u32>, when: bool) {
    seen.set(seen.get() + u32::from(when));
}

pub struct Master<'a> {
    f: &'a Functions3,
    seen: &'a Seen,
    c: Instance,
    /// From a box that is freed when the master is dropped.
    watcher: *mut Watcher,
    watches: Watches,
    cheap: bool,
    model: Model<State>,
    slots: Slots<Model<State>>,
    outputs: &'a [u32],
    reals: &'a [Real],
}

impl Drop for Master<'_> {
    fn drop(&mut self) {
        // SAFETY: instance and watcher are not used any more.
        unsafe {
            self.slots.free_all(self.f, self.c);
            (self.f.fmi3FreeInstance)(self.c);
            drop(Box::from_raw(self.watcher));
        }
    }
}

impl<'a> Master<'a> {
    /// A master of a new instance; `modes`: whether it handles events, early returns and updates.
    pub fn new(
        f: &'a Functions3,
        seen: &'a Seen,
        cheap: bool,
        modes: [bool; 3],
        (outputs, reals): (&'a [u32], &'a [Real]),
    ) -> Self {
        let watcher = Box::into_raw(Box::new(Watcher {
            f: *f,
            c: null_mut(),
            answer: Answer::Nothing,
            last: 0.0,
            asked: false,
            declined: false,
        }));
        let [events, early_return, updates] = modes;
        let watches = Watches {
            events,
            early_return,
            update: updates.then_some((update, watcher.cast())),
        };
        let c = f.instantiate(watches);
        // SAFETY: the watcher is used by the callback only, and none is under way.
        unsafe { (*watcher).c = c };
        let mut master = Self {
            f,
            seen,
            c,
            watcher,
            watches,
            cheap,
            model: Model::FRESH,
            slots: Slots::empty(),
            outputs,
            reals,
        };
        master.after_reset();
        master
    }

    fn after_reset(&mut self) {
        self.model = Model::FRESH;
        if self.cheap {
            // SAFETY: an instance.
            unsafe { self.f.make_cheap(self.c) };
        }
    }

    /// Makes a call and compares its result with the model.
    pub fn make(&mut self, call: &Call) {
        let (f, c) = (self.f, self.c);
        // SAFETY: an instance; calls with arguments are below.
        unsafe {
            match *call {
                Call::EnterInitialization { tolerance, start, stop } => self.initialize(call, tolerance, start, stop),
                Call::ExitInitialization => {
                    let to = if self.watches.events { Event } else { Step };
                    let status = (f.fmi3ExitInitializationMode)(c);
                    self.model.moves(call, status, &[Initialisation], to);
                }
                Call::EnterEvent => {
                    let from: &[State] = if self.watches.events { &[Step] } else { &[] };
                    let status = (f.fmi3EnterEventMode)(c);
                    self.model.moves(call, status, from, Event);
                }
                Call::UpdateDiscrete { null } => self.update_discrete(call, null),
                Call::EnterStep => {
                    let status = (f.fmi3EnterStepMode)(c);
                    self.model.moves(call, status, &[Event], Step);
                }
                Call::Terminate => {
                    let status = (f.fmi3Terminate)(c);
                    self.model.moves(call, status, RUNNING, Terminated);
                }
                Call::Reset => {
                    assert_eq!((f.fmi3Reset)(c), OK);
                    self.after_reset();
                }
                Call::Step { late, size, answer } => self.step(call, late, size, answer),
                Call::SetInput { which, value, flaw } => {
                    let (name, middle, width) = INPUTS[which];
                    self.set_real(call, reference(name), middle + value * width, flaw, SET);
                }
                Call::SetParameter { which, share, flaw } => {
                    let (name, low, high) = PARAMETERS[which];
                    let states = if which < TUNABLE { SET } else { BEFORE };
                    self.set_real(call, reference(name), low + share * (high - low), flaw, states);
                }
                Call::SetOutput => {
                    let status = (f.fmi3SetFloat64)(c, &reference("thrustRatio"), 1, &1.0, 1);
                    self.model.expect(call, status, ANY, Expected::Refused);
                }
                Call::GetReals { ref which, flaw, more } => self.get_reals(call, which, flaw, more),
                Call::SetInteger { which, value } => self.set_integer(call, INTEGERS[which], value),
                Call::Choice { set, value } => self.choice(call, set, value),
                Call::Boolean { set, flaw } => self.boolean(call, set, flaw),
                Call::NoSuchType { function, length } => self.no_such_type(call, function, length),
                Call::OutputDerivative { which, order, null } => self.output_derivative(call, which, order, null),
                Call::NotOffered { function } => self.not_offered(call, function),
                Call::Logging { on, name } => self.logging(call, on, name),
                Call::Keep(keeping) => {
                    let kept = self.slots.keep(f, c, keeping, self.model);
                    self.model = kept.in_instance_of(&self.model);
                }
                Call::NullInstance => {
                    (f.fmi3FreeInstance)(null_mut());
                    assert_eq!(f.step(null_mut(), 0.0, 1e-3).status, ERROR);
                    let mut value = 0.0;
                    assert_eq!((f.fmi3GetFloat64)(null_mut(), &1, 1, &raw mut value, 1), ERROR);
                }
            }
        }
    }

    fn initialize(&mut self, call: &Call, tolerance: Option<f64>, start: f64, stop: Option<f64>) {
        // SAFETY: an instance.
        let status = unsafe {
            (self.f.fmi3EnterInitializationMode)(
                self.c,
                tolerance.is_some().into(),
                tolerance.unwrap_or(f64::NAN),
                start,
                stop.is_some().into(),
                stop.unwrap_or(f64::NAN),
            )
        };
        let good = is_experiment(tolerance, start, stop);
        self.model
            .expect(call, status, &[Instantiated], Expected::done_if(good));
        if status == OK {
            self.model = Model {
                state: Initialisation,
                time: start,
                stop,
            };
        }
    }

    fn update_discrete(&mut self, call: &Call, null: bool) {
        let (mut flags, mut time) = ([9; 5], f64::NAN);
        let [mut a, b, c, d, e] = flags.each_mut().map(std::ptr::from_mut);
        if null {
            a = null_mut();
        }
        // SAFETY: an instance, and a place for each result or null.
        let status = unsafe { (self.f.fmi3UpdateDiscreteStates)(self.c, a, b, c, d, e, &raw mut time) };
        self.model.expect(call, status, &[Event], Expected::done_if(!null));
        if status == OK {
            assert_eq!((flags, time), ([0; 5], 0.0));
        }
    }

    fn step(&mut self, call: &Call, late: f64, size: f64, answer: Answer) {
        let from = self.model.time + late;
        let to = from + size;
        // SAFETY: the watcher is used by the callback only, and none is under way.
        unsafe {
            let watcher = &mut *self.watcher;
            (watcher.answer, watcher.last) = (answer, f64::NEG_INFINITY);
            (watcher.asked, watcher.declined) = (false, false);
        }
        // SAFETY: an instance.
        let ended = unsafe { self.f.step(self.c, from, size) };
        // SAFETY: as above.
        let (asked, declined) = unsafe { ((*self.watcher).asked, (*self.watcher).declined) };
        let good = late == 0.0
            && (0.0..1e3).contains(&size)
            && to > from
            && self.model.stop.is_none_or(|stop| to <= stop + 1e-6 * size);
        if good && ended.status == DISCARD && self.model.state == Step {
            assert_eq!(ended.time, self.model.time, "{ended:?} after {call:?}");
            count(&self.seen.discarded, true);
            return;
        }
        count(&self.seen.declined, declined);
        self.model.expect(call, ended.status, &[Step], Expected::done_if(good));
        if ended.status != OK {
            return;
        }
        let (event, early) = (ended.event == 1, ended.early == 1);
        assert!(!event || self.watches.events, "{ended:?}");
        assert!(
            !early || self.watches.early_return && (event || asked),
            "{ended:?} after {call:?}"
        );
        if early {
            assert!(ended.time > from && ended.time < to, "{ended:?} after {call:?}");
        } else {
            assert_eq!(ended.time, to);
        }
        count(&self.seen.events, event);
        count(&self.seen.asked, early && asked);
        self.model.time = ended.time;
    }

    fn get_reals(&mut self, call: &Call, which: &[usize], flaw: Flaw, more: isize) {
        let wanted: Vec<Real> = which.iter().map(|which| self.reals[which % self.reals.len()]).collect();
        let mut references: Vec<u32> = wanted.iter().map(|real| real.reference).collect();
        let mut size: usize = wanted.iter().map(|real| real.size).sum();
        match flaw {
            Flaw::UnknownReference => references.push(UNKNOWN),
            Flaw::OtherType => references.push(reference("macroSlip")),
            _ => {}
        }
        size += references.len() - wanted.len();
        let count = size.saturating_add_signed(more);
        let mut values = vec![f64::NAN; count];
        let (from, to) = flaw.pointers(references.as_ptr(), values.as_mut_ptr());
        // SAFETY: an instance; arrays have the given lengths, or are null.
        let status = unsafe { (self.f.fmi3GetFloat64)(self.c, from, references.len(), to, count) };
        let usable = match flaw {
            Flaw::NullReferences => references.is_empty(),
            Flaw::NullValues => count == 0,
            _ => flaw.harmless(),
        };
        let settings = wanted.iter().all(|real| real.setting);
        let states = if settings { GET_SETTING } else { GET };
        self.model
            .expect(call, status, states, Expected::done_if(usable && count == size));
        if status == OK {
            assert!(values.iter().all(|value| value.is_finite()), "{call:?}: {values:?}");
        }
    }

    fn set_real(&mut self, call: &Call, wanted: u32, value: f64, flaw: Flaw, states: &[State]) {
        let (mut references, mut values) = (vec![wanted], vec![value]);
        match flaw {
            Flaw::UnknownReference => references.push(UNKNOWN),
            Flaw::OtherType => references.push(reference("primary.drive")),
            Flaw::NotFinite => references.push(reference("primary.torque")),
            _ => {}
        }
        values.resize(references.len(), f64::NAN);
        let (from, to) = flaw.pointers(references.as_ptr(), values.as_mut_ptr());
        // SAFETY: an instance; arrays have the given lengths, or are null.
        let status = unsafe { (self.f.fmi3SetFloat64)(self.c, from, references.len(), to, values.len()) };
        let legal = match flaw {
            Flaw::None => Expected::Done,
            Flaw::NotFinite => Expected::Discarded,
            _ => Expected::Refused,
        };
        self.model.expect(call, status, states, legal);
    }

    fn set_integer(&mut self, call: &Call, name: &str, value: c_int) {
        // Meshes that would make a cheap instance expensive are not set.
        let mesh = name.starts_with("mesh.");
        if mesh && value > 0 && value < c_int::MAX {
            return;
        }
        // SAFETY: an instance, one reference, one value.
        let status = unsafe { (self.f.fmi3SetInt32)(self.c, &reference(name), 1, &value, 1) };
        let legal = if mesh { Expected::Discarded } else { Expected::Refused };
        self.model.expect(call, status, BEFORE, legal);
    }

    fn choice(&mut self, call: &Call, set: bool, value: i64) {
        let (wanted, mut found) = (reference("primary.drive"), -1);
        // SAFETY: an instance, one reference, one value.
        unsafe {
            if set {
                let status = (self.f.fmi3SetInt64)(self.c, &wanted, 1, &value, 1);
                let known = (1..3).contains(&value);
                let legal = if known { Expected::Done } else { Expected::Discarded };
                self.model.expect(call, status, BEFORE, legal);
            } else {
                let status = (self.f.fmi3GetInt64)(self.c, &wanted, 1, &raw mut found, 1);
                self.model.expect(call, status, GET_SETTING, Expected::Done);
                assert!((1..3).contains(&found));
            }
        }
    }

    fn boolean(&mut self, call: &Call, set: bool, flaw: Flaw) {
        let wanted = flaw.reference(if set { "initial.equilibrium" } else { "macroSlip" });
        let mut value = 0;
        let (from, to) = flaw.pointers(&wanted, &raw mut value);
        // SAFETY: an instance, one reference and one value, or null.
        let (status, states) = unsafe {
            if set {
                ((self.f.fmi3SetBoolean)(self.c, from, 1, to, 1), BEFORE)
            } else {
                ((self.f.fmi3GetBoolean)(self.c, from, 1, to, 1), GET)
            }
        };
        self.model
            .expect(call, status, states, Expected::done_if(flaw.harmless()));
    }

    fn no_such_type(&mut self, call: &Call, function: usize, length: usize) {
        let (f, c, vr) = (self.f, self.c, 1);
        let (mut single, mut number, mut text, mut clock) = (0.0, 0, null::<c_char>(), 0);
        // SAFETY: an instance, at most one reference and one value.
        let (status, states) = unsafe {
            match function {
                0 => ((f.fmi3GetFloat32)(c, &vr, length, &raw mut single, length), ANY),
                1 => ((f.fmi3SetUInt8)(c, &vr, length, &number, length), SET),
                2 => ((f.fmi3GetUInt8)(c, &vr, length, &raw mut number, length), ANY),
                3 => ((f.fmi3GetString)(c, &vr, length, &raw mut text, length), ANY),
                4 => ((f.fmi3SetClock)(c, &vr, length, &clock), SET),
                _ => ((f.fmi3GetClock)(c, &vr, length, &raw mut clock), ANY),
            }
        };
        self.model.expect(call, status, states, Expected::done_if(length == 0));
    }

    fn output_derivative(&mut self, call: &Call, which: usize, order: c_int, null: bool) {
        let wanted = self.outputs.get(which).copied();
        let mut value = f64::NAN;
        let to: *mut f64 = if null { null_mut() } else { &raw mut value };
        let vr = wanted.unwrap_or(UNKNOWN);
        // SAFETY: an instance, one reference and one order, one value or null.
        let status = unsafe { (self.f.fmi3GetOutputDerivatives)(self.c, &vr, 1, &order, to, 1) };
        let legal = Expected::done_if(wanted.is_some() && order == 1 && !null);
        self.model.expect(call, status, DERIVATIVES, legal);
        assert!(status != OK || value.is_finite(), "{call:?}: {value}");
    }

    fn not_offered(&mut self, call: &Call, function: usize) {
        let (f, c) = (self.f, self.c);
        let (mut number, mut count, mut flag, mut other) = (0.0, 0, 0, 0);
        // SAFETY: an instance, and a place for each value.
        let status = unsafe {
            match function {
                0 => (f.fmi3GetDirectionalDerivative)(c, &1, 1, &101, 1, &1.0, 1, &raw mut number, 1),
                1 => (f.fmi3GetAdjointDerivative)(c, &1, 1, &101, 1, &1.0, 1, &raw mut number, 1),
                2 => (f.fmi3GetNumberOfVariableDependencies)(c, 1, &raw mut count),
                3 => (f.fmi3EnterConfigurationMode)(c),
                4 => (f.fmi3ExitConfigurationMode)(c),
                5 => (f.fmi3EvaluateDiscreteStates)(c),
                6 => (f.fmi3EnterContinuousTimeMode)(c),
                7 => (f.fmi3CompletedIntegratorStep)(c, 1, &raw mut flag, &raw mut other),
                8 => (f.fmi3SetTime)(c, 1.0),
                9 => (f.fmi3GetContinuousStates)(c, &raw mut number, 1),
                10 => (f.fmi3GetNumberOfEventIndicators)(c, &raw mut count),
                _ => (f.fmi3ActivateModelPartition)(c, 1, 0.0),
            }
        };
        self.model.expect(call, status, ANY, Expected::Refused);
    }

    fn logging(&mut self, call: &Call, on: bool, name: Option<&str>) {
        let text: Vec<u8> = name.iter().flat_map(|name| name.bytes()).chain([0]).collect();
        let pointer: *const c_char = text.as_ptr().cast();
        // SAFETY: an instance, and the given number of strings, each with its end.
        let status = unsafe { (self.f.fmi3SetDebugLogging)(self.c, on.into(), name.iter().count(), &pointer) };
        self.model
            .expect(call, status, ANY, Expected::done_if(name != Some("noise")));
    }
}
