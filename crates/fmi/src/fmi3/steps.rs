//! Communication steps, with intermediate update mode.
//!
//! The master is called back between two borrows of the instance, never within one: from its callback it calls functions on the
//! same instance.

use super::boundary::{NULL_RESULT, with, with_any};
use super::instance::{Ending, Next, Question};
use super::types::{Boolean, Instance};
use crate::log::Status;
use crate::stepping::OwnSteps;

/// `fmi3DoStep`: advances by one communication step, or to an event or where the master wants to return if it allows that. Whether
/// the master will come back before this point does not matter here: states are stored on request only.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
#[expect(clippy::too_many_arguments, reason = "the standard's")]
pub unsafe fn do_step<U: OwnSteps>(
    c: Instance,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: Boolean,
    event_handling_needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut f64,
) -> Status {
    let function = "fmi3DoStep";
    let flags = [event_handling_needed, terminate_simulation, early_return];
    let mut next = Next::Failed(Status::Error);
    // SAFETY: as the caller grants.
    let begun = unsafe {
        with::<U>(c, function, |instance| {
            if flags.iter().any(|flag| flag.is_null()) || last_successful_time.is_null() {
                return instance.slave.refuse(function, NULL_RESULT);
            }
            next = instance.begin(current_communication_point, communication_step_size);
            Status::Ok
        })
    };
    if begun != Status::Ok {
        return begun;
    }
    let nothing = Next::Failed(Status::Error);
    // SAFETY: as the caller grants. No reference to the instance lives through a callback.
    let (status, ending) = unsafe {
        loop {
            next = match next {
                Next::GoOn => with_any::<U, _>(c, function, nothing, |instance| instance.go_on()),
                Next::Ask(question) => {
                    let until = ask(question);
                    with_any::<U, _>(c, function, nothing, |instance| instance.answered(until))
                }
                Next::Ended(ending) => break (ending.status, Some(ending)),
                Next::Failed(status) => break (status, None),
            };
        }
    };
    // SAFETY: as the caller grants; none of the places is null.
    unsafe {
        let reached = with_any::<U, _>(c, function, f64::NAN, |instance| instance.slave.time());
        let Ending { event, early, time, .. } = ending.unwrap_or(Ending {
            status,
            event: false,
            early: false,
            time: reached,
        });
        event_handling_needed.write(event.into());
        terminate_simulation.write(0);
        early_return.write(early.into());
        last_successful_time.write(time);
    }
    status
}

/// Calls the master back; the time at which it wants the step to end, if it wants that, s.
///
/// # Safety
/// The callback can be called with its environment.
unsafe fn ask(question: Question) -> Option<f64> {
    let Question {
        update,
        environment,
        time,
        inputs_may_be_set,
        can_return_early,
    } = question;
    let (mut wanted, mut until) = (Boolean::from(false), time);
    // SAFETY: as the caller grants; the two places live through the call.
    unsafe {
        update(
            environment,
            time,
            inputs_may_be_set.into(),
            Boolean::from(true),
            Boolean::from(true),
            can_return_early.into(),
            &raw mut wanted,
            &raw mut until,
        );
    }
    let here = if until.is_finite() { until.max(time) } else { time };
    (can_return_early && wanted != 0).then_some(here)
}
