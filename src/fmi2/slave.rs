//! One instance, in the order of the standard's state machine.
//!
//! Every call ends in one of four ways. *Done*. *Refused* (wrong state, unknown value reference, nothing to offer):
//! an error for the master, and nothing has changed. *Failed* (a value out of range, no initial state, a panic): an
//! error, after which only [`Slave::reset`], a stored state or the end of the instance go on. *Discarded*: a step
//! that came only so far.

use std::any::Any;
use std::cell::OnceCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::description::guid;
use super::log::{Category, Log, Sink, Status};
use super::snapshot::{Snapshot, still};
use super::state::{Call, State};
use super::table::{Access, Causality, Inadmissible, Kind, Table, Variable};
use super::unit::{Experiment, StepFailure, Unit};

/// Why a call did not do what it was asked to.
#[derive(Debug)]
enum Trouble {
    Refused(String),
    Failed(String),
    Discarded(String),
}

impl From<Inadmissible> for Trouble {
    fn from(reason: Inadmissible) -> Self {
        Self::Failed(reason.to_string())
    }
}

type Outcome = Result<(), Trouble>;

fn refused<T>(text: impl Into<String>) -> Result<T, Trouble> {
    Err(Trouble::Refused(text.into()))
}

/// What can be asked after a step (`fmi2StatusKind`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// How the last step ended.
    DoStep,
    /// What a pending step is doing; no step is ever pending.
    Pending,
    /// Time reached, s.
    LastSuccessfulTime,
    /// Whether the slave wants the run to end; it never does.
    Terminated,
}

/// An instance of a unit.
pub struct Slave<U: Unit> {
    table: Table<U::Settings, U::Readings>,
    log: Log,
    debug: bool,
    /// Written once: it is a hash of the whole description.
    guid: OnceCell<String>,
    now: Snapshot<U>,
}

impl<U: Unit> Slave<U> {
    /// A new instance that logs into `sink`.
    #[must_use]
    pub fn new(sink: Option<Box<dyn Sink>>, debug: bool) -> Self {
        Self {
            table: U::table(),
            log: Log::new(sink, debug),
            debug,
            guid: OnceCell::new(),
            now: Snapshot::new(),
        }
    }

    fn guid(&self) -> &str {
        self.guid.get_or_init(guid::<U>)
    }

    /// State of the state machine.
    #[must_use]
    pub fn state(&self) -> State {
        self.now.state
    }

    /// `fmi2SetDebugLogging`: with no category all of them.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Status {
        self.call("fmi2SetDebugLogging", |slave| {
            let mut chosen = Vec::new();
            for name in categories {
                if *name == "logAll" {
                    chosen.extend(Category::ALL);
                } else if let Some(known) = Category::ALL.into_iter().find(|c| c.name() == *name) {
                    chosen.push(known);
                } else {
                    let all = Category::ALL.map(Category::name).join(", ");
                    return refused(format!("no log category {name:?}; there are {all}, logAll"));
                }
            }
            slave.log.choose(on, &chosen);
            Ok(())
        })
    }

    /// `fmi2SetupExperiment`.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Status {
        self.call("fmi2SetupExperiment", |slave| {
            slave.allow(Call::SetupExperiment)?;
            let Experiment { tolerance, start, stop } = experiment;
            if !start.is_finite() {
                return refused(format!("the start time {start} is not a finite number"));
            }
            if let Some(stop) = stop
                && (!stop.is_finite() || stop < start)
            {
                return refused(format!(
                    "the stop time {stop} s is not at or after the start time {start} s"
                ));
            }
            if let Some(tolerance) = tolerance
                && !(tolerance.is_finite() && tolerance > 0.0)
            {
                return refused(format!("the tolerance {tolerance} is not above 0"));
            }
            slave.now.experiment = experiment;
            Ok(())
        })
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter_initialization_mode(&mut self) -> Status {
        self.call("fmi2EnterInitializationMode", |slave| {
            slave.allow(Call::EnterInitializationMode)?;
            slave.now.state = State::Initialisation;
            Ok(())
        })
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization_mode(&mut self) -> Status {
        self.call("fmi2ExitInitializationMode", |slave| {
            slave.allow(Call::ExitInitializationMode)?;
            slave.start_unit()?;
            slave.now.state = State::StepComplete;
            Ok(())
        })
    }

    /// `fmi2DoStep`.
    pub fn do_step(&mut self, current: f64, step: f64) -> Status {
        self.call("fmi2DoStep", |slave| slave.step(current, step))
    }

    /// `fmi2CancelStep`.
    pub fn cancel_step(&mut self) -> Status {
        self.call("fmi2CancelStep", |slave| {
            slave.allow(Call::CancelStep)?;
            Ok(())
        })
    }

    /// `fmi2Terminate`.
    pub fn terminate(&mut self) -> Status {
        self.call("fmi2Terminate", |slave| {
            slave.allow(Call::Terminate)?;
            slave.now.state = State::Terminated;
            Ok(())
        })
    }

    /// `fmi2Reset`: as freshly instantiated, in every state.
    pub fn reset(&mut self) -> Status {
        self.call("fmi2Reset", |slave| {
            slave.allow(Call::Always)?;
            slave.now = Snapshot::new();
            slave.log.choose(slave.debug, &[]);
            Ok(())
        })
    }

    /// `fmi2GetReal`.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status {
        self.call("fmi2GetReal", |slave| slave.get(references, values, real_access, |v| v))
    }

    /// `fmi2GetInteger`, for integers and enumerations.
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.call("fmi2GetInteger", |slave| {
            slave.get(references, values, integer_access, |v| v)
        })
    }

    /// `fmi2GetBoolean`, 0 or 1.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.call("fmi2GetBoolean", |slave| {
            slave.get(references, values, boolean_access, i32::from)
        })
    }

    /// `fmi2GetString` and `fmi2SetString`: there are no strings.
    pub fn no_strings(&mut self, function: &'static str, call: Call, references: &[u32]) -> Status {
        self.call(function, |slave| {
            slave.allow(call)?;
            match references.first() {
                None => Ok(()),
                Some(reference) => refused(format!("no string has the value reference {reference}")),
            }
        })
    }

    /// `fmi2SetReal`. Either all values are taken or none.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        self.call("fmi2SetReal", |slave| {
            slave.set(
                references,
                values,
                real_access,
                |variable, value| variable.admit_real(value),
                |v| v,
            )
        })
    }

    /// `fmi2SetInteger`, for integers and enumerations. Either all values are taken or none.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.call("fmi2SetInteger", |slave| {
            slave.set(
                references,
                values,
                integer_access,
                |variable, value| variable.admit_integer(value),
                |v| v,
            )
        })
    }

    /// `fmi2SetBoolean`; what is not 0 is true. Either all values are taken or none.
    pub fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.call("fmi2SetBoolean", |slave| {
            slave.set(references, values, boolean_access, |_, v| Ok(v), |v| v != 0)
        })
    }

    /// `fmi2GetFMUstate`: the state, or `None` with the status if the call failed.
    pub fn save(&mut self) -> (Status, Option<Snapshot<U>>) {
        let mut saved = None;
        let status = self.call("fmi2GetFMUstate", |slave| {
            slave.allow(Call::Always)?;
            saved = Some(slave.now.clone());
            Ok(())
        });
        (status, saved)
    }

    /// `fmi2SetFMUstate`. The state may come from another instance.
    pub fn restore(&mut self, snapshot: &Snapshot<U>) -> Status {
        self.call("fmi2SetFMUstate", |slave| {
            slave.allow(Call::Always)?;
            slave.now = snapshot.clone();
            Ok(())
        })
    }

    /// `fmi2SerializeFMUstate`, and `fmi2SerializedFMUstateSize` by the length of what comes: the bytes, or `None` with
    /// the status if the call failed.
    pub fn serialize(&mut self, function: &'static str, snapshot: &Snapshot<U>) -> (Status, Option<Vec<u8>>) {
        let mut sealed = None;
        let status = self.call(function, |slave| {
            slave.allow(Call::Always)?;
            sealed = Some(
                snapshot
                    .to_bytes(&slave.table, slave.guid())
                    .map_err(Trouble::Refused)?,
            );
            Ok(())
        });
        (status, sealed)
    }

    /// `fmi2DeSerializeFMUstate`: the state, or `None` with the status if the bytes are not one.
    pub fn deserialize(&mut self, sealed: &[u8]) -> (Status, Option<Snapshot<U>>) {
        let mut found = None;
        let status = self.call("fmi2DeSerializeFMUstate", |slave| {
            slave.allow(Call::Always)?;
            found = Some(Snapshot::from_bytes(&slave.table, slave.guid(), sealed).map_err(Trouble::Refused)?);
            Ok(())
        });
        (status, found)
    }

    /// `fmi2SetRealInputDerivatives`: the inputs change in proportion to time during the next step, and are held again
    /// after it. Either all derivatives are taken or none.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Status {
        self.call("fmi2SetRealInputDerivatives", |slave| {
            slave.allow(Call::Set)?;
            for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
                let (variable, _) = find(&slave.table, reference, real_access)?;
                let name = &variable.name;
                if variable.causality != Causality::Input {
                    return refused(format!("{name} is no input"));
                }
                if order != 1 {
                    return refused(format!(
                        "{name}: inputs change in proportion to time, so derivatives have order 1, not {order}"
                    ));
                }
                if !value.is_finite() {
                    let name = format!("the derivative of {name}");
                    return Err(Inadmissible::NotFinite { name, value }.into());
                }
            }
            let rates = slave.now.rates.get_or_insert_with(|| still(&slave.table));
            for (&reference, &value) in references.iter().zip(values) {
                if let (_, Access::Setting { set, .. }) = find(&slave.table, reference, real_access)? {
                    set(rates, value);
                }
            }
            Ok(())
        })
    }

    /// `fmi2GetRealOutputDerivatives`: time derivatives of outputs at the present time.
    pub fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Status {
        self.call("fmi2GetRealOutputDerivatives", |slave| {
            slave.allow(Call::GetOutputDerivatives)?;
            for (&reference, &order) in references.iter().zip(orders) {
                let (variable, access) = find(&slave.table, reference, real_access)?;
                let name = &variable.name;
                if variable.causality != Causality::Output {
                    return refused(format!("{name} is no output"));
                }
                if matches!(access, Access::Element(..)) {
                    return refused(format!("{name} is an element of an array: these have no derivatives"));
                }
                if order != 1 {
                    return refused(format!(
                        "{name}: derivatives of outputs have order 1 (maxOutputDerivativeOrder), not {order}"
                    ));
                }
            }
            let Some(unit) = &mut slave.now.unit else {
                return refused("there are no calculated values after a failed start");
            };
            if references.is_empty() {
                return Ok(());
            }
            let moment = unit.moment();
            for (&reference, value) in references.iter().zip(values) {
                let (_, access) = find(&slave.table, reference, real_access)?;
                let change = match access {
                    Access::Reading(get) => get(&moment.after) - get(&moment.before),
                    Access::Element(..) | Access::Setting { .. } => 0.0,
                };
                *value = change / moment.span;
            }
            Ok(())
        })
    }

    /// `fmi2GetRealStatus`: the time reached, s.
    pub fn real_status(&mut self, kind: StatusKind, value: &mut f64) -> Status {
        self.status("fmi2GetRealStatus", |slave| match (kind, &slave.now.unit) {
            (StatusKind::LastSuccessfulTime, Some(_)) => {
                *value = slave.now.point;
                Ok(())
            }
            _ => unknown_status(kind),
        })
    }

    /// `fmi2GetBooleanStatus`: whether the slave wants the run to end.
    pub fn boolean_status(&mut self, kind: StatusKind, value: &mut i32) -> Status {
        self.status("fmi2GetBooleanStatus", |_| match kind {
            StatusKind::Terminated => {
                *value = 0;
                Ok(())
            }
            _ => unknown_status(kind),
        })
    }

    /// `fmi2GetStatus`: how the last step ended.
    pub fn step_status(&mut self, kind: StatusKind, value: &mut i32) -> Status {
        self.status("fmi2GetStatus", |slave| match kind {
            StatusKind::DoStep => {
                let ended = match slave.now.state {
                    State::StepFailed => Status::Discard,
                    _ => Status::Ok,
                };
                *value = ended as i32;
                Ok(())
            }
            _ => unknown_status(kind),
        })
    }

    /// `fmi2GetIntegerStatus` and `fmi2GetStringStatus`: nothing of these types can be asked.
    pub fn no_status(&mut self, function: &'static str, kind: StatusKind) -> Status {
        self.status(function, |_| unknown_status(kind))
    }

    /// A call that this slave does not offer, as its capability flags say.
    pub fn not_offered(&mut self, function: &'static str, why: &str) -> Status {
        self.refuse(function, &format!("not offered: {why}"))
    }

    /// Refuses a call whose arguments can't be used.
    pub fn refuse(&mut self, function: &'static str, why: &str) -> Status {
        self.call(function, |_| refused(why))
    }

    fn step(&mut self, current: f64, step: f64) -> Outcome {
        self.allow(Call::DoStep)?;
        let Some(unit) = &mut self.now.unit else {
            return refused("the unit has not been initialised");
        };
        let reached = self.now.point;
        let longest = U::IDENTITY.longest_step;
        if !(current.is_finite() && step.is_finite() && step > 0.0) {
            return refused(format!(
                "a step of {step} s from {current} s is not a step forward in finite time"
            ));
        }
        if step > longest {
            return refused(format!("the step of {step} s is longer than the longest, {longest} s"));
        }
        if !same_time(current, reached, step) {
            return refused(format!(
                "the step starts at {current} s, but the last one ended at {reached} s"
            ));
        }
        let end = current + step;
        if end <= reached {
            return refused(format!(
                "the step of {step} s is lost in the rounding of the time {reached} s"
            ));
        }
        if let Some(stop) = self.now.experiment.stop
            && end > stop
            && !same_time(end, stop, step)
        {
            return refused(format!("the step to {end} s leads beyond the stop time {stop} s"));
        }
        // A longer step before may have ended on a coarser grid, just ahead.
        let to = communication_point(end, step).max(unit.time());
        let mut remarks = Vec::new();
        let rates = self.now.rates.take();
        let result = unit.advance(to, &self.now.settings, rates.as_ref(), &mut remarks);
        let came_to = unit.time();
        self.pass_on(&remarks);
        match result {
            Ok(()) => {
                (self.now.state, self.now.point) = (State::StepComplete, end);
                Ok(())
            }
            Err(StepFailure::Setting(text)) => Err(Trouble::Failed(text)),
            Err(StepFailure::Discarded(text)) => {
                (self.now.state, self.now.point) = (State::StepFailed, came_to);
                Err(Trouble::Discarded(text))
            }
        }
    }

    fn start_unit(&mut self) -> Outcome {
        if self.now.unit.is_none() {
            let mut remarks = Vec::new();
            let started = U::start(&self.now.settings, &self.now.experiment, &mut remarks);
            self.pass_on(&remarks);
            self.now.unit = Some(started.map_err(Trouble::Failed)?);
            self.now.point = self.now.experiment.start;
        }
        Ok(())
    }

    fn pass_on(&self, remarks: &[super::unit::Remark]) {
        for remark in remarks {
            let (status, category) = if remark.warning {
                (Status::Warning, Category::Warning)
            } else {
                (Status::Ok, Category::Events)
            };
            self.log.send(status, category, &remark.text);
        }
    }

    fn get<T, V>(
        &mut self,
        references: &[u32],
        values: &mut [V],
        access: AccessOf<U, T>,
        convert: fn(T) -> V,
    ) -> Outcome {
        self.allow(Call::Get)?;
        let (mut calculated, mut elements) = (false, false);
        for &reference in references {
            let (_, access) = find(&self.table, reference, access)?;
            calculated |= !matches!(access, Access::Setting { .. });
            elements |= matches!(access, Access::Element(..));
        }
        if calculated {
            if self.now.state == State::Initialisation {
                self.start_unit()?;
            } else if self.now.unit.is_none() {
                return refused("there are no calculated values after a failed start");
            }
        }
        let Snapshot { settings, unit, .. } = &mut self.now;
        let readings = unit.as_mut().map(|unit| unit.readings(elements));
        for (&reference, value) in references.iter().zip(values) {
            let (_, access) = find(&self.table, reference, access)?;
            *value = convert(match (access, readings) {
                (Access::Setting { get, .. }, _) => get(settings),
                (Access::Reading(get), Some(readings)) => get(readings),
                (Access::Element(get, at), Some(readings)) => get(readings, *at),
                (_, None) => continue,
            });
        }
        Ok(())
    }

    fn set<T, V: Copy>(
        &mut self,
        references: &[u32],
        values: &[V],
        access: AccessOf<U, T>,
        admit: AdmissionOf<U, V>,
        convert: fn(V) -> T,
    ) -> Outcome {
        self.allow(Call::Set)?;
        let running = matches!(self.now.state, State::StepComplete | State::StepFailed);
        let mut tunes = false;
        for &reference in references {
            let (variable, _) = find(&self.table, reference, access)?;
            let name = &variable.name;
            match variable.causality {
                Causality::Output | Causality::Local => {
                    return refused(format!("{name} is calculated and can't be set"));
                }
                Causality::Parameter if running => {
                    return refused(format!("{name} is fixed once the run has started"));
                }
                Causality::Tunable => tunes = true,
                Causality::Parameter | Causality::Input => {}
            }
        }
        for (&reference, &value) in references.iter().zip(values) {
            admit(find(&self.table, reference, access)?.0, value)?;
        }
        // A tunable parameter must fit the others at once: there is no initialisation ahead that would check it.
        let before = (running && tunes).then(|| self.now.settings.clone());
        for (&reference, &value) in references.iter().zip(values) {
            if let (variable, Access::Setting { set, .. }) = find(&self.table, reference, access)? {
                set(&mut self.now.settings, convert(admit(variable, value)?));
            }
        }
        if let Some(before) = before
            && let Err(text) = U::check(&self.now.settings)
        {
            self.now.settings = before;
            return Err(Trouble::Failed(text));
        }
        if !running {
            self.now.unit = None;
        }
        Ok(())
    }

    fn allow(&self, call: Call) -> Outcome {
        if call.allowed_in(self.now.state) {
            return Ok(());
        }
        let advice = match self.now.state {
            State::Error => "; reset it or restore a stored state",
            _ => "",
        };
        refused(format!(
            "not allowed while the instance is {}{advice}",
            self.now.state.name()
        ))
    }

    fn status(&mut self, function: &'static str, body: impl FnOnce(&mut Self) -> Outcome) -> Status {
        self.call(function, |slave| {
            slave.allow(Call::GetStatus)?;
            body(slave)
        })
    }

    /// Runs a call, logs what went wrong and contains a panic within this instance.
    fn call(&mut self, function: &'static str, body: impl FnOnce(&mut Self) -> Outcome) -> Status {
        let outcome = catch_unwind(AssertUnwindSafe(|| body(self))).unwrap_or_else(|panic| {
            // What the panic left behind is not to be trusted.
            let broken = self.now.unit.take();
            drop(catch_unwind(AssertUnwindSafe(|| drop(broken))));
            Err(Trouble::Failed(format!(
                "internal error, please report: {}",
                panic_text(panic.as_ref())
            )))
        });
        let (status, category, text) = match outcome {
            Ok(()) => return Status::Ok,
            Err(Trouble::Refused(text)) => (Status::Error, Category::Error, text),
            Err(Trouble::Failed(text)) => {
                self.now.state = State::Error;
                (Status::Error, Category::Error, text)
            }
            Err(Trouble::Discarded(text)) => (Status::Discard, Category::Discard, text),
        };
        self.log.send(status, category, &format!("{function}: {text}"));
        status
    }
}

/// Same communication point, up to the rounding of a master that sums up its steps: a billionth of the time and a
/// millionth of the step, but never a noticeable part of the step.
fn same_time(a: f64, b: f64, step: f64) -> bool {
    let size = a.abs().max(b.abs());
    let rounding = (1e-9 * size).clamp(1e-6 * step, 1e-3 * step);
    (a - b).abs() <= rounding.max(4.0 * f64::EPSILON * size)
}

/// The end of a step on a decimal grid of about a millionth of the step. Masters come to the same point by different
/// sums, off by some 1e-12; where a belt slips through that grows to differences that a user sees, unless all masters
/// get the same bits.
fn communication_point(time: f64, step: f64) -> f64 {
    let digits = -(1e-6 * step).log10().floor();
    if digits > 22.0 {
        return time;
    }
    #[expect(clippy::cast_possible_truncation, reason = "at most 22")]
    let grid = 10_f64.powi(digits.max(0.0) as i32);
    let count = (time * grid).round();
    let exact = 1.0 / f64::EPSILON;
    if count.abs() < exact { count / grid } else { time }
}

fn unknown_status(kind: StatusKind) -> Outcome {
    Err(Trouble::Discarded(format!(
        "{kind:?} is not known by a slave that finishes each step before it returns"
    )))
}

type AccessOf<U, T> = fn(
    &Kind<<U as Unit>::Settings, <U as Unit>::Readings>,
) -> Option<&Access<<U as Unit>::Settings, <U as Unit>::Readings, T>>;

type AdmissionOf<U, V> = fn(&Variable<<U as Unit>::Settings, <U as Unit>::Readings>, V) -> Result<V, Inadmissible>;

fn real_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, f64>> {
    match kind {
        Kind::Real { access, .. } => Some(access),
        _ => None,
    }
}

fn integer_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, i32>> {
    match kind {
        Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => Some(access),
        _ => None,
    }
}

fn boolean_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, bool>> {
    match kind {
        Kind::Boolean { access } => Some(access),
        _ => None,
    }
}

#[expect(clippy::type_complexity, reason = "a variable with its access, used only here")]
fn find<S, R, T>(
    table: &Table<S, R>,
    reference: u32,
    access: fn(&Kind<S, R>) -> Option<&Access<S, R, T>>,
) -> Result<(&Variable<S, R>, &Access<S, R, T>), Trouble> {
    let Some(variable) = table.by_reference(reference) else {
        return refused(format!("no variable has the value reference {reference}"));
    };
    match access(&variable.kind) {
        Some(access) => Ok((variable, access)),
        None => refused(format!(
            "{} (value reference {reference}) has another type",
            variable.name
        )),
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("panic without a message")
}
