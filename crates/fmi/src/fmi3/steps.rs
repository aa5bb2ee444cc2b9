//! Communication steps, with intermediate update mode.
//!
//! The importer is called back between two borrows of the instance, never within one, because its
//! callback calls functions on the same instance.

use super::{Boolean, Instance};
use crate::c::entry::{NULL_RESULT, contain, enter};
use crate::c::floating_point::in_hosts;
use crate::instance::{CallError, Callback, Ended, FmuInstance, Next, Update, refused};
use crate::log::Status;
use crate::unit::Unit;

/// Where the results of a communication step are written.
pub(super) struct Results {
    pub event_handling_needed: *mut Boolean,
    pub terminate_simulation: *mut Boolean,
    pub early_return: *mut Boolean,
    pub last_successful_time: *mut f64,
}

/// `fmi3DoStep`: advances by one communication step; with early return allowed, at most to an event
/// or a requested return.
///
/// # Safety
/// The caller grants what [the head of this module](super) lists.
pub(super) unsafe fn do_step<U: Unit>(
    c: Instance,
    function: &str,
    current: f64,
    step: f64,
    results: Results,
) -> Status {
    let flags = [
        results.event_handling_needed,
        results.terminate_simulation,
        results.early_return,
    ];
    let writable = flags.iter().all(|flag| !flag.is_null()) && !results.last_successful_time.is_null();
    let mut ended = Ended::completed_at(f64::NAN);
    let status = contain(Status::Error, || {
        let mut call = |body: &dyn Fn(&mut FmuInstance<U>) -> Result<Next, CallError>| {
            let mut update = None;
            let call = |instance: &mut FmuInstance<U>| {
                let next = body(instance);
                ended = Ended::completed_at(instance.time());
                match next? {
                    Next::Update(next) => update = Some(next),
                    Next::Ended(how) => ended = how,
                }
                Ok(())
            };
            // SAFETY: the caller grants that it is null or an instance that no other call uses. The
            // reference ends with this call: during a callback there is none, so that the calls in
            // it may have theirs.
            (unsafe { enter(c, function, call) }, update)
        };
        let mut now = call(&|instance| match writable {
            true => instance.begin_step(current, step),
            false => refused(NULL_RESULT),
        });
        while let (_, Some(update)) = now {
            // SAFETY: the importer gave the function with this environment to
            // `fmi3InstantiateCoSimulation`.
            let until = unsafe { call_back(&update) };
            now = call(&|instance| instance.resume_step(until));
        }
        now.0
    });
    if writable {
        // SAFETY: none is null, and the caller grants that values may be written there. They may be
        // the same place.
        unsafe {
            results.event_handling_needed.write(ended.event.into());
            results.terminate_simulation.write(0);
            results.early_return.write(ended.early.into());
            results.last_successful_time.write(ended.time);
        }
    }
    status
}

/// Calls the importer back; the time at which the step is to end, if the importer requests that, s.
///
/// # Safety
/// The callback can be called with its environment.
unsafe fn call_back(update: &Update) -> Option<f64> {
    let Callback { function, environment } = update.callback;
    let time = update.time;
    let [set, early] = [update.inputs_may_be_set, update.can_return_early].map(u8::from);
    let (mut requested, mut until) = (0, time);
    let places = (&raw mut requested, &raw mut until);
    // SAFETY: the caller grants that it can be called with its environment. The places are
    // variables of this function.
    in_hosts(|| unsafe { function(environment, time, set, 1, 1, early, places.0, places.1) });
    let until = if until.is_finite() { until.max(time) } else { time };
    (update.can_return_early && requested != 0).then_some(until)
}
