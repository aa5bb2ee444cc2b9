//! One file a command.

pub mod bench;
pub mod build;
pub mod demo;
pub mod describe;
pub mod drive;
pub mod linearize;
pub mod paper;
pub mod sweep;
pub mod test;
