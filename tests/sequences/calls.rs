//! Calls with random arguments, good and bad.

use std::ffi::c_int;
use std::ptr::{null, null_mut};

use proptest::collection::vec;
use proptest::prelude::*;
use pushbelt_lab::shared_library::reference;

/// The flaw of an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flaw {
    None,
    NullReferences,
    NullValues,
    UnknownReference,
    OtherType,
    NotFinite,
}

/// A value reference that no variable has.
pub const UNKNOWN: u32 = 77;

impl Flaw {
    /// Both pointers, or null for the one that is flawed.
    pub fn pointers<V>(self, references: *const u32, values: *mut V) -> (*const u32, *mut V) {
        match self {
            Self::NullReferences => (null(), values),
            Self::NullValues => (references, null_mut()),
            _ => (references, values),
        }
    }

    /// The reference of a variable, or a flawed one. No integer or boolean is called `thrustRatio`.
    pub fn reference(self, name: &str) -> u32 {
        match self {
            Self::UnknownReference => UNKNOWN,
            Self::OtherType => reference("thrustRatio"),
            _ => reference(name),
        }
    }

    /// Whether calls with integers and Booleans remain valid.
    pub fn harmless(self) -> bool {
        matches!(self, Self::None | Self::NotFinite)
    }
}

/// A call.
#[derive(Clone, Debug)]
pub enum Call {
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
    Keep(Keeping),
    Status {
        function: usize,
        kind: c_int,
        null: bool,
    },
    Cancel,
    Linearize {
        frequency: f64,
        null: bool,
    },
    NullInstance,
}

/// A call with stored states.
#[derive(Clone, Copy, Debug)]
pub enum Keeping {
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
}

/// Calls with stored states, each with its weight.
pub fn keeping() -> impl Strategy<Value = Keeping> {
    prop_oneof![
        3 => slot().prop_map(|slot| Keeping::Store { slot }),
        3 => slot().prop_map(|slot| Keeping::Restore { slot }),
        1 => slot().prop_map(|slot| Keeping::Drop { slot }),
        2 => through_bytes().prop_map(|(slot, damage, cut)| Keeping::ThroughBytes { slot, damage, cut }),
    ]
}

pub fn flaws() -> impl Strategy<Value = Flaw> {
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

/// Calls of all kinds, each with its weight.
pub fn calls() -> impl Strategy<Value = Call> {
    prop_oneof![
        2 => setup().prop_map(|(tolerance, start, stop)| Call::Setup { tolerance, start, stop }),
        3 => Just(Call::EnterInitialization),
        5 => Just(Call::ExitInitialization),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
        12 => step().prop_map(|(late, size)| Call::Step { late, size }),
        6 => (0..6_usize, -1.0..1.0, flaws()).prop_map(|(which, value, flaw)| Call::SetInput { which, value, flaw }),
        3 => (0..PARAMETERS.len(), 0.0..1.0, flaws())
            .prop_map(|(which, share, flaw)| Call::SetParameter { which, share, flaw }),
        1 => Just(Call::SetOutput),
        4 => (vec(0..500_usize, 0..9), flaws()).prop_map(|(which, flaw)| Call::GetReals { which, flaw }),
        1 => flaws().prop_map(|flaw| Call::GetIntegers { flaw }),
        2 => set_integer(),
        1 => (any::<bool>(), flaws()).prop_map(|(set, flaw)| Call::Boolean { set, flaw }),
        1 => (any::<bool>(), 0..2_usize).prop_map(|(set, length)| Call::String { set, length }),
        3 => derivative(),
        2 => output_derivative().prop_map(|(which, order, null)| Call::OutputDerivative { which, order, null }),
        1 => Just(Call::Directional),
        1 => logging().prop_map(|(on, name)| Call::Logging { on, name }),
        9 => keeping().prop_map(Call::Keep),
        2 => (0..5_usize, -1..5, prop::bool::weighted(0.1))
            .prop_map(|(function, kind, null)| Call::Status { function, kind, null }),
        1 => Just(Call::Cancel),
        1 => (prop_oneof![3 => Just(50.0), 1 => bad_number()], prop::bool::weighted(0.1))
            .prop_map(|(frequency, null)| Call::Linearize { frequency, null }),
        1 => Just(Call::NullInstance),
    ]
}

fn slot() -> impl Strategy<Value = usize> {
    0..3_usize
}

/// Tolerance, start and stop time.
pub fn setup() -> impl Strategy<Value = (Option<f64>, f64, Option<f64>)> {
    (
        prop_oneof![Just(None), Just(Some(1e-3)), bad_number().prop_map(Some)],
        prop_oneof![3 => Just(0.0), 1 => Just(1e6), 1 => Just(1.7e9), 1 => bad_number()],
        prop_oneof![2 => Just(None), 1 => Just(Some(2e6)), 1 => Just(Some(0.004)), 1 => bad_number().prop_map(Some)],
    )
}

/// By how much a step begins late, and its size.
pub fn step() -> impl Strategy<Value = (f64, f64)> {
    (
        prop_oneof![9 => Just(0.0), 1 => prop_oneof![Just(1e-3), Just(-1e-3), bad_number()]],
        prop_oneof![9 => 1e-5..2e-3, 1 => Just(5e-3), 2 => prop_oneof![bad_number(), Just(1e30), Just(1e-300)]],
    )
}

fn set_integer() -> impl Strategy<Value = Call> {
    (
        0..INTEGERS.len(),
        prop_oneof![Just(1), Just(2), Just(0), Just(-1), Just(c_int::MAX), Just(c_int::MIN)],
    )
        .prop_map(|(which, value)| Call::SetInteger { which, value })
}

fn derivative() -> impl Strategy<Value = Call> {
    (
        0..7_usize,
        prop_oneof![6 => Just(1), 1 => Just(0), 1 => Just(2), 1 => Just(-1)],
        prop_oneof![9 => -1e4..1e4, 1 => bad_number()],
    )
        .prop_map(|(which, order, value)| Call::Derivative { which, order, value })
}

/// Which output, order, and whether the place for the value is null.
pub fn output_derivative() -> impl Strategy<Value = (usize, c_int, bool)> {
    (
        0..50_usize,
        prop_oneof![6 => Just(1), 1 => Just(0), 1 => Just(2)],
        prop::bool::weighted(0.1),
    )
}

/// Whether on, and a category.
pub fn logging() -> impl Strategy<Value = (bool, Option<&'static str>)> {
    (
        any::<bool>(),
        prop_oneof![Just(None), Just(Some("logEvents")), Just(Some("noise"))],
    )
}

/// A slot, what is damaged (where, by which bits) and what is left.
fn through_bytes() -> impl Strategy<Value = (usize, Option<(f64, u8)>, f64)> {
    (
        slot(),
        prop::option::weighted(0.4, (0.0..1.0, 1..=u8::MAX)),
        prop_oneof![3 => Just(1.0), 1 => 0.0..1.1],
    )
}

/// Real parameters, with values that fit all others; other tests cover values that don't fit.
pub const PARAMETERS: &[(&str, f64, f64)] = &[
    ("friction.pulley", 0.05, 0.1),
    ("friction.ring", 0.0, 0.1),
    ("primary.inertia", 0.005, 0.2),
    ("secondary.sheaveDamping", 1e3, 1e4),
    ("initial.primarySpeed", 0.0, 300.0),
    ("initial.ratio", 0.7, 1.5),
];
pub const TUNABLE: usize = 2;

pub const INPUTS: [(&str, f64, f64); 6] = [
    ("primary.torque", 0.0, 300.0),
    ("secondary.torque", 0.0, 300.0),
    ("primary.clampingForce", 2e4, 2e4),
    ("secondary.clampingForce", 2e4, 2e4),
    ("primary.speedSetpoint", 200.0, 200.0),
    ("secondary.speedSetpoint", 200.0, 200.0),
];

pub const INTEGERS: [&str; 8] = [
    "primary.drive",
    "secondary.drive",
    "primary.axial",
    "secondary.axial",
    "mesh.primaryArc",
    "mesh.strand",
    "ring.model",
    "friction.pulley",
];
