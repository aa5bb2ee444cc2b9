//! The FMI layer on a toy unit, in both versions of the standard: state machine, C functions,
//! stored states, derivatives, descriptions.

mod creation;
mod description;
#[cfg(target_arch = "x86_64")]
mod environment;
mod fmi2;
mod fmi3;
mod importer;
mod run;
mod stored;
mod tank;
mod times;
mod values;

use pushbelt_fmi as layer;
