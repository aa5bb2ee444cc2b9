//! Calls with random arguments, good and bad.

use proptest::collection::vec;
use proptest::prelude::*;
use pushbelt::fmi::unit::Experiment;

#[derive(Clone, Debug)]
pub enum Call {
    /// Sets up the experiment and enters initialisation mode.
    Enter(Experiment),
    Exit,
    /// In FMI 3.0 only, as the next one.
    EnterEvent,
    EnterStep,
    Terminate,
    Reset,
    /// By how much a step begins late, its size, and the importer's action in its intermediate
    /// updates.
    Step(f64, f64, Answer),
    /// Sets one of [`REALS`] to a share of its range.
    SetReal(usize, f64),
    /// Reads some of all real variables.
    GetReals(Vec<usize>),
    /// Sets one of [`INTEGERS`].
    SetInteger(usize, i32),
    /// Sets a derivative of one of [`REALS`], in FMI 2.0.
    InputDerivative(usize, i32, f64),
    OutputDerivative(usize, i32),
    Store(usize),
    Restore(usize),
    Free(usize),
    /// Continues from the bytes of the present state.
    ThroughBytes,
    /// Below this frequency, Hz.
    Linearize(f64),
}

/// Action of the importer in intermediate update mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    Nothing,
    /// Sets the announced torque.
    Set(f64),
    /// Requests an early return at this time after the present, s.
    Return(f64),
}

fn bad_number() -> impl Strategy<Value = f64> {
    proptest::sample::select(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0][..])
}

fn experiment() -> impl Strategy<Value = Call> {
    let tolerance = prop_oneof![4 => Just(None), 2 => Just(Some(1e-3)), 1 => bad_number().prop_map(Some)];
    let start = prop_oneof![4 => Just(0.0), 1 => Just(1e6), 1 => Just(1.7e9), 1 => bad_number()];
    let stop = prop_oneof![4 => Just(None), 1 => Just(Some(2e6)), 1 => Just(Some(0.004)), 1 => bad_number().prop_map(Some)];
    (tolerance, start, stop).prop_map(|(tolerance, start, stop)| {
        Call::Enter(Experiment {
            tolerance,
            start,
            stop,
        })
    })
}

fn step() -> impl Strategy<Value = Call> {
    let late = prop_oneof![9 => Just(0.0), 1 => prop_oneof![Just(1e-3), Just(-1e-3), bad_number()]];
    let bad = prop_oneof![bad_number(), Just(1e30)];
    let size = prop_oneof![9 => 1e-5..2e-3, 1 => Just(5e-3), 1 => Just(1e-300), 1 => Just(1e-17), 1 => bad];
    let later = proptest::sample::select(&[0.0, 1e-4, 1.0, f64::NAN, -1.0][..]);
    let answer = prop_oneof![
        4 => Just(Answer::Nothing),
        2 => (-100.0..100.0).prop_map(Answer::Set),
        1 => Just(Answer::Set(f64::NAN)),
        2 => later.prop_map(Answer::Return),
    ];
    (late, size, answer).prop_map(|(late, size, answer)| Call::Step(late, size, answer))
}

/// Calls of all kinds, each with its weight.
pub fn calls() -> impl Strategy<Value = Call> {
    let number = proptest::sample::select(&[1, 2, 0, -1, i32::MAX, i32::MIN][..]);
    let order = || prop_oneof![6 => Just(1), 1 => Just(0), 1 => Just(2)];
    let derivative = (0..REALS.len(), order(), prop_oneof![9 => -1e4..1e4, 1 => bad_number()]);
    let frequency = prop_oneof![3 => Just(50.0), 1 => bad_number()];
    let lifecycle = prop_oneof![
        4 => experiment(),
        5 => Just(Call::Exit),
        3 => Just(Call::EnterEvent),
        5 => Just(Call::EnterStep),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
    ];
    let values = prop_oneof![
        9 => (0..REALS.len(), 0.0..1.0).prop_map(|(which, share)| Call::SetReal(which, share)),
        4 => vec(0..500_usize, 0..9).prop_map(Call::GetReals),
        2 => (0..INTEGERS.len(), number).prop_map(|(which, value)| Call::SetInteger(which, value)),
        3 => derivative.prop_map(|(which, order, value)| Call::InputDerivative(which, order, value)),
        2 => (0..50_usize, order()).prop_map(|(which, order)| Call::OutputDerivative(which, order)),
    ];
    let states = prop_oneof![
        3 => (0..SLOTS).prop_map(Call::Store),
        3 => (0..SLOTS).prop_map(Call::Restore),
        1 => (0..SLOTS).prop_map(Call::Free),
        2 => Just(Call::ThroughBytes),
    ];
    prop_oneof![
        18 => lifecycle,
        14 => step(),
        24 => values,
        9 => states,
        1 => frequency.prop_map(Call::Linearize),
    ]
}

pub const SLOTS: usize = 3;

/// Real settings, and limits between which they fit all others; other tests cover values that don't
/// fit.
pub const REALS: [(&str, f64, f64); 12] = [
    ("primary.torque", -300.0, 300.0),
    ("secondary.torque", -300.0, 300.0),
    ("primary.clampingForce", 0.0, 4e4),
    ("secondary.clampingForce", 0.0, 4e4),
    ("primary.speedSetpoint", 0.0, 400.0),
    ("secondary.speedSetpoint", 0.0, 400.0),
    ("friction.pulley", 0.05, 0.1),
    ("friction.ring", 0.0, 0.1),
    ("primary.inertia", 0.005, 0.2),
    ("secondary.sheaveDamping", 1e3, 1e4),
    ("initial.primarySpeed", 0.0, 300.0),
    ("initial.ratio", 0.7, 1.5),
];

pub const INTEGERS: [&str; 7] = [
    "primary.drive",
    "secondary.drive",
    "primary.axial",
    "secondary.axial",
    "mesh.primaryArc",
    "mesh.strand",
    "ring.model",
];
