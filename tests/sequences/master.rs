//! A master that makes calls and compares the instance with a model of the standard's state machine.

use std::ffi::{c_char, c_int};
use std::ptr::null_mut;

use pushbelt::fmi::fmi2::Component;
use pushbelt_lab::shared_library::{DISCARD, ERROR, Functions, OK, WARNING, reference};

use crate::calls::{Call, Flaw, INPUTS, INTEGERS, PARAMETERS, TUNABLE, UNKNOWN};
use crate::machine::*;
use crate::slots::Slots;

pub struct Master<'a> {
    f: &'a Functions,
    c: Component,
    cheap: bool,
    model: Model<State>,
    slots: Slots<Model<State>>,
    outputs: &'a [u32],
    readings: &'a [u32],
}

impl Drop for Master<'_> {
    fn drop(&mut self) {
        // SAFETY: the instance is not used any more.
        unsafe {
            self.slots.free_all(self.f, self.c);
            (self.f.fmi2FreeInstance)(self.c);
        }
    }
}

impl<'a> Master<'a> {
    /// A master of a new instance; with `cheap` it has a coarse reference ring. `outputs` and `readings` are references that
    /// the calls use.
    pub fn new(f: &'a Functions, cheap: bool, outputs: &'a [u32], readings: &'a [u32]) -> Self {
        let mut master = Self {
            f,
            c: f.instantiate(),
            cheap,
            model: Model::FRESH,
            slots: Slots::empty(),
            outputs,
            readings,
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
        match *call {
            Call::Setup { tolerance, start, stop } => self.setup(call, tolerance, start, stop),
            Call::EnterInitialization => self.enter_initialization(call),
            Call::ExitInitialization => self.exit_initialization(call),
            Call::Terminate => self.terminate(call),
            Call::Reset => self.reset(),
            Call::Step { late, size } => self.step(call, late, size),
            Call::SetInput { which, value, flaw } => self.set_input(call, which, value, flaw),
            Call::SetParameter { which, share, flaw } => self.set_parameter(call, which, share, flaw),
            Call::SetOutput => self.set_output(call),
            Call::GetReals { ref which, flaw } => self.get_reals(call, which, flaw),
            Call::GetIntegers { flaw } => self.get_integers(call, flaw),
            Call::SetInteger { which, value } => self.set_integer(call, INTEGERS[which], value),
            Call::Boolean { set: true, flaw } => self.set_boolean(call, flaw),
            Call::Boolean { set: false, flaw } => self.get_boolean(call, flaw),
            Call::String { set, length } => self.string(call, set, length),
            Call::Derivative { which, order, value } => self.derivative(call, which, order, value),
            Call::OutputDerivative { which, order, null } => self.output_derivative(call, which, order, null),
            Call::Directional => self.directional(call),
            Call::Logging { on, name } => self.logging(call, on, name),
            Call::Keep(keeping) => {
                // SAFETY: an instance.
                let kept = unsafe { self.slots.keep(self.f, self.c, keeping, self.model) };
                self.model = kept.in_instance_of(&self.model);
            }
            Call::Status { function, kind, null } => self.status(call, function, kind, null),
            Call::Cancel => self.cancel(),
            Call::Linearize { frequency, null } => self.linearize(call, frequency, null),
            Call::NullInstance => self.null_instance(),
        }
    }

    fn setup(&mut self, call: &Call, tolerance: Option<f64>, start: f64, stop: Option<f64>) {
        // SAFETY: an instance.
        let status = unsafe {
            (self.f.fmi2SetupExperiment)(
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
            (self.model.time, self.model.stop) = (start, stop);
        }
    }

    fn enter_initialization(&mut self, call: &Call) {
        // SAFETY: an instance.
        let status = unsafe { (self.f.fmi2EnterInitializationMode)(self.c) };
        self.model.moves(call, status, &[Instantiated], Initialisation);
    }

    fn exit_initialization(&mut self, call: &Call) {
        // SAFETY: an instance.
        let status = unsafe { (self.f.fmi2ExitInitializationMode)(self.c) };
        self.model.moves(call, status, &[Initialisation], StepComplete);
    }

    fn terminate(&mut self, call: &Call) {
        // SAFETY: an instance.
        let status = unsafe { (self.f.fmi2Terminate)(self.c) };
        self.model.moves(call, status, RUNNING, Terminated);
    }

    fn reset(&mut self) {
        // SAFETY: an instance.
        assert_eq!(unsafe { (self.f.fmi2Reset)(self.c) }, OK);
        self.after_reset();
    }

    fn step(&mut self, call: &Call, late: f64, size: f64) {
        let from = self.model.time + late;
        let to = from + size;
        // SAFETY: an instance.
        let status = unsafe { (self.f.fmi2DoStep)(self.c, from, size, 1) };
        let good = late == 0.0
            && (0.0..1e3).contains(&size)
            && to > from
            && self.model.stop.is_none_or(|stop| to <= stop + 1e-6 * size);
        if good && status == DISCARD && RUNNING.contains(&self.model.state) {
            self.model.state = StepFailed;
            let mut reached = f64::NAN;
            // SAFETY: an instance and a place for the value.
            assert_eq!(unsafe { (self.f.fmi2GetRealStatus)(self.c, 2, &mut reached) }, OK);
            assert_eq!(reached, self.model.time, "after {call:?}");
            return;
        }
        self.model.expect(call, status, RUNNING, Expected::done_if(good));
        if status == OK {
            (self.model.state, self.model.time) = (StepComplete, to);
        }
    }

    fn set_input(&mut self, call: &Call, which: usize, value: f64, flaw: Flaw) {
        let (name, middle, width) = INPUTS[which];
        self.set_real(call, reference(name), middle + value * width, flaw, SET);
    }

    fn set_parameter(&mut self, call: &Call, which: usize, share: f64, flaw: Flaw) {
        let (name, low, high) = PARAMETERS[which];
        let states = if which < TUNABLE { SET } else { BEFORE };
        self.set_real(call, reference(name), low + share * (high - low), flaw, states);
    }

    fn set_output(&mut self, call: &Call) {
        // SAFETY: an instance, one reference, one value.
        let status = unsafe { (self.f.fmi2SetReal)(self.c, &reference("thrustRatio"), 1, &1.0) };
        self.model.expect(call, status, ANY, Expected::Refused);
    }

    fn get_reals(&mut self, call: &Call, which: &[usize], flaw: Flaw) {
        let mut references: Vec<u32> = which
            .iter()
            .map(|which| self.readings[which % self.readings.len()])
            .collect();
        match flaw {
            Flaw::UnknownReference => references.push(UNKNOWN),
            Flaw::OtherType => references.push(reference("macroSlip")),
            _ => {}
        }
        let nulls = matches!(flaw, Flaw::NullReferences | Flaw::NullValues);
        let good = matches!(flaw, Flaw::None | Flaw::NotFinite) || nulls && references.is_empty();
        let mut values = vec![f64::NAN; references.len()];
        let (from, to) = flaw.pointers(references.as_ptr(), values.as_mut_ptr());
        // SAFETY: an instance; arrays have the given lengths, or are null.
        let status = unsafe { (self.f.fmi2GetReal)(self.c, from, references.len(), to) };
        self.model.expect(call, status, GET, Expected::done_if(good));
        if status == OK {
            assert!(values.iter().all(|value| value.is_finite()), "{call:?}: {values:?}");
        }
    }

    fn get_integers(&mut self, call: &Call, flaw: Flaw) {
        let wanted = flaw.reference("primary.drive");
        let mut value = -1;
        let (from, to) = flaw.pointers(&wanted, &mut value);
        // SAFETY: an instance, one reference and one value, or null.
        let status = unsafe { (self.f.fmi2GetInteger)(self.c, from, 1, to) };
        self.model.expect(call, status, GET, Expected::done_if(flaw.harmless()));
    }

    fn set_integer(&mut self, call: &Call, name: &str, value: c_int) {
        // Meshes and ring models that would make a cheap instance expensive are not set.
        let expensive = matches!(name, "mesh.primaryArc" | "mesh.strand" | "ring.model") && value > 0;
        if expensive && value < c_int::MAX {
            return;
        }
        // SAFETY: an instance, one reference, one value.
        let status = unsafe { (self.f.fmi2SetInteger)(self.c, &reference(name), 1, &value) };
        let legal = match name {
            "friction.pulley" => Expected::Refused,
            _ if (1..3).contains(&value) => Expected::Done,
            _ => Expected::Discarded,
        };
        self.model.expect(call, status, BEFORE, legal);
    }

    fn set_boolean(&mut self, call: &Call, flaw: Flaw) {
        let wanted = flaw.reference("initial.equilibrium");
        let mut value = 0;
        let (from, values) = flaw.pointers(&wanted, &mut value);
        // SAFETY: an instance, one reference and one value, or null.
        let status = unsafe { (self.f.fmi2SetBoolean)(self.c, from, 1, values) };
        self.model
            .expect(call, status, BEFORE, Expected::done_if(flaw.harmless()));
    }

    fn get_boolean(&mut self, call: &Call, flaw: Flaw) {
        let wanted = flaw.reference("macroSlip");
        let mut value = 0;
        let (from, to) = flaw.pointers(&wanted, &mut value);
        // SAFETY: an instance, one reference and one value, or null.
        let status = unsafe { (self.f.fmi2GetBoolean)(self.c, from, 1, to) };
        self.model.expect(call, status, GET, Expected::done_if(flaw.harmless()));
    }

    fn string(&mut self, call: &Call, set: bool, length: usize) {
        let mut value: *const c_char = c"text".as_ptr();
        // SAFETY: an instance, at most one reference and one value.
        let (status, states) = unsafe {
            if set {
                ((self.f.fmi2SetString)(self.c, &1, length, &value), SET)
            } else {
                ((self.f.fmi2GetString)(self.c, &1, length, &mut value), GET)
            }
        };
        self.model.expect(call, status, states, Expected::done_if(length == 0));
    }

    fn derivative(&mut self, call: &Call, which: usize, order: c_int, value: f64) {
        let known = INPUTS.get(which);
        let wanted = known.map_or(UNKNOWN, |(name, ..)| reference(name));
        // SAFETY: an instance, one reference, one order, one value.
        let status = unsafe { (self.f.fmi2SetRealInputDerivatives)(self.c, &wanted, 1, &order, &value) };
        let legal = Expected::done_if(known.is_some() && order == 1 && value.is_finite());
        self.model.expect(call, status, SET, legal);
    }

    fn output_derivative(&mut self, call: &Call, which: usize, order: c_int, null: bool) {
        let wanted = self.outputs.get(which).copied();
        let mut value = f64::NAN;
        let to: *mut f64 = if null { null_mut() } else { &mut value };
        // SAFETY: an instance, one reference and one order, one value or null.
        let status =
            unsafe { (self.f.fmi2GetRealOutputDerivatives)(self.c, &wanted.unwrap_or(UNKNOWN), 1, &order, to) };
        let legal = Expected::done_if(wanted.is_some() && order == 1 && !null);
        self.model
            .expect(call, status, &[StepComplete, StepFailed, Terminated, Error], legal);
        assert!(status != OK || value.is_finite(), "{call:?}: {value}");
    }

    fn directional(&mut self, call: &Call) {
        // SAFETY: an instance, one reference each, one value each.
        let status = unsafe { (self.f.fmi2GetDirectionalDerivative)(self.c, &1, 1, &101, 1, &1.0, &mut 0.0) };
        self.model.expect(call, status, ANY, Expected::Refused);
    }

    fn logging(&mut self, call: &Call, on: bool, name: Option<&str>) {
        let text: Vec<u8> = name.iter().flat_map(|name| name.bytes()).chain([0]).collect();
        let pointer: *const c_char = text.as_ptr().cast();
        // SAFETY: an instance, and the given number of strings, each with its end.
        let status = unsafe { (self.f.fmi2SetDebugLogging)(self.c, on.into(), name.iter().count(), &pointer) };
        self.model
            .expect(call, status, ANY, Expected::done_if(name != Some("noise")));
    }

    fn status(&mut self, call: &Call, function: usize, kind: c_int, null: bool) {
        let (f, c) = (self.f, self.c);
        let (mut real, mut integer, mut text) = (0.0, 0, null_mut::<c_char>().cast_const());
        let number: *mut c_int = if null { null_mut() } else { &mut integer };
        let value: *mut f64 = if null { null_mut() } else { &mut real };
        // SAFETY: an instance, and a place for the value or null.
        let (status, known) = unsafe {
            match function {
                0 => ((f.fmi2GetStatus)(c, kind, number), kind == 0),
                1 => ((f.fmi2GetRealStatus)(c, kind, value), kind == 2),
                2 => ((f.fmi2GetBooleanStatus)(c, kind, number), kind == 3),
                3 => ((f.fmi2GetIntegerStatus)(c, kind, number), false),
                _ => ((f.fmi2GetStringStatus)(c, kind, &mut text), false),
            }
        };
        let null = null && function < 3;
        let wanted = match STATUS.contains(&self.model.state) {
            true if (0..4).contains(&kind) && !null => [DISCARD, OK][usize::from(known)],
            _ => ERROR,
        };
        assert_eq!(status, wanted, "{call:?} with {:?}", self.model);
    }

    fn cancel(&self) {
        // SAFETY: an instance.
        assert_eq!(unsafe { (self.f.fmi2CancelStep)(self.c) }, ERROR);
    }

    /// Whether there is a model depends on the belt; the instance continues in both cases.
    fn linearize(&self, call: &Call, frequency: f64, null: bool) {
        let mut text = null_mut();
        let place: *mut *mut c_char = if null { null_mut() } else { &mut text };
        // SAFETY: an instance, a place for the text or null, and a text of this call or null.
        unsafe {
            let status = (self.f.pushbeltLinearize)(self.c, frequency, place);
            let possible = GET.contains(&self.model.state) && !null && (0.01..=1e5).contains(&frequency);
            assert!(
                status == ERROR || possible && (status == OK || status == WARNING),
                "{call:?}: {status}"
            );
            assert_eq!(text.is_null(), status == ERROR, "{call:?}");
            (self.f.pushbeltFreeText)(text);
        }
    }

    fn null_instance(&self) {
        // SAFETY: the functions accept null.
        unsafe {
            (self.f.fmi2FreeInstance)(null_mut());
            assert_eq!((self.f.fmi2DoStep)(null_mut(), 0.0, 1e-3, 1), ERROR);
            assert_eq!((self.f.fmi2GetReal)(null_mut(), &1, 1, &mut 0.0), ERROR);
            assert_eq!((self.f.pushbeltLinearize)(null_mut(), 50.0, &mut null_mut()), ERROR);
            (self.f.pushbeltFreeText)(null_mut());
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
        let status = unsafe { (self.f.fmi2SetReal)(self.c, from, references.len(), to) };
        let legal = match flaw {
            Flaw::None => Expected::Done,
            Flaw::NotFinite => Expected::Discarded,
            _ => Expected::Refused,
        };
        self.model.expect(call, status, states, legal);
    }
}
