//! The variator: parameters, state, residual, outputs, energy balance.

#![forbid(unsafe_code)]

mod assembly;
pub mod balance;
pub mod boundary;
pub mod cell;
pub mod evolution;
mod flanks;
pub mod instance;
mod jacobian;
mod kept;
mod lay;
pub mod layout;
pub mod linear;
pub mod mesh;
pub mod observe;
pub mod order;
mod pack;
pub mod parameters;
pub mod refine;
pub mod ring;
pub mod sample;
pub mod signals;
pub mod soft_start;
pub mod start;
pub mod steady;
pub mod system;
mod transports;
pub mod travelling;
pub mod validation;
mod variation;
