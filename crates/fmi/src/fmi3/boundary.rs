//! The boundary to C for an instance of FMI 3.0.

use super::instance::Instance3;
use super::types::Instance;
pub(super) use crate::c::pointers::{NULL_ARRAY, NULL_RESULT, array, array_mut, contain, text};
use crate::log::Status;
use crate::stepping::OwnSteps;

/// Runs a call on an instance, and answers an error if there is none, or if the call is not for intermediate update mode while
/// the instance is in it. Messages give the name of the function.
///
/// # Safety
/// `instance` is null or an instance that no other call is using.
pub(super) unsafe fn with<U: OwnSteps>(
    instance: Instance,
    function: &'static str,
    body: impl FnOnce(&mut Instance3<U>) -> Status,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with_any(instance, function, Status::Error, |instance: &mut Instance3<U>| {
            if instance.asking {
                return instance
                    .slave
                    .refuse(function, "not allowed in intermediate update mode");
            }
            body(instance)
        })
    }
}

/// The same in every mode, with another answer where there is no instance or a panic.
///
/// # Safety
/// As there.
pub(super) unsafe fn with_any<U: OwnSteps, T>(
    instance: Instance,
    function: &'static str,
    instead: T,
    body: impl FnOnce(&mut Instance3<U>) -> T,
) -> T
where
    T: Copy,
{
    contain(instead, || {
        // SAFETY: not null means a `Box<Instance3<U>>` released by `instantiate`; the caller grants sole use.
        match unsafe { instance.cast::<Instance3<U>>().as_mut() } {
            Some(instance) => {
                instance.slave.called(function);
                body(instance)
            }
            None => instead,
        }
    })
}
