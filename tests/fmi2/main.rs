//! The exported C functions, called as an importer calls them.

#![allow(unsafe_code, reason = "it calls the C functions")]

mod derivatives;
mod importer;
mod life;
mod linear;
mod start_values;
mod states;
mod values;
