//! Calls of FMI 3.0 with random arguments, good and bad.

use std::ffi::c_int;

use proptest::collection::vec;
use proptest::prelude::*;

use crate::calls::{Flaw, INTEGERS, Keeping, PARAMETERS, flaws, keeping, logging, output_derivative, setup, step};

/// A call.
#[derive(Clone, Debug)]
pub enum Call {
    EnterInitialization {
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    },
    ExitInitialization,
    EnterEvent,
    UpdateDiscrete {
        null: bool,
    },
    EnterStep,
    Terminate,
    Reset,
    Step {
        late: f64,
        size: f64,
        answer: Answer,
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
        /// Values more or less than the variables have.
        more: isize,
    },
    SetInteger {
        which: usize,
        value: c_int,
    },
    Choice {
        set: bool,
        value: i64,
    },
    Boolean {
        set: bool,
        flaw: Flaw,
    },
    NoSuchType {
        function: usize,
        length: usize,
    },
    OutputDerivative {
        which: usize,
        order: c_int,
        null: bool,
    },
    NotOffered {
        function: usize,
    },
    Logging {
        on: bool,
        name: Option<&'static str>,
    },
    Keep(Keeping),
    NullInstance,
}

/// Action of the master in intermediate update mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    Nothing,
    /// Sets the announced torque.
    Set(f64),
    /// Requests an early return at this time after the present, s.
    Return(f64),
    /// Makes calls that are not allowed there.
    Meddle,
}

fn answer() -> impl Strategy<Value = Answer> {
    prop_oneof![
        4 => Just(Answer::Nothing),
        2 => (-100.0..100.0).prop_map(Answer::Set),
        1 => Just(Answer::Set(f64::NAN)),
        2 => prop_oneof![Just(0.0), Just(1e-4), Just(1.0), Just(f64::NAN), Just(-1.0)].prop_map(Answer::Return),
        1 => Just(Answer::Meddle),
    ]
}

fn reading() -> impl Strategy<Value = Call> {
    let more = prop_oneof![9 => Just(0), 1 => Just(1), 1 => Just(-1)];
    (vec(0..500_usize, 0..9), flaws(), more).prop_map(|(which, flaw, more)| Call::GetReals { which, flaw, more })
}

fn set_integer() -> impl Strategy<Value = Call> {
    let value = prop_oneof![Just(1), Just(2), Just(0), Just(-1), Just(c_int::MAX), Just(c_int::MIN)];
    (0..INTEGERS.len(), value).prop_map(|(which, value)| Call::SetInteger { which, value })
}

fn choice() -> impl Strategy<Value = Call> {
    let value = prop_oneof![Just(1), Just(2), Just(0), Just(-1), Just(i64::MAX), Just(1 << 32 | 1)];
    (any::<bool>(), value).prop_map(|(set, value)| Call::Choice { set, value })
}

/// Calls of all kinds, each with its weight.
pub fn calls() -> impl Strategy<Value = Call> {
    prop_oneof![
        4 => setup().prop_map(|(tolerance, start, stop)| Call::EnterInitialization { tolerance, start, stop }),
        5 => Just(Call::ExitInitialization),
        3 => Just(Call::EnterEvent),
        2 => prop::bool::weighted(0.1).prop_map(|null| Call::UpdateDiscrete { null }),
        5 => Just(Call::EnterStep),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
        14 => (step(), answer()).prop_map(|((late, size), answer)| Call::Step { late, size, answer }),
        6 => (0..6_usize, -1.0..1.0, flaws()).prop_map(|(which, value, flaw)| Call::SetInput { which, value, flaw }),
        3 => (0..PARAMETERS.len(), 0.0..1.0, flaws())
            .prop_map(|(which, share, flaw)| Call::SetParameter { which, share, flaw }),
        1 => Just(Call::SetOutput),
        4 => reading(),
        2 => set_integer(),
        2 => choice(),
        1 => (any::<bool>(), flaws()).prop_map(|(set, flaw)| Call::Boolean { set, flaw }),
        1 => (0..6_usize, 0..2_usize).prop_map(|(function, length)| Call::NoSuchType { function, length }),
        2 => output_derivative().prop_map(|(which, order, null)| Call::OutputDerivative { which, order, null }),
        2 => (0..12_usize).prop_map(|function| Call::NotOffered { function }),
        1 => logging().prop_map(|(on, name)| Call::Logging { on, name }),
        9 => keeping().prop_map(Call::Keep),
        1 => Just(Call::NullInstance),
    ]
}
