//! Communication steps, with intermediate update mode.
//!
//! The master is called back between two borrows of the instance, never within one, because its callback calls functions on the
//! same instance.

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
    let body = || {
        let (mut ended, mut time) = (None, f64::NAN);
        let mut enter = |next: &mut Option<Next>, body: &dyn Fn(&mut Slave<U>) -> Result<Next, CallError>| {
            let call = |slave: &mut Slave<U>| -> Result<(), CallError> {
                let found = body(slave);
                time = slave.time();
                *next = Some(found?);
                Ok(())
            };
            // SAFETY: as the caller grants. No reference to the instance exists during a callback.
            unsafe { enter(c, function, call) }
        };
        let mut next = None;
        let mut status = enter(&mut next, &|slave| match writable {
            true => slave.begin_step(current, step),
            false => refused(NULL_RESULT),
        });
        while status == Status::Ok {
            status = match next.take() {
                Some(Next::Advance) => enter(&mut next, &Slave::advance_step),
                Some(Next::Update(update)) => {
                    // SAFETY: the caller grants that the callback can be called.
                    let until = unsafe { call_back(update) };
                    enter(&mut next, &|slave| slave.resume_step(until))
                }
                Some(Next::Ended(done)) => {
                    ended = Some(done);
                    break;
                }
                None => Status::Error,
            };
        }
        (
            status,
            ended.unwrap_or(Ended {
                event: false,
                early: false,
                time,
            }),
        )
    };
    let failed = (
        Status::Error,
        Ended {
            event: false,
            early: false,
            time: f64::NAN,
        },
    );
    let (status, ended) = contain(failed, body);
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
    let time = update.time;
    let (set, can_return) = (update.inputs_may_be_set.into(), update.can_return_early.into());
    let (mut requested, mut until) = (0, time);
    // SAFETY: as the caller grants; the two places exist during the call.
    in_hosts(|| unsafe {
        (update.function)(
            update.environment,
            time,
            set,
            1,
            1,
            can_return,
            &raw mut requested,
            &raw mut until,
        );
    });
    let until = if until.is_finite() { until.max(time) } else { time };
    (update.can_return_early && requested != 0).then_some(until)
}
