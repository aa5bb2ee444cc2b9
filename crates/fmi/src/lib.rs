//! FMI 2.0 and FMI 3.0 for co-simulation around any model: C functions, state machine, variable
//! table, stored states, log, model description.
//!
//! A model implements [`Unit`]: settings that the importer writes (parameters and inputs), readings
//! that it reads, a start and a step; and one [`Table`] that binds each variable's name to its
//! field. The C functions and `modelDescription.xml` come from the table. [`export!`] exports the C
//! functions; `examples/lag.rs` is a whole FMU. Without the default feature `c` there are the table
//! and the description alone.
//!
//! There are no threads, and every instance owns all its data. The only global is the choice of the
//! library in portable builds (`c::dispatch`).

#![warn(missing_docs)]
// The program of the README is a test.
#![cfg_attr(doctest, doc = include_str!("../README.md"))]

#[cfg(feature = "c")]
#[allow(unsafe_code)]
mod c;
#[forbid(unsafe_code)]
mod description;
#[cfg(feature = "c")]
#[allow(unsafe_code)]
pub mod fmi2;
#[allow(unsafe_code)]
pub mod fmi3;
#[forbid(unsafe_code)]
pub mod hash;
#[cfg(feature = "c")]
#[forbid(unsafe_code)]
mod instance;
#[forbid(unsafe_code)]
pub mod log;
#[cfg(feature = "c")]
#[forbid(unsafe_code)]
mod processor;
#[cfg(feature = "c")]
#[forbid(unsafe_code)]
pub mod resources;
#[forbid(unsafe_code)]
pub mod si;
#[cfg(feature = "c")]
#[forbid(unsafe_code)]
pub mod start_file;
#[cfg(feature = "c")]
#[forbid(unsafe_code)]
pub mod state;
#[forbid(unsafe_code)]
pub mod table;
#[forbid(unsafe_code)]
pub mod unit;
#[forbid(unsafe_code)]
mod xml;

/// What the file of a unit imports.
pub mod prelude {
    pub use crate::table::{Access, Causality, Range, Table, UnitDefinition, Variable};
    pub use crate::unit::{Experiment, Identity, Message};
    pub use crate::{Archive, Unit, Version, model_description, setting};
}

pub use description::{Version, model_description, token};
pub use pushbelt_archive::Archive;
pub use table::Table;
pub use unit::Unit;

/// Forwarding to a variant of the library, for the macros of this crate.
#[cfg(feature = "c")]
#[doc(hidden)]
pub use c::dispatch;

/// The C types of the exported functions, for the macros of this crate.
#[cfg(feature = "c")]
#[doc(hidden)]
pub use libc;
