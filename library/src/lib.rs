//! The shared library in `PushbeltVariator.fmu`: the C functions of `pushbelt`.

#![forbid(unsafe_code)]

pub use pushbelt::unit::exports;
