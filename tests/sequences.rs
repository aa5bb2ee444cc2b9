//! Call sequences in random order with random and bad arguments, through the C functions of the built library, beside
//! a model of the standard's state machine (its table 4.2.4, for a slave whose steps end before they return).
//!
//! The long run: `PUSHBELT_SEQUENCES=100000 PUSHBELT_DEFAULT_SEQUENCES=1000 cargo test --test sequences`. Under
//! valgrind, where it is installed, a short run is part of the test.

#![allow(unsafe_code, reason = "it calls the C functions")]

use std::ffi::{c_char, c_int};
use std::ptr::{null, null_mut};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use pushbelt::fmi2::Unit;
use pushbelt::fmi2::c_abi::{Component, FmuState};
use pushbelt::fmi2::table::{Causality, Kind};
use pushbelt::unit::VariatorUnit;
use pushbelt_lab::shared_library::{DISCARD, ERROR, Functions, Library, OK, count, reference};

/// States of the standard's state machine.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Initialisation,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
}

use State::{Error, Initialisation, Instantiated, StepComplete, StepFailed, Terminated};

const SET: &[State] = &[Instantiated, Initialisation, StepComplete, StepFailed];
const GET: &[State] = &[Initialisation, StepComplete, StepFailed, Terminated, Error];
const RUNNING: &[State] = &[StepComplete, StepFailed];
const STATUS: &[State] = &[StepComplete, StepFailed, Terminated];

/// What is wrong with an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Flaw {
    None,
    NullReferences,
    NullValues,
    UnknownReference,
    OtherType,
    NotFinite,
}

/// A call.
#[derive(Clone, Debug)]
enum Call {
    Setup {
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    },
    EnterInitialization,
    ExitInitialization,
    Terminate,
    Reset,
    Step {
        late: f64,
        size: f64,
    },
    SetInput {
        which: usize,
        value: f64,
        flaw: Flaw,
    },
    SetParameter {
        which: usize,
        share: f64,
        flaw: Flaw,
    },
    SetOutput,
    GetReals {
        which: Vec<usize>,
        flaw: Flaw,
    },
    GetIntegers {
        flaw: Flaw,
    },
    SetInteger {
        which: usize,
        value: c_int,
    },
    Boolean {
        set: bool,
        flaw: Flaw,
    },
    String {
        set: bool,
        length: usize,
    },
    Derivative {
        which: usize,
        order: c_int,
        value: f64,
    },
    OutputDerivative {
        which: usize,
        order: c_int,
        null: bool,
    },
    Directional,
    Logging {
        on: bool,
        name: Option<&'static str>,
    },
    Store {
        slot: usize,
    },
    Restore {
        slot: usize,
    },
    Drop {
        slot: usize,
    },
    ThroughBytes {
        slot: usize,
        damage: Option<(f64, u8)>,
        cut: f64,
    },
    Status {
        function: usize,
        kind: c_int,
        null: bool,
    },
    Cancel,
    NullInstance,
}

fn flaws() -> impl Strategy<Value = Flaw> {
    prop_oneof![
        6 => Just(Flaw::None),
        1 => Just(Flaw::NullReferences),
        1 => Just(Flaw::NullValues),
        1 => Just(Flaw::UnknownReference),
        1 => Just(Flaw::OtherType),
        1 => Just(Flaw::NotFinite),
    ]
}

fn bad_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(-1.0),
        Just(0.0)
    ]
}

fn calls() -> impl Strategy<Value = Call> {
    let slot = 0..3_usize;
    prop_oneof![
        2 => (
            prop_oneof![Just(None), Just(Some(1e-3)), bad_number().prop_map(Some)],
            prop_oneof![3 => Just(0.0), 1 => Just(1e6), 1 => bad_number()],
            prop_oneof![2 => Just(None), 1 => Just(Some(2e6)), 1 => Just(Some(0.004)), 1 => bad_number().prop_map(Some)],
        )
            .prop_map(|(tolerance, start, stop)| Call::Setup { tolerance, start, stop }),
        3 => Just(Call::EnterInitialization),
        5 => Just(Call::ExitInitialization),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
        12 => (
            prop_oneof![9 => Just(0.0), 1 => prop_oneof![Just(1e-3), Just(-1e-3), bad_number()]],
            prop_oneof![9 => 1e-5..2e-3, 1 => Just(5e-3), 2 => prop_oneof![bad_number(), Just(1e30), Just(1e-300)]],
        )
            .prop_map(|(late, size)| Call::Step { late, size }),
        6 => (0..6_usize, -1.0..1.0, flaws()).prop_map(|(which, value, flaw)| Call::SetInput { which, value, flaw }),
        3 => (0..PARAMETERS.len(), 0.0..1.0, flaws())
            .prop_map(|(which, share, flaw)| Call::SetParameter { which, share, flaw }),
        1 => Just(Call::SetOutput),
        4 => (vec(0..500_usize, 0..9), flaws()).prop_map(|(which, flaw)| Call::GetReals { which, flaw }),
        1 => flaws().prop_map(|flaw| Call::GetIntegers { flaw }),
        2 => (0..8_usize, prop_oneof![Just(1), Just(2), Just(0), Just(-1), Just(c_int::MAX), Just(c_int::MIN)])
            .prop_map(|(which, value)| Call::SetInteger { which, value }),
        1 => (any::<bool>(), flaws()).prop_map(|(set, flaw)| Call::Boolean { set, flaw }),
        1 => (any::<bool>(), 0..2_usize).prop_map(|(set, length)| Call::String { set, length }),
        3 => (0..7_usize, prop_oneof![6 => Just(1), 1 => Just(0), 1 => Just(2), 1 => Just(-1)],
              prop_oneof![9 => -1e4..1e4, 1 => bad_number()])
            .prop_map(|(which, order, value)| Call::Derivative { which, order, value }),
        2 => (0..50_usize, prop_oneof![6 => Just(1), 1 => Just(0), 1 => Just(2)], prop::bool::weighted(0.1))
            .prop_map(|(which, order, null)| Call::OutputDerivative { which, order, null }),
        1 => Just(Call::Directional),
        1 => (any::<bool>(), prop_oneof![Just(None), Just(Some("logEvents")), Just(Some("noise"))])
            .prop_map(|(on, name)| Call::Logging { on, name }),
        3 => slot.clone().prop_map(|slot| Call::Store { slot }),
        3 => slot.clone().prop_map(|slot| Call::Restore { slot }),
        1 => slot.clone().prop_map(|slot| Call::Drop { slot }),
        2 => (slot, prop::option::weighted(0.4, (0.0..1.0, 1..=u8::MAX)), prop_oneof![3 => Just(1.0), 1 => 0.0..1.1])
            .prop_map(|(slot, damage, cut)| Call::ThroughBytes { slot, damage, cut }),
        2 => (0..5_usize, -1..5, prop::bool::weighted(0.1))
            .prop_map(|(function, kind, null)| Call::Status { function, kind, null }),
        1 => Just(Call::Cancel),
        1 => Just(Call::NullInstance),
    ]
}

/// Real parameters, with values that fit every other: what does not fit is tested elsewhere.
const PARAMETERS: &[(&str, f64, f64)] = &[
    ("friction.pulley", 0.05, 0.1),
    ("friction.ring", 0.0, 0.1),
    ("primary.inertia", 0.005, 0.2),
    ("secondary.sheaveDamping", 1e3, 1e4),
    ("initial.primarySpeed", 0.0, 300.0),
    ("initial.ratio", 0.7, 1.5),
];
const TUNABLE: usize = 2;

const INPUTS: [(&str, f64, f64); 6] = [
    ("primary.torque", 0.0, 300.0),
    ("secondary.torque", 0.0, 300.0),
    ("primary.clampingForce", 2e4, 2e4),
    ("secondary.clampingForce", 2e4, 2e4),
    ("primary.speedSetpoint", 200.0, 200.0),
    ("secondary.speedSetpoint", 200.0, 200.0),
];

const INTEGERS: [&str; 8] = [
    "primary.drive",
    "secondary.drive",
    "primary.axial",
    "secondary.axial",
    "mesh.primaryArc",
    "mesh.strand",
    "ring.model",
    "friction.pulley",
];

/// A stored state with what the model knows of it.
struct Slot {
    state: FmuState,
    model: Model,
}

/// What a master knows of the instance.
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

/// What a call should come to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Expected {
    Done,
    /// An error that changes nothing.
    Refused,
    /// An error after which only reset and stored states go on.
    Failed,
}

struct Master<'a> {
    f: &'a Functions,
    c: Component,
    cheap: bool,
    model: Model,
    slots: [Option<Slot>; 3],
    outputs: &'a [u32],
    readings: &'a [u32],
}

impl Drop for Master<'_> {
    fn drop(&mut self) {
        for slot in 0..self.slots.len() {
            self.drop_slot(slot);
        }
        // SAFETY: the instance is not used any more.
        unsafe { (self.f.fmi2FreeInstance)(self.c) };
    }
}

impl Master<'_> {
    fn expect(&mut self, call: &Call, status: c_int, allowed: &[State], legal: Expected) {
        // In the error state there are values only if the run had started.
        if self.model.state == Error && allowed.contains(&Error) && !allowed.contains(&Instantiated) && status == ERROR
        {
            return;
        }
        let expected = if allowed.contains(&self.model.state) {
            legal
        } else {
            Expected::Refused
        };
        let wanted = if expected == Expected::Done { OK } else { ERROR };
        assert_eq!(status, wanted, "{call:?} with {:?}: {expected:?}", self.model);
        if expected == Expected::Failed {
            self.model.state = Error;
        }
    }

    /// Follows a call that leads to another state.
    fn moves(&mut self, call: &Call, status: c_int, from: &[State], to: State) {
        self.expect(call, status, from, Expected::Done);
        if status == OK {
            self.model.state = to;
        }
    }

    fn drop_slot(&mut self, slot: usize) {
        if let Some(Slot { mut state, .. }) = self.slots[slot].take() {
            // SAFETY: a state that has not been freed.
            unsafe {
                assert_eq!((self.f.fmi2FreeFMUstate)(self.c, &mut state), OK);
                assert!(state.is_null());
                assert_eq!((self.f.fmi2FreeFMUstate)(self.c, &mut state), OK, "null is legal");
            }
        }
    }

    fn after_reset(&mut self) {
        self.model = FRESH;
        if self.cheap {
            // SAFETY: an instance.
            unsafe { self.f.make_cheap(self.c) };
        }
    }

    #[expect(clippy::too_many_lines, reason = "one arm a function of the standard")]
    fn make(&mut self, call: &Call) {
        let (f, c) = (self.f, self.c);
        let any = &[
            Instantiated,
            Initialisation,
            StepComplete,
            StepFailed,
            Terminated,
            Error,
        ][..];
        // SAFETY: `c` is an instance; arrays are as long as said, null where a flaw asks for it.
        unsafe {
            match call {
                Call::Setup { tolerance, start, stop } => {
                    let status = (f.fmi2SetupExperiment)(
                        c,
                        tolerance.is_some().into(),
                        tolerance.unwrap_or(f64::NAN),
                        *start,
                        stop.is_some().into(),
                        stop.unwrap_or(f64::NAN),
                    );
                    let good = start.is_finite()
                        && tolerance.is_none_or(|t| t.is_finite() && t > 0.0)
                        && stop.is_none_or(|stop| stop.is_finite() && stop >= *start);
                    let legal = if good { Expected::Done } else { Expected::Refused };
                    self.expect(call, status, &[Instantiated], legal);
                    if status == OK {
                        (self.model.time, self.model.stop) = (*start, *stop);
                    }
                }
                Call::EnterInitialization => {
                    let status = (f.fmi2EnterInitializationMode)(c);
                    self.moves(call, status, &[Instantiated], Initialisation);
                }
                Call::ExitInitialization => {
                    let status = (f.fmi2ExitInitializationMode)(c);
                    self.moves(call, status, &[Initialisation], StepComplete);
                }
                Call::Terminate => {
                    let status = (f.fmi2Terminate)(c);
                    self.moves(call, status, RUNNING, Terminated);
                }
                Call::Reset => {
                    assert_eq!((f.fmi2Reset)(c), OK);
                    self.after_reset();
                }
                Call::Step { late, size } => {
                    let from = self.model.time + late;
                    let status = (f.fmi2DoStep)(c, from, *size, 1);
                    let to = from + size;
                    let good = *late == 0.0
                        && (0.0..1e3).contains(size)
                        && to > from
                        && self.model.stop.is_none_or(|stop| to <= stop + 1e-6 * size);
                    if good && status == DISCARD && RUNNING.contains(&self.model.state) {
                        self.model.state = StepFailed;
                        let mut reached = f64::NAN;
                        assert_eq!((f.fmi2GetRealStatus)(c, 2, &mut reached), OK);
                        assert!((self.model.time..to).contains(&reached), "{reached} after {call:?}");
                        self.model.time = reached;
                    } else {
                        let legal = if good { Expected::Done } else { Expected::Refused };
                        self.expect(call, status, RUNNING, legal);
                        if status == OK {
                            (self.model.state, self.model.time) = (StepComplete, to);
                        }
                    }
                }
                Call::SetInput { which, value, flaw } => {
                    let (name, middle, width) = INPUTS[*which];
                    self.set_real(call, reference(name), middle + value * width, *flaw, SET);
                }
                Call::SetParameter { which, share, flaw } => {
                    let (name, low, high) = PARAMETERS[*which];
                    let states = if *which < TUNABLE {
                        SET
                    } else {
                        &[Instantiated, Initialisation]
                    };
                    self.set_real(call, reference(name), low + share * (high - low), *flaw, states);
                }
                Call::SetOutput => {
                    let status = (f.fmi2SetReal)(c, &reference("thrustRatio"), 1, &1.0);
                    self.expect(call, status, any, Expected::Refused);
                }
                Call::GetReals { which, flaw } => {
                    let mut references: Vec<u32> = which
                        .iter()
                        .map(|which| self.readings[which % self.readings.len()])
                        .collect();
                    let legal = match flaw {
                        Flaw::NullReferences | Flaw::NullValues if references.is_empty() => Expected::Done,
                        Flaw::None | Flaw::NotFinite => Expected::Done,
                        Flaw::UnknownReference => {
                            references.push(77);
                            Expected::Refused
                        }
                        Flaw::OtherType => {
                            references.push(reference("macroSlip"));
                            Expected::Refused
                        }
                        Flaw::NullReferences | Flaw::NullValues => Expected::Refused,
                    };
                    let mut values = vec![f64::NAN; references.len()];
                    let status = (f.fmi2GetReal)(
                        c,
                        if *flaw == Flaw::NullReferences {
                            null()
                        } else {
                            references.as_ptr()
                        },
                        references.len(),
                        if *flaw == Flaw::NullValues {
                            null_mut()
                        } else {
                            values.as_mut_ptr()
                        },
                    );
                    let empty_nulls = references.is_empty() && matches!(flaw, Flaw::NullReferences | Flaw::NullValues);
                    self.expect(call, status, GET, legal);
                    if status == OK && !empty_nulls {
                        assert!(values.iter().all(|value| value.is_finite()), "{call:?}: {values:?}");
                    }
                }
                Call::GetIntegers { flaw } => {
                    let wanted = match flaw {
                        Flaw::UnknownReference => 77,
                        Flaw::OtherType => reference("thrustRatio"),
                        _ => reference("primary.drive"),
                    };
                    let mut value = -1;
                    let (references, values): (*const u32, *mut c_int) = match flaw {
                        Flaw::NullReferences => (null(), &mut value),
                        Flaw::NullValues => (&wanted, null_mut()),
                        _ => (&wanted, &mut value),
                    };
                    let status = (f.fmi2GetInteger)(c, references, 1, values);
                    let good = matches!(flaw, Flaw::None | Flaw::NotFinite);
                    let legal = if good { Expected::Done } else { Expected::Refused };
                    self.expect(call, status, GET, legal);
                }
                Call::SetInteger { which, value } => {
                    let name = INTEGERS[*which];
                    // Meshes and ring models that would make a cheap instance dear are left as they are.
                    let dear = matches!(name, "mesh.primaryArc" | "mesh.strand" | "ring.model") && *value > 0;
                    if dear && *value < c_int::MAX {
                        return;
                    }
                    let status = (f.fmi2SetInteger)(c, &reference(name), 1, value);
                    let legal = match name {
                        "friction.pulley" => Expected::Refused,
                        _ if (1..3).contains(value) => Expected::Done,
                        _ => Expected::Failed,
                    };
                    self.expect(call, status, &[Instantiated, Initialisation], legal);
                }
                Call::Boolean { set, flaw } => {
                    let wanted = match flaw {
                        Flaw::UnknownReference => 77,
                        Flaw::OtherType => reference("thrustRatio"),
                        _ if *set => reference("initial.equilibrium"),
                        _ => reference("macroSlip"),
                    };
                    let mut value = 0;
                    let references: *const u32 = if *flaw == Flaw::NullReferences { null() } else { &wanted };
                    let values: *mut c_int = if *flaw == Flaw::NullValues {
                        null_mut()
                    } else {
                        &mut value
                    };
                    let good = matches!(flaw, Flaw::None | Flaw::NotFinite);
                    let legal = if good { Expected::Done } else { Expected::Refused };
                    if *set {
                        let status = (f.fmi2SetBoolean)(c, references, 1, values);
                        self.expect(call, status, &[Instantiated, Initialisation], legal);
                    } else {
                        let status = (f.fmi2GetBoolean)(c, references, 1, values);
                        self.expect(call, status, GET, legal);
                    }
                }
                Call::String { set, length } => {
                    let legal = if *length == 0 {
                        Expected::Done
                    } else {
                        Expected::Refused
                    };
                    let mut value: *const c_char = c"text".as_ptr();
                    if *set {
                        let status = (f.fmi2SetString)(c, &1, *length, &value);
                        self.expect(call, status, SET, legal);
                    } else {
                        let status = (f.fmi2GetString)(c, &1, *length, &mut value);
                        self.expect(call, status, GET, legal);
                    }
                }
                Call::Derivative { which, order, value } => {
                    let wanted = INPUTS.get(*which).map_or(77, |(name, ..)| reference(name));
                    let status = (f.fmi2SetRealInputDerivatives)(c, &wanted, 1, order, value);
                    let legal = if wanted == 77 || *order != 1 {
                        Expected::Refused
                    } else if value.is_finite() {
                        Expected::Done
                    } else {
                        Expected::Failed
                    };
                    self.expect(call, status, SET, legal);
                }
                Call::OutputDerivative { which, order, null } => {
                    let wanted = self.outputs.get(*which).copied().unwrap_or(77);
                    let mut value = f64::NAN;
                    let values: *mut f64 = if *null { null_mut() } else { &mut value };
                    let status = (f.fmi2GetRealOutputDerivatives)(c, &wanted, 1, order, values);
                    let good = wanted != 77 && *order == 1 && !null;
                    let legal = if good { Expected::Done } else { Expected::Refused };
                    self.expect(call, status, &[StepComplete, StepFailed, Terminated, Error], legal);
                    assert!(status != OK || value.is_finite(), "{call:?}: {value}");
                }
                Call::Directional => {
                    let status = (f.fmi2GetDirectionalDerivative)(c, &1, 1, &101, 1, &1.0, &mut 0.0);
                    self.expect(call, status, any, Expected::Refused);
                }
                Call::Logging { on, name } => {
                    let text: Vec<u8> = name.iter().flat_map(|name| name.bytes()).chain([0]).collect();
                    let pointer: *const c_char = text.as_ptr().cast();
                    let status = (f.fmi2SetDebugLogging)(c, (*on).into(), name.iter().count(), &pointer);
                    let legal = if *name == Some("noise") {
                        Expected::Refused
                    } else {
                        Expected::Done
                    };
                    self.expect(call, status, any, legal);
                }
                Call::Store { slot } => {
                    let kept = &mut self.slots[*slot];
                    let mut state = kept.as_ref().map_or(null_mut(), |slot| slot.state);
                    let before = state;
                    assert_eq!((f.fmi2GetFMUstate)(c, &mut state), OK);
                    assert!(
                        before.is_null() || state == before,
                        "a state that is not null is used again"
                    );
                    *kept = Some(Slot {
                        state,
                        model: self.model,
                    });
                }
                Call::Restore { slot } => match &self.slots[*slot] {
                    Some(Slot { state, model }) => {
                        assert_eq!((f.fmi2SetFMUstate)(c, *state), OK);
                        self.model = *model;
                    }
                    None => assert_eq!((f.fmi2SetFMUstate)(c, null_mut()), ERROR),
                },
                Call::Drop { slot } => self.drop_slot(*slot),
                Call::ThroughBytes { slot, damage, cut } => self.through_bytes(*slot, *damage, *cut),
                Call::Status { function, kind, null } => {
                    let (mut real, mut integer, mut text) = (0.0, 0, null_mut::<c_char>().cast_const());
                    let number: *mut c_int = if *null { null_mut() } else { &mut integer };
                    let (status, known) = match function {
                        0 => ((f.fmi2GetStatus)(c, *kind, number), *kind == 0),
                        1 => {
                            let value: *mut f64 = if *null { null_mut() } else { &mut real };
                            ((f.fmi2GetRealStatus)(c, *kind, value), *kind == 2)
                        }
                        2 => ((f.fmi2GetBooleanStatus)(c, *kind, number), *kind == 3),
                        3 => ((f.fmi2GetIntegerStatus)(c, *kind, number), false),
                        _ => ((f.fmi2GetStringStatus)(c, *kind, &mut text), false),
                    };
                    let null = *null && *function < 3;
                    let wanted = match STATUS.contains(&self.model.state) {
                        true if (0..4).contains(kind) && !null => [DISCARD, OK][usize::from(known)],
                        _ => ERROR,
                    };
                    assert_eq!(status, wanted, "{call:?} with {:?}", self.model);
                }
                Call::Cancel => assert_eq!((f.fmi2CancelStep)(c), ERROR),
                Call::NullInstance => {
                    (f.fmi2FreeInstance)(null_mut());
                    assert_eq!((f.fmi2DoStep)(null_mut(), 0.0, 1e-3, 1), ERROR);
                    assert_eq!((f.fmi2GetReal)(null_mut(), &1, 1, &mut 0.0), ERROR);
                }
            }
        }
    }

    fn set_real(&mut self, call: &Call, wanted: u32, value: f64, flaw: Flaw, states: &[State]) {
        let (mut references, mut values) = (vec![wanted], vec![value]);
        match flaw {
            Flaw::UnknownReference => references.push(77),
            Flaw::OtherType => references.push(reference("primary.drive")),
            Flaw::NotFinite => references.push(reference("primary.torque")),
            _ => {}
        }
        values.resize(references.len(), f64::NAN);
        // SAFETY: an instance; arrays are as long as said, or null where the flaw asks for it.
        let status = unsafe {
            (self.f.fmi2SetReal)(
                self.c,
                if flaw == Flaw::NullReferences {
                    null()
                } else {
                    references.as_ptr()
                },
                references.len(),
                if flaw == Flaw::NullValues {
                    null()
                } else {
                    values.as_ptr()
                },
            )
        };
        let legal = match flaw {
            Flaw::None => Expected::Done,
            Flaw::NotFinite => Expected::Failed,
            _ => Expected::Refused,
        };
        self.expect(call, status, states, legal);
    }

    /// To bytes and back; damaged or cut bytes must be refused.
    fn through_bytes(&mut self, slot: usize, damage: Option<(f64, u8)>, cut: f64) {
        let (f, c) = (self.f, self.c);
        let Some(Slot { state, model }) = &self.slots[slot] else {
            // SAFETY: null is what the function is to stand.
            unsafe { assert_eq!((f.fmi2SerializedFMUstateSize)(c, null_mut(), &mut 0), ERROR) };
            return;
        };
        let mut size = 0;
        // SAFETY: an instance, a state that has not been freed, and as many bytes as it asks for.
        unsafe {
            assert_eq!((f.fmi2SerializedFMUstateSize)(c, *state, &mut size), OK);
            let mut bytes = vec![0_u8; size];
            assert_eq!(
                (f.fmi2SerializeFMUstate)(c, *state, bytes.as_mut_ptr().cast(), size),
                OK
            );
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                clippy::cast_precision_loss,
                reason = "a place among some thousand bytes"
            )]
            let place = |share: f64| (share * size as f64) as usize;
            if let Some((at, mask)) = damage {
                bytes[place(at)] ^= mask;
            }
            bytes.resize(place(cut), 0);
            let mut found = null_mut();
            let status = (f.fmi2DeSerializeFMUstate)(c, bytes.as_ptr().cast(), bytes.len(), &mut found);
            let whole = damage.is_none_or(|(at, _)| place(at) >= bytes.len()) && bytes.len() == size;
            assert_eq!(status, if whole { OK } else { ERROR });
            assert_eq!(found.is_null(), !whole);
            if whole {
                assert_eq!((f.fmi2SetFMUstate)(c, found), OK);
                assert_eq!((f.fmi2FreeFMUstate)(c, &mut found), OK);
                self.model = *model;
            }
        }
    }
}

fn references(which: impl Fn(Causality) -> bool) -> Vec<u32> {
    let table = VariatorUnit::table();
    let chosen = table.variables().iter().filter(|v| which(v.causality));
    chosen
        .filter(|v| matches!(v.kind, Kind::Real { .. }))
        .map(|v| v.reference)
        .collect()
}

/// Runs `cases` sequences of up to `length` calls.
fn check(cases: u32, length: usize, cheap: bool) {
    let library = Library::load();
    let outputs = references(|causality| causality == Causality::Output);
    let readings = references(|_| true);
    let config = Config {
        cases,
        failure_persistence: None,
        max_shrink_iters: 2000,
        ..Config::default()
    };
    // The same sequences every time; more cases go on from there.
    let seed = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let outcome = TestRunner::new_with_rng(config, seed).run(&vec(calls(), 1..length), |calls| {
        let mut master = Master {
            f: &library.functions,
            c: library.functions.instantiate(),
            cheap,
            model: FRESH,
            slots: [None, None, None],
            outputs: &outputs,
            readings: &readings,
        };
        master.after_reset();
        for call in &calls {
            master.make(call);
        }
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

#[test]
fn random_sequences_with_a_coarse_reference_ring() {
    check(count("PUSHBELT_SEQUENCES", 1000), 60, true);
}

#[test]
fn random_sequences_with_the_default_model() {
    check(count("PUSHBELT_DEFAULT_SEQUENCES", 3), 40, false);
}

/// The same under valgrind, where it is installed: no invalid access, no leak.
#[cfg(target_os = "linux")]
#[test]
fn valgrind_finds_nothing() {
    let test = std::env::current_exe().expect("a test has a path");
    let run = std::process::Command::new("valgrind")
        .args(["--quiet", "--error-exitcode=9", "--leak-check=full"])
        .args(["--errors-for-leak-kinds=definite", "--show-leak-kinds=definite"])
        .arg(test)
        .args([
            "--exact",
            "random_sequences_with_a_coarse_reference_ring",
            "--test-threads=1",
        ])
        .env("PUSHBELT_SEQUENCES", "12")
        .output();
    match run {
        Ok(output) => assert!(
            output.status.success(),
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(error) => eprintln!("not run: valgrind can't be started ({error})"),
    }
}
