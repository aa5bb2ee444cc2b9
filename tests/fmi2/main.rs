//! The exported C functions, called as an importer calls them.

#![allow(unsafe_code, reason = "it calls the C functions")]

mod coupled;
mod derivatives;
#[cfg(target_arch = "x86_64")]
#[path = "../../crates/fmi/tests/fmi/environment.rs"]
mod environment;
#[cfg(target_arch = "x86_64")]
mod hosts_environment;
mod importer;
mod life;
mod linear;
mod start_values;
mod states;
mod values;
