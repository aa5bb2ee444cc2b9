//! The variator behind the C functions of both versions. What the layer does with any unit is
//! tested on a toy in `crates/fmi`; here is what a belt alone can show.

#![allow(unsafe_code, reason = "it calls C functions")]

mod derivatives;
#[allow(dead_code, reason = "it has more than these tests use")]
#[cfg(target_arch = "x86_64")]
#[path = "../../crates/fmi/tests/fmi/environment.rs"]
mod environment;
mod events;
#[allow(dead_code, reason = "it has more than these tests use")]
#[path = "../../crates/fmi/tests/fmi/importer.rs"]
mod importer;
mod linear;
mod runs;
mod starts;
mod states;
mod updates;
mod variator;

use pushbelt::fmi as layer;
