//! The variator: parameters and outputs, the equations of belt and pulleys, steady states, runs,
//! linear models. A user needs [`Variator`], [`settings`] and [`linear`].

pub(crate) mod assembly;
pub(crate) mod belt;
#[doc(hidden)]
pub mod cell;
#[doc(hidden)]
pub mod diagnostics;
pub(crate) mod law;
pub mod linear;
#[doc(hidden)]
pub mod mesh;
#[doc(hidden)]
pub mod pulleys;
pub mod ring_models;
pub(crate) mod rings;
pub mod run;
pub mod settings;
#[doc(hidden)]
pub mod steady;
#[doc(hidden)]
pub mod system;
#[cfg(test)]
mod tests;

pub use run::Variator;
