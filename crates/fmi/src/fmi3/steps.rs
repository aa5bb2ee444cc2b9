//! Communication steps, with intermediate update mode.
//!
//! The master is called back between two borrows of the instance, never within one, because its callback calls functions on the
//! same instance.

use std::cell::Cell;

use super::types::{Boolean, Instance};
use crate::c::entry::{NULL_RESULT, contain, enter};
use crate::c::floating_point::in_hosts;
use crate::log::Status;
use crate::slave::{CallError, Ended, Next, Slave, Update, refused};
use crate::unit::Unit;

/// `fmi3DoStep`: advances by one communication step; with early return allowed, at most to an event or a requested return. `flags` are
/// the places for event, end of the simulation, and early return.
///
/// # Safety
/// The caller grants what [the head of this module](super) lists.
pub(super) unsafe fn do_step<U: Unit>(
    c: Instance,
    function: &str,
    (current, step): (f64, f64),
    flags: [*mut Boolean; 3],
    last_successful_time: *mut f64,
) -> Status {
    let writable = flags.iter().all(|flag| !flag.is_null()) && !last_successful_time.is_null();
    let (time, mut ended) = (Cell::new(f64::NAN), None);
    let status = contain(Status::Error, || {
        let call = |body: &dyn Fn(&mut Slave<U>) -> Result<Next, CallError>| {
            let mut next = None;
            let call = |slave: &mut Slave<U>| {
                let found = body(slave);
                time.set(slave.time());
                next = Some(found?);
                Ok(())
            };
            // SAFETY: as the caller grants. No reference to the instance exists during a callback.
            let status = unsafe { enter(c, function, call) };
            (status, next)
        };
        let mut now = call(&|slave| match writable {
            true => slave.begin_step(current, step),
            false => refused(NULL_RESULT),
        });
        loop {
            now = match now {
                (Status::Ok, Some(Next::Advance)) => call(&Slave::advance_step),
                (Status::Ok, Some(Next::Update(update))) => {
                    // SAFETY: the caller grants that the callback can be called.
                    let until = unsafe { call_back(update) };
                    call(&|slave| slave.resume_step(until))
                }
                (status, Some(Next::Ended(done))) => {
                    ended = Some(done);
                    return status;
                }
                (status, _) => return status,
            };
        }
    });
    let ended = ended.unwrap_or_else(|| Ended::at(time.get()));
    if writable {
        let [event, terminate, early] = flags;
        // SAFETY: none of the places is null.
        unsafe {
            event.write(ended.event.into());
            terminate.write(0);
            early.write(ended.early.into());
            last_successful_time.write(ended.time);
        }
    }
    status
}

/// Calls the master back; the time at which the step is to end, if the master requests that, s.
///
/// # Safety
/// The callback can be called with its environment.
unsafe fn call_back(update: Update) -> Option<f64> {
    let (time, mut requested, mut until) = (update.time, 0, update.time);
    let [set, early] = [update.inputs_may_be_set, update.can_return_early].map(u8::from);
    let (requested_at, until_at) = (&raw mut requested, &raw mut until);
    // SAFETY: as the caller grants; the two places exist during the call.
    in_hosts(|| unsafe { (update.function)(update.environment, time, set, 1, 1, early, requested_at, until_at) });
    let until = if until.is_finite() { until.max(time) } else { time };
    (update.can_return_early && requested != 0).then_some(until)
}
