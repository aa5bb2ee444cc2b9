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
    step: (f64, f64),
    flags: [*mut Boolean; 3],
    last_successful_time: *mut f64,
) -> Status {
    // SAFETY: as the caller grants.
    contain(Status::Error, || unsafe {
        do_step_here::<U>(c, function, step, flags, last_successful_time)
    })
}

/// [`do_step`] in the default floating-point environment.
///
/// # Safety
/// As there.
unsafe fn do_step_here<U: Unit>(
    c: Instance,
    function: &str,
    (current, step): (f64, f64),
    flags: [*mut Boolean; 3],
    last_successful_time: *mut f64,
) -> Status {
    let writable = flags.iter().all(|flag| !flag.is_null()) && !last_successful_time.is_null();
    let mut ended = Ended {
        event: false,
        early: false,
        time: f64::NAN,
    };
    let mut next = Next::Ended(ended);
    let mut enter = |next: &mut Next, body: &dyn Fn(&mut Slave<U>) -> Result<Next, CallError>| {
        let call = |slave: &mut Slave<U>| -> Result<(), CallError> {
            let found = body(slave);
            ended.time = slave.time();
            *next = found?;
            Ok(())
        };
        // SAFETY: as the caller grants. No reference to the instance exists during a callback.
        unsafe { enter(c, function, call) }
    };
    let mut status = enter(&mut next, &|slave| match writable {
        true => slave.begin_step(current, step),
        false => refused(NULL_RESULT),
    });
    while status == Status::Ok {
        status = match next {
            Next::Advance => enter(&mut next, &Slave::advance_step),
            Next::Update(update) => {
                // SAFETY: the caller grants that the callback can be called.
                let until = unsafe { call_back(update) };
                enter(&mut next, &|slave| slave.resume_step(until))
            }
            Next::Ended(_) => break,
        };
    }
    if let (Status::Ok, Next::Ended(done)) = (status, next) {
        ended = done;
    }
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
    let Update {
        function,
        environment,
        time,
        inputs_may_be_set,
        can_return_early,
    } = update;
    let (mut requested, mut until) = (Boolean::from(false), time);
    // SAFETY: as the caller grants; the two places exist during the call.
    in_hosts(|| unsafe {
        function(
            environment,
            time,
            inputs_may_be_set.into(),
            Boolean::from(true),
            Boolean::from(true),
            can_return_early.into(),
            &raw mut requested,
            &raw mut until,
        );
    });
    let until = if until.is_finite() { until.max(time) } else { time };
    (can_return_early && requested != 0).then_some(until)
}
