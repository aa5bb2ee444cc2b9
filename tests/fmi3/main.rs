//! The C functions of FMI 3.0, called as an importer calls them.

#![allow(unsafe_code, reason = "it calls the C functions")]

mod beside_fmi2;
mod events;
mod importer;
mod life;
mod states;
mod updates;
mod values;
