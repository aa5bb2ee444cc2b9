//! The number of instances of this library.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Instances of this library.
pub(super) static INSTANCES: AtomicUsize = AtomicUsize::new(0);

/// Counts a new instance.
pub(crate) fn instance_created() {
    INSTANCES.fetch_add(1, Ordering::SeqCst);
}

/// Counts a freed instance.
pub(crate) fn instance_freed() {
    INSTANCES.fetch_sub(1, Ordering::SeqCst);
}
