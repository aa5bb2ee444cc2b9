//! A master that makes calls and compares the instance with a model of the standard's state machine: that of FMI 2.0 (its table 4.2.4, for
//! a slave whose steps are synchronous) or of FMI 3.0 (its sections 2.3 and 4.2; a refused call leaves the instance unchanged).

use std::cell::Cell;
use std::ffi::CStr;
use std::ptr::null_mut;
use std::rc::Rc;

use pushbelt::fmi::Unit;
use pushbelt::fmi::log::Status;
use pushbelt::fmi::slave::Version::{self, Three, Two};
use pushbelt::fmi::table::Kind;
use pushbelt::fmi::unit::Experiment;
use pushbelt::unit::VariatorUnit;
use pushbelt_library::linear::{pushbeltFreeText, pushbeltLinearize};

use crate::calls::{Answer, Call, Flaw, INPUTS, INTEGERS, REALS, SLOTS, TUNABLE};
use crate::importer::{Handles, Stored, Update};
use crate::variator::{Importer, real_outputs, reference};

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
const GET: &[State] = &[Initialisation, Step, Event, Terminated, Error];
const RUNNING: &[State] = &[Step, Event];
const DERIVATIVES: &[State] = &[Step, Event, Terminated, Error];
const ANY: &[State] = &[Instantiated, Initialisation, Step, Event, Terminated, Error];

/// A value reference that no variable has.
const UNKNOWN: u32 = 77;

/// The master's model of the instance.
#[derive(Clone, Copy, Debug)]
struct Model {
    state: State,
    time: f64,
    stop: Option<f64>,
}

const FRESH: Model = Model {
    state: Instantiated,
    time: 0.0,
    stop: None,
};

/// The status of a call where the state allows it.
fn done_if(good: bool) -> Status {
    if good { Status::Ok } else { Status::Error }
}

/// A real variable or array: its reference, its number of values, whether it is a setting.
#[derive(Clone, Copy, Debug)]
struct Real {
    reference: u32,
    size: usize,
    setting: bool,
}

fn reals(version: Version) -> Vec<Real> {
    let table = VariatorUnit::table();
    let variables = table.variables().iter();
    let real = variables.filter(|variable| matches!(variable.kind, Kind::Real { .. }));
    real.filter_map(|variable| {
        let size = match table.array_of(variable.reference) {
            Some(array) if version == Three && array.first == variable.reference => array.size,
            Some(_) if version == Three => return None,
            _ => 1,
        };
        Some(Real {
            reference: variable.reference,
            size: size.try_into().expect("72"),
            setting: variable.causality.is_setting(),
        })
    })
    .collect()
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
    importer: Importer,
    seen: &'a Seen,
    coarse: bool,
    events: bool,
    early_return: bool,
    model: Model,
    slots: [Option<(Stored, Model)>; SLOTS],
    outputs: Vec<u32>,
    reals: Vec<Real>,
}

impl Drop for Master<'_> {
    fn drop(&mut self) {
        (0..SLOTS).for_each(|slot| self.free(slot));
    }
}

impl<'a> Master<'a> {
    /// A master of a new instance; `modes`: whether it handles events, early returns and updates, in FMI 3.0.
    pub fn new(version: Version, seen: &'a Seen, coarse: bool, modes: [bool; 3]) -> Self {
        let [events, early_return, updates] = modes.map(|mode| mode && version == Three);
        let required = ["primary.torque", "primary.speed"].map(reference);
        let handles = Handles::of(events, early_return, if updates { &required } else { &[] });
        let mut master = Self {
            importer: Importer::handling(version, handles),
            seen,
            coarse,
            events,
            early_return,
            model: FRESH,
            slots: [None; SLOTS],
            outputs: real_outputs(),
            reals: reals(version),
        };
        master.after_reset();
        master
    }

    fn after_reset(&mut self) {
        self.model = FRESH;
        if self.coarse {
            self.importer.make_coarse();
        }
    }

    /// Compares the status of a call with the expected one.
    fn expect(&self, call: &Call, status: Status, allowed: &[State], legal: Status) {
        // In the error state there are values only if the run had started.
        let values = allowed.contains(&Error) && !allowed.contains(&Instantiated);
        if self.model.state == Error && values && status == Status::Error {
            return;
        }
        let is_allowed = allowed.contains(&self.model.state);
        let wanted = if is_allowed { legal } else { Status::Error };
        assert_eq!(
            status,
            wanted,
            "{call:?} with {:?}: {}",
            self.model,
            self.importer.last()
        );
    }

    /// Checks a call that leads to another state.
    fn moves(&mut self, call: &Call, status: Status, from: &[State], to: State) {
        self.expect(call, status, from, Status::Ok);
        if status == Status::Ok {
            self.model.state = to;
        }
    }

    /// Makes a call and compares its result with the model.
    pub fn make(&mut self, call: &Call) {
        self.importer.record.messages.borrow_mut().clear();
        let (i, version) = (&self.importer, self.importer.version);
        match *call {
            Call::Enter(experiment) => self.enter(call, experiment),
            Call::Exit => {
                let to = if self.events { Event } else { Step };
                self.moves(call, i.exit(), &[Initialisation], to);
            }
            Call::EnterEvent if version == Three => {
                let from: &[State] = if self.events { &[Step] } else { &[] };
                self.moves(call, i.enter_event_mode(), from, Event);
            }
            Call::EnterStep if self.model.state == Event => {
                i.handle_event();
                self.model.state = Step;
            }
            Call::Terminate => self.moves(call, i.terminate(), RUNNING, Terminated),
            Call::Reset => {
                assert_eq!(i.reset(), Status::Ok);
                self.after_reset();
            }
            Call::Step(late, size, answer) => self.step(call, late, size, answer),
            Call::SetReal(which, share, flaw) => self.set_real(call, which, share, flaw),
            Call::SetOutput => self.expect(call, i.set(reference("thrustRatio"), 1.0), ANY, Status::Error),
            Call::GetReals(ref which, flaw) => self.get_reals(call, which, flaw),
            Call::SetInteger(which, value) => self.set_integer(call, INTEGERS[which], value),
            Call::GetInteger => {
                let status = i.integer(reference("primary.drive")).err().unwrap_or(Status::Ok);
                self.expect(call, status, self.get_setting(), Status::Ok);
            }
            Call::SetBoolean(flaw) => {
                let status = i.set_boolean(flawed(flaw, "initial.equilibrium"), 0);
                self.expect(call, status, BEFORE, done_if(is_harmless(flaw)));
            }
            Call::GetBoolean(flaw) => {
                let status = i.boolean(flawed(flaw, "macroSlip")).err().unwrap_or(Status::Ok);
                self.expect(call, status, GET, done_if(is_harmless(flaw)));
            }
            Call::InputDerivative(which, order, value) if version == Two => {
                let status = i.set_derivative(reference(REALS[which].0), order, value);
                let good = which < INPUTS && order == 1 && value.is_finite();
                self.expect(call, status, SET, done_if(good));
            }
            Call::OutputDerivative(which, order) => {
                let output = self.outputs.get(which).copied();
                let found = i.derivatives(&[output.unwrap_or(UNKNOWN)], order);
                let good = done_if(output.is_some() && order == 1);
                self.expect(
                    call,
                    found.as_ref().err().copied().unwrap_or(Status::Ok),
                    DERIVATIVES,
                    good,
                );
                assert!(
                    found.iter().flatten().all(|value| value.is_finite()),
                    "{call:?}: {found:?}"
                );
            }
            Call::Log(on, known) => {
                let names: &[&CStr] = match known {
                    None => &[],
                    Some(true) => &[c"logEvents"],
                    Some(false) => &[c"noise"],
                };
                self.expect(call, i.log(on, names), ANY, done_if(known != Some(false)));
            }
            Call::Store(slot) => self.store(slot),
            Call::Restore(slot) => match self.slots[slot] {
                Some((state, model)) => {
                    assert_eq!(i.restore(state), Status::Ok);
                    self.go_back(model);
                }
                None => assert_eq!(i.restore(null_mut()), Status::Error),
            },
            Call::Free(slot) => self.free(slot),
            Call::ThroughBytes(slot, damage, left) => self.through_bytes(slot, damage, left),
            Call::Linearize(frequency) if version == Two => self.linearize(call, frequency),
            // Of the other version, or not to be told from an allowed call.
            Call::EnterEvent | Call::EnterStep | Call::InputDerivative(..) | Call::Linearize(_) => {}
        }
    }

    fn enter(&mut self, call: &Call, experiment: Experiment) {
        let Experiment { tolerance, start, stop } = experiment;
        let good = start.abs() <= 1e11
            && tolerance.is_none_or(|t| t.is_finite() && t > 0.0)
            && stop.is_none_or(|stop| stop >= start);
        let status = self.importer.enter(experiment);
        self.expect(call, status, &[Instantiated], done_if(good));
        if status == Status::Ok {
            self.model = Model {
                state: Initialisation,
                time: start,
                stop,
            };
        }
    }

    fn step(&mut self, call: &Call, late: f64, size: f64, answer: Answer) {
        let (from, asked, declined) = (self.model.time + late, Rc::default(), Rc::default());
        let to = from + size;
        let alias = self.importer.alias();
        let (asks, declines, mut last) = (Rc::clone(&asked), Rc::clone(&declined), f64::NEG_INFINITY);
        self.importer.answer(move |update| {
            assert!(update.time >= last);
            last = update.time;
            assert!(alias.get("primary.speed").is_finite());
            update_by(&alias, update, answer, (&asks, &declines))
        });
        let ended = self.importer.step(from, size);
        self.importer.record.answer.take();
        let good =
            late == 0.0 && size > 0.0 && size < 1e3 && self.model.stop.is_none_or(|stop| to <= stop + 1e-6 * size);
        if good && ended.status == Status::Discard && self.model.state == Step {
            assert_eq!(ended.time, self.model.time, "{ended:?} after {call:?}");
            count(&self.seen.discarded, true);
            return;
        }
        count(&self.seen.declined, declined.get());
        self.expect(call, ended.status, &[Step], done_if(good));
        if ended.status != Status::Ok {
            return;
        }
        let (event, early) = (ended.event, ended.early);
        assert!(!event || self.events, "{ended:?}");
        assert!(
            !early || self.early_return && (event || asked.get()),
            "{ended:?} after {call:?}"
        );
        if early {
            assert!(ended.time > from && ended.time < to, "{ended:?} after {call:?}");
        } else {
            assert_eq!(ended.time, to);
        }
        count(&self.seen.events, event);
        count(&self.seen.asked, early && asked.get());
        self.model.time = ended.time;
    }

    fn set_real(&mut self, call: &Call, which: usize, share: f64, flaw: Flaw) {
        let (name, low, high) = REALS[which];
        let (mut references, mut values) = (vec![reference(name)], vec![low + share * (high - low)]);
        let (legal, more) = match flaw {
            Flaw::None => (Status::Ok, None),
            Flaw::UnknownReference => (Status::Error, Some(UNKNOWN)),
            Flaw::OtherType => (Status::Error, Some(reference("primary.drive"))),
            Flaw::NotFinite => (Status::Discard, Some(reference("primary.torque"))),
        };
        references.extend(more);
        values.resize(references.len(), f64::NAN);
        let states = if which < TUNABLE { SET } else { BEFORE };
        self.expect(call, self.importer.set_reals(&references, &values), states, legal);
    }

    fn get_reals(&mut self, call: &Call, which: &[usize], flaw: Flaw) {
        let wanted: Vec<Real> = which.iter().map(|which| self.reals[which % self.reals.len()]).collect();
        let mut references: Vec<u32> = wanted.iter().map(|real| real.reference).collect();
        match flaw {
            Flaw::UnknownReference => references.push(UNKNOWN),
            Flaw::OtherType => references.push(reference("macroSlip")),
            _ => {}
        }
        let size = wanted.iter().map(|real| real.size).sum::<usize>() + references.len() - wanted.len();
        let found = self.importer.reals(&references, size);
        let states = match wanted.iter().all(|real| real.setting) {
            true => self.get_setting(),
            false => GET,
        };
        let status = found.as_ref().err().copied().unwrap_or(Status::Ok);
        self.expect(call, status, states, done_if(is_harmless(flaw)));
        assert!(
            found.iter().flatten().all(|value| value.is_finite()),
            "{call:?}: {found:?}"
        );
    }

    /// States in which settings can be read.
    fn get_setting(&self) -> &'static [State] {
        match self.importer.version {
            Two => GET,
            Three => ANY,
        }
    }

    fn set_integer(&mut self, call: &Call, name: &str, value: i32) {
        // Meshes and ring models that would make a coarse instance expensive are not set.
        let expensive = matches!(name, "mesh.primaryArc" | "mesh.strand" | "ring.model") && value > 0;
        if expensive && value < i32::MAX {
            return;
        }
        let legal = match name {
            "friction.pulley" => Status::Error,
            _ if (1..3).contains(&value) => Status::Ok,
            _ => Status::Discard,
        };
        self.expect(call, self.importer.set_integer(reference(name), value), BEFORE, legal);
    }

    fn store(&mut self, slot: usize) {
        let (kept, i) = (&mut self.slots[slot], &self.importer);
        let mut state = kept.map_or(null_mut(), |(state, _)| state);
        let before = state;
        assert_eq!(i.store(&mut state), Status::Ok);
        assert!(
            before.is_null() || state == before,
            "a state that is not null is used again"
        );
        *kept = Some((state, self.model));
    }

    /// To the state of a model; the stop time is that of the instance.
    fn go_back(&mut self, model: Model) {
        self.model = Model {
            stop: self.model.stop,
            ..model
        };
    }

    fn free(&mut self, slot: usize) {
        if let Some((mut state, _)) = self.slots[slot].take() {
            assert_eq!(self.importer.free(&mut state), Status::Ok);
            assert!(state.is_null());
        }
    }

    /// Serializes the present state and deserializes it; damaged or cut bytes must be refused. Whole ones are restored, and stored.
    fn through_bytes(&mut self, slot: usize, damage: Option<(f64, u8)>, left: f64) {
        let i = &self.importer;
        let mut bytes = i.bytes();
        let size = bytes.len();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss
        )]
        let place = |share: f64| (share * size as f64) as usize;
        if let Some((at, mask)) = damage {
            bytes[place(at)] ^= mask;
        }
        bytes.resize(place(left), 0);
        let whole = damage.is_none_or(|(at, _)| place(at) >= bytes.len()) && bytes.len() == size;
        let status = i.continue_from(&bytes);
        assert_eq!(status, done_if(whole));
        self.store(slot);
    }

    /// Whether there is a model depends on the belt; the instance continues in both cases.
    fn linearize(&self, call: &Call, frequency: f64) {
        let mut text = null_mut();
        // SAFETY: an instance, a place for the text, and a text of this call or null.
        unsafe {
            let status = pushbeltLinearize(self.importer.c, frequency, &raw mut text);
            let possible = GET.contains(&self.model.state) && (0.01..=1e5).contains(&frequency);
            let done = matches!(status, Status::Ok | Status::Warning);
            assert!(status == Status::Error || possible && done, "{call:?}: {status:?}");
            assert_eq!(text.is_null(), !done, "{call:?}");
            pushbeltFreeText(text);
        }
    }
}

/// Whether calls with integers and Booleans remain valid.
fn is_harmless(flaw: Flaw) -> bool {
    matches!(flaw, Flaw::None | Flaw::NotFinite)
}

/// The reference of a variable, or a flawed one. No Boolean is called `thrustRatio`.
fn flawed(flaw: Flaw, name: &str) -> u32 {
    match flaw {
        Flaw::UnknownReference => UNKNOWN,
        Flaw::OtherType => reference("thrustRatio"),
        _ => reference(name),
    }
}

/// The master's action in an update: whether an early return may be requested and was, whether a value was discarded.
fn update_by(
    i: &Importer,
    update: Update,
    answer: Answer,
    (asks, declines): (&Cell<bool>, &Cell<bool>),
) -> Option<f64> {
    match answer {
        Answer::Nothing => {}
        Answer::Set(input) => {
            let status = i.set(reference("primary.torque"), input);
            let wanted = match (update.set, input.is_finite()) {
                (true, true) => Status::Ok,
                (true, false) => Status::Discard,
                _ => Status::Error,
            };
            assert_eq!(status, wanted);
            declines.set(declines.get() || status == Status::Discard);
        }
        Answer::Return(later) => {
            asks.set(asks.get() || update.can_return);
            return Some(update.time + later);
        }
        Answer::Meddle => {
            let mut state = null_mut();
            let refused = [
                i.reals(&[reference("belt.speed")], 1).err(),
                Some(i.set(reference("secondary.torque"), 1.0)),
                Some(i.reset()),
                Some(i.enter_event_mode()),
                Some(i.terminate()),
                Some(i.store(&mut state)),
                Some(i.step(update.time, 1e-3).status),
            ];
            assert_eq!(refused, [Some(Status::Error); 7]);
        }
    }
    None
}
