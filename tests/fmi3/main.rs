//! The C functions of FMI 3.0, called as an importer calls them.

#![allow(unsafe_code, reason = "it calls the C functions")]

mod beside_fmi2;
#[cfg(target_arch = "x86_64")]
#[path = "../../crates/fmi/tests/fmi/environment.rs"]
mod environment;
mod events;
#[cfg(target_arch = "x86_64")]
mod hosts_environment;
mod importer;
mod life;
mod states;
mod updates;
mod values;
