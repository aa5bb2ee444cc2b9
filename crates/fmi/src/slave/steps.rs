//! Communication steps, and how the last one ended.

use super::instance::Slave;
use super::outcome::{Outcome, Trouble, refused};
use crate::log::Status;
use crate::state::{Call, State};
use crate::unit::{StepFailure, Unit};

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

/// Where a step leads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    /// For the unit, on its grid, s.
    pub to: f64,
    /// As the master counts, s.
    pub end: f64,
}

/// The unit, once it has been started.
pub(super) fn started<U>(unit: &mut Option<U>) -> Result<&mut U, Trouble> {
    unit.as_mut().ok_or_else(not_started)
}

fn not_started() -> Trouble {
    Trouble::Refused("the unit has not been initialised".into())
}

impl<U: Unit> Slave<U> {
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

    /// `fmi2GetIntegerStatus` and `fmi2GetStringStatus`: nothing of these types can be asked.
    pub fn no_status(&mut self, function: &'static str, kind: StatusKind) -> Status {
        self.status(function, |_| unknown_status(kind))
    }

    fn step(&mut self, current: f64, step: f64) -> Outcome {
        let ahead = self.ahead(current, step)?;
        let unit = started(&mut self.now.unit)?;
        let mut remarks = Vec::new();
        let rates = self.now.rates.take();
        let result = unit.advance(ahead.to, &self.now.settings, rates.as_ref(), &mut remarks);
        self.log_remarks(&remarks);
        self.ended(result, ahead.end)
    }

    /// Checks a step, and says where it leads.
    pub(super) fn ahead(&self, current: f64, step: f64) -> Result<Ahead, Trouble> {
        self.allow(Call::DoStep)?;
        let end = self.end_of_step(current, step)?;
        let unit = self.now.unit.as_ref().ok_or_else(not_started)?;
        // A longer step before may have ended on a coarser grid, just ahead.
        let to = communication_point(end, step).max(unit.time());
        Ok(Ahead { to, end })
    }

    /// Takes down how a step ended that was to lead to `end`, as the master counts.
    pub(super) fn ended(&mut self, result: Result<(), StepFailure>, end: f64) -> Outcome {
        match result {
            Ok(()) => {
                (self.now.state, self.now.point) = (State::StepComplete, end);
                Ok(())
            }
            Err(StepFailure::Setting(text) | StepFailure::Discarded(text)) => {
                let reached = started(&mut self.now.unit)?.time();
                (self.now.state, self.now.point) = (State::StepFailed, reached);
                Err(Trouble::Discarded(text))
            }
        }
    }

    /// Checks a step of size `step` from `current`, s; the communication point at which it ends, as the master counts.
    fn end_of_step(&self, current: f64, step: f64) -> Result<f64, Trouble> {
        let start = self.now.point;
        let longest = U::IDENTITY.longest_step;
        if !(current.is_finite() && step.is_finite() && step > 0.0) {
            return refused(format!(
                "a step of {step} s from {current} s is not a step forward in finite time"
            ));
        }
        if step > longest {
            return refused(format!("the step of {step} s is longer than the longest, {longest} s"));
        }
        if !same_time(current, start, step) {
            return refused(format!(
                "the step starts at {current} s, but the last one ended at {start} s"
            ));
        }
        let end = current + step;
        if end <= start {
            return refused(format!(
                "the step of {step} s is lost in the rounding of the time {start} s"
            ));
        }
        if let Some(stop) = self.now.experiment.stop
            && end > stop
            && !same_time(end, stop, step)
        {
            return refused(format!("the step to {end} s leads beyond the stop time {stop} s"));
        }
        Ok(end)
    }

    fn status(&mut self, function: &'static str, body: impl FnOnce(&mut Self) -> Outcome) -> Status {
        self.call(function, |slave| {
            slave.allow(Call::GetStatus)?;
            body(slave)
        })
    }
}

/// Rounding of a master that sums up its steps, as a share of the time.
const ROUNDING_OF_TIME: f64 = 1e-9;
/// The least difference between two communication points that is taken for rounding, as a share of the step.
const LEAST_ROUNDING: f64 = 1e-6;
/// The largest difference that is taken for rounding, as a share of the step: a user would not notice it.
const LARGEST_ROUNDING: f64 = 1e-3;

/// Whether two times are the same communication point, up to the rounding of a master that sums up its steps.
fn same_time(a: f64, b: f64, step: f64) -> bool {
    let size = a.abs().max(b.abs());
    let rounding = (ROUNDING_OF_TIME * size).clamp(LEAST_ROUNDING * step, LARGEST_ROUNDING * step);
    // A time is never more exact than its own rounding.
    (a - b).abs() <= rounding.max(4.0 * f64::EPSILON * size)
}

/// The largest power of ten that a double holds exactly is 10²².
const EXACT_POWERS_OF_TEN: f64 = 22.0;

/// The end of a step on a decimal grid of about a millionth of the step. Masters come to the same point by different
/// sums, off by some 1e-12; where a belt slips through, that grows to differences that a user sees. On the grid all
/// masters get the same bits.
fn communication_point(time: f64, step: f64) -> f64 {
    let digits = -(LEAST_ROUNDING * step).log10().floor();
    if digits > EXACT_POWERS_OF_TEN {
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
        "there is no status {kind:?}: each step is finished before it returns"
    )))
}
