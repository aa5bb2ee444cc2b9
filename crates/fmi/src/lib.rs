//! A co-simulation slave of FMI 2.0 and FMI 3.0 around any model: C functions, state machine, variable table, snapshots, log, description.
//!
//! Nothing here depends on what is modelled. A model is a [`Unit`]: settings that the master writes (parameters and
//! inputs), readings that it reads, a start and a step; and one [`Table`] that binds each variable's name to its
//! field. From the table come both the answers to `fmi2Get…`/`fmi2Set…` and `modelDescription.xml`.
//!
//! Read in this order:
//!
//! | file | what it holds |
//! |---|---|
//! | [`table`] | what a variable is; each fact about a variable stands there once |
//! | [`mod@unit`] | what a model has to offer |
//! | [`state`] | which function the standard allows in which state (its table 4.2.4) |
//! | [`slave`] | one instance, in the order of that state machine |
//! | `snapshot`, `bytes` | the whole state of an instance; the same with version and checksum |
//! | [`log`] | messages to the importer |
//! | [`stepping`] | what a model has to offer to a master that watches its own steps (FMI 3.0) |
//! | `description`, `xml` | the XML of FMI 2.0, and the GUID made from it; elements and numbers of any XML |
//! | [`start_values`] | start values of a user's own, from a file in the resources |
//! | `processor` | whether the processor has what the binary is compiled for |
//! | [`fmi2`] | the C functions of FMI 2.0 for any unit; `export!` names them for one unit |
//! | [`fmi3`] | the same of FMI 3.0, with its XML |
//! | `c` | pointers and stored states as C has them, for both; with the two above the only place with `unsafe` |
//!
//! There are no globals and no threads; every instance owns all it uses.

#![warn(missing_docs)]

#[forbid(unsafe_code)]
mod bytes;
#[allow(unsafe_code)]
mod c;
#[forbid(unsafe_code)]
mod description;
#[allow(unsafe_code)]
pub mod fmi2;
#[allow(unsafe_code)]
pub mod fmi3;
#[forbid(unsafe_code)]
mod hash;
#[forbid(unsafe_code)]
pub mod log;
#[forbid(unsafe_code)]
mod processor;
#[forbid(unsafe_code)]
mod said;
#[forbid(unsafe_code)]
pub mod slave;
#[forbid(unsafe_code)]
mod snapshot;
#[forbid(unsafe_code)]
pub mod start_values;
#[forbid(unsafe_code)]
pub mod state;
#[forbid(unsafe_code)]
pub mod stepping;
#[forbid(unsafe_code)]
pub mod table;
#[forbid(unsafe_code)]
pub mod unit;
#[forbid(unsafe_code)]
mod xml;

pub use description::{guid, model_description};
pub use slave::Slave;
pub use snapshot::Snapshot;
pub use table::Table;
pub use unit::Unit;
