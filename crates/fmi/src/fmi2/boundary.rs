//! The boundary to C for an instance of FMI 2.0.

use super::types::Component;
pub(super) use crate::c::pointers::{NULL_ARRAY, NULL_RESULT, array, array_mut, contain, text};
use crate::log::Status;
use crate::slave::Slave;
use crate::unit::Unit;

/// Runs a call on an instance, and answers an error if there is none.
///
/// # Safety
/// `component` is null or an instance that no other call is using.
pub(super) unsafe fn with<U: Unit>(component: Component, body: impl FnOnce(&mut Slave<U>) -> Status) -> Status {
    contain(Status::Error, || {
        // SAFETY: not null means a `Box<Slave<U>>` released by `instantiate`; the caller grants sole use.
        match unsafe { component.cast::<Slave<U>>().as_mut() } {
            Some(instance) => body(instance),
            None => Status::Error,
        }
    })
}
