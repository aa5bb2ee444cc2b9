//! The FMI layer on a toy unit: state machine, C functions of both versions, stored states, derivatives, descriptions.

mod descriptions;
#[cfg(target_arch = "x86_64")]
mod environment;
mod fmi2;
mod fmi3;
mod simple;
mod slave;
mod tank;
mod times;
