//! An importer that makes calls. Which calls a state allows, and what is refused, is tested on a
//! toy in `crates/fmi`; here is what a belt alone can show: no call ends in a panic, a refused call
//! has a reason in the log, and all values are numbers.

use crate::calls::{Answer, Call, INTEGERS, REALS, SLOTS};
use crate::importer::{Handles, Stored, Update};
use crate::variator::{Importer, real_outputs, reference};
use pushbelt::fmi::Unit;
use pushbelt::fmi::Version::{self, Three, Two};
use pushbelt::fmi::log::Status;
use pushbelt::fmi::table::Kind;
use pushbelt::unit::VariatorUnit;
use pushbelt_library::extensions::{pushbeltFreeText, pushbeltLinearize};
use std::cell::Cell;
use std::ptr::null_mut;

/// Counts of situations in the sequences, so that a test can require each of them.
#[derive(Debug, Default)]
pub struct Seen {
    pub steps: Cell<u32>,
    pub events: Cell<u32>,
    pub early: Cell<u32>,
    pub refused: Cell<u32>,
    pub restored: Cell<u32>,
}

fn count(seen: &Cell<u32>, when: bool) {
    seen.set(seen.get() + u32::from(when));
}

#[derive(Clone, Copy, Debug)]
struct Place {
    time: f64,
    event: bool,
}

const BEGIN: Place = Place {
    time: 0.0,
    event: false,
};

pub struct RandomImporter<'a> {
    importer: Importer,
    seen: &'a Seen,
    coarse: bool,
    events: bool,
    at: Place,
    slots: [Option<(Stored, Place)>; SLOTS],
    outputs: Vec<u32>,
    /// References of real variables and arrays, and their numbers of values.
    reals: Vec<(u32, usize)>,
}

impl Drop for RandomImporter<'_> {
    fn drop(&mut self) {
        (0..SLOTS).for_each(|slot| self.free(slot));
    }
}

fn reals(version: Version) -> Vec<(u32, usize)> {
    let table = VariatorUnit::table();
    let size = |reference: u32| match table.array_of(reference) {
        Some(array) if version == Three => (array.first == reference).then_some(array.size),
        _ => Some(1),
    };
    let variables = table.variables().iter();
    let real = variables.filter(|variable| matches!(variable.kind, Kind::Real { .. }));
    let sizes = real.filter_map(|one| Some((one.reference, size(one.reference)? as usize)));
    sizes.collect()
}

impl<'a> RandomImporter<'a> {
    /// An importer of a new instance; `modes`: whether it handles events, early returns and
    /// updates, in FMI 3.0.
    pub fn new(version: Version, seen: &'a Seen, coarse: bool, modes: [bool; 3]) -> Self {
        let [events, early_return, updates] = modes.map(|mode| mode && version == Three);
        let required = ["primary.torque", "primary.speed"].map(reference);
        let required: &[u32] = if updates { &required } else { &[] };
        let handles = Handles {
            events,
            early_return,
            required,
        };
        let mut random = Self {
            importer: Importer::handling(version, handles),
            seen,
            coarse,
            events,
            at: BEGIN,
            slots: [None; SLOTS],
            outputs: real_outputs(),
            reals: reals(version),
        };
        random.after_reset();
        random
    }

    fn after_reset(&mut self) {
        self.at = BEGIN;
        if self.coarse {
            self.importer.make_coarse();
        }
    }

    /// Makes a call. What is refused has a reason in the log, and that is no panic.
    pub fn make(&mut self, call: &Call) {
        self.importer.record.messages.borrow_mut().clear();
        let status = self.status(call);
        count(&self.seen.refused, status == Status::Error);
        let messages = self.importer.record.messages.borrow();
        assert!(status <= Status::Error, "{call:?}: {status:?}");
        assert!(status < Status::Error || !messages.is_empty(), "{call:?} has no reason");
        let panic = messages.iter().find(|message| message.text.contains("internal error"));
        assert!(panic.is_none(), "{call:?}: {panic:?}");
    }

    fn status(&mut self, call: &Call) -> Status {
        let (i, version) = (&self.importer, self.importer.version);
        let finite = |found: Result<Vec<f64>, Status>| {
            let all = found.iter().flatten().all(|value| value.is_finite());
            assert!(all, "{call:?}: {found:?}");
            found.err().unwrap_or(Status::Ok)
        };
        match *call {
            Call::Enter(experiment) => {
                let status = i.enter(experiment);
                if status == Status::Ok {
                    self.at.time = experiment.start;
                }
                status
            }
            Call::Exit => {
                let status = i.exit();
                self.at.event |= self.events && status == Status::Ok;
                status
            }
            Call::EnterEvent if version == Three => {
                let status = i.enter_event_mode();
                self.at.event |= status == Status::Ok;
                status
            }
            Call::EnterStep if self.at.event => {
                i.handle_event();
                self.at.event = false;
                Status::Ok
            }
            Call::Terminate => {
                let status = i.terminate();
                self.at.event &= status != Status::Ok;
                status
            }
            Call::Reset => {
                assert_eq!(i.reset(), Status::Ok);
                self.after_reset();
                Status::Ok
            }
            Call::Step(late, size, answer) => self.step(late, size, answer),
            Call::SetReal(which, share) => {
                let (name, low, high) = REALS[which];
                i.set(reference(name), low + share * (high - low))
            }
            Call::GetReals(ref which) => {
                let wanted = which.iter().map(|which| self.reals[which % self.reals.len()]);
                let (references, sizes): (Vec<u32>, Vec<usize>) = wanted.unzip();
                finite(i.reals(&references, sizes.iter().sum()))
            }
            // Meshes and ring models that would make a coarse instance expensive are not set.
            Call::SetInteger(4..=6, 1..=2) => Status::Ok,
            Call::SetInteger(which, value) => i.set_number(reference(INTEGERS[which]), value),
            Call::InputDerivative(which, order, value) if version == Two => {
                i.set_derivative(reference(REALS[which].0), order, value)
            }
            Call::OutputDerivative(which, order) => {
                finite(i.derivatives(&[self.outputs[which % self.outputs.len()]], order))
            }
            Call::Store(slot) => self.store(slot),
            Call::Restore(slot) => {
                let (state, at) = self.slots[slot].unwrap_or((null_mut(), self.at));
                let status = i.restore(state);
                assert_eq!(status == Status::Ok, !state.is_null());
                self.at = at;
                status
            }
            Call::Free(slot) => {
                self.free(slot);
                Status::Ok
            }
            Call::ThroughBytes => {
                assert_eq!(i.continue_from(&i.bytes()), Status::Ok);
                count(&self.seen.restored, true);
                Status::Ok
            }
            Call::Linearize(frequency) if version == Two => self.linearize(frequency),
            // Of the other version.
            Call::EnterEvent | Call::EnterStep | Call::InputDerivative(..) | Call::Linearize(_) => Status::Ok,
        }
    }

    fn step(&mut self, late: f64, size: f64, answer: Answer) -> Status {
        let (from, alias, mut last) = (self.at.time + late, self.importer.alias(), f64::NEG_INFINITY);
        self.importer.answer(move |update| {
            assert!(update.time >= last);
            last = update.time;
            assert!(alias.get("primary.speed").is_finite());
            update_by(&alias, update, answer)
        });
        let ended = self.importer.step(from, size);
        self.importer.record.answer.take();
        let (event, early, to) = (ended.event, ended.early, from + size);
        match ended.status {
            Status::Ok if early => assert!(ended.time > from && ended.time < to, "{ended:?}"),
            Status::Ok => assert_eq!(ended.time, to),
            Status::Discard => assert_eq!(ended.time, self.at.time),
            _ => return ended.status,
        }
        assert!(!event || self.events, "{ended:?}");
        count(&self.seen.steps, ended.status == Status::Ok);
        count(&self.seen.events, event);
        count(&self.seen.early, early && !event);
        self.at.time = ended.time;
        ended.status
    }

    fn store(&mut self, slot: usize) -> Status {
        let mut state = self.slots[slot].map_or(null_mut(), |(state, _)| state);
        let status = self.importer.store(&mut state);
        self.slots[slot] = Some((state, self.at));
        status
    }

    fn free(&mut self, slot: usize) {
        if let Some((mut state, _)) = self.slots[slot].take() {
            assert_eq!(self.importer.free(&mut state), Status::Ok);
            assert!(state.is_null());
        }
    }

    /// Whether there is a model depends on the belt; the instance continues in both cases.
    fn linearize(&self, frequency: f64) -> Status {
        let mut text = null_mut();
        // SAFETY: an instance, a place for the text, and a text of this call or null.
        unsafe {
            let status = pushbeltLinearize(self.importer.c, frequency, &raw mut text);
            assert_eq!(text.is_null(), status > Status::Warning);
            pushbeltFreeText(text);
            status
        }
    }
}

/// The importer's action in an update; the time of an early return.
fn update_by(i: &Importer, update: Update, answer: Answer) -> Option<f64> {
    match answer {
        Answer::Nothing => None,
        Answer::Return(later) => Some(update.time + later),
        Answer::Set(input) => {
            let done = i.set(reference("primary.torque"), input) == Status::Ok;
            assert_eq!(done, update.set && input.is_finite());
            None
        }
    }
}
