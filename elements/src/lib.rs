//! A pushbelt element by element: an independent model that judges the belt of `pushbelt`.
//!
//! It takes parameters, radii, and the laws of flanks, tilt and shafts from there, and nothing of
//! ring, stack, cells, mesh or solver. Elements are unilateral contacts in the plane of the drive,
//! the ring has a node an element that slides along the steel, and a step is linearly implicit
//! along the belt. Each law is at the head of its file.
//!
//! | module | content |
//! |---|---|
//! | [`case`] | ratio, force, share of the torque of full slip, speed; start; controller |
//! | [`law`] | constants from the parameters of the FMU, and what this model has beside them |
//! | [`belt`] | places, speeds, chords and frames of the elements |
//! | [`stack`], [`ring`], [`flanks`] | forces between elements, with oil, of the ring, at the sheaves |
//! | [`pitch`] | elements that pitch by themselves: heads, pegs, crowns |
//! | [`pulleys`] | shafts, cones and tilt |
//! | [`cyclic`] | the equations along the belt |
//! | [`machine`] | the step, energies and losses, checks |
//! | [`run`], [`tone`] | means, fields along the belt, stored states; orders of the elements |
//!
//! Not modelled: friction between the layers of the ring, cylinders, end stops.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

/// A type of arrays with a value an element, or a chord, and two copies.
macro_rules! rows {
    ($(#[$doc:meta])* $name:ident { $($row:ident: $value:ty, $of:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub struct $name { $(#[doc = $of] pub $row: Vec<$value>,)* }

        impl $name {
            /// For `n` elements.
            pub fn new(n: usize) -> Self {
                Self { $($row: vec![Default::default(); n + 2],)* }
            }
        }
    };
}

/// Arrays of one length, for loops without checks of bounds.
macro_rules! cut {
    ($n:expr; mut $of:expr => $($row:ident),+) => { $(let $row = &mut $of.$row[..$n];)+ };
    ($n:expr; $of:expr => $($row:ident),+) => { $(let $row = &$of.$row[..$n];)+ };
}

/// Checks that a value is what it should be, within a fraction of it.
#[cfg(test)]
#[track_caller]
fn near(found: f64, expected: f64, within: f64) {
    assert!((found / expected - 1.0).abs() < within, "{found} instead of {expected}");
}

/// The laws of the default belt, of `count` elements.
#[cfg(test)]
fn law(count: usize, options: &Options) -> Law {
    let law = Law::new(&Default::default(), options).unwrap();
    Law { count, ..law }
}

pub mod belt;
pub mod case;
pub mod cyclic;
pub mod flanks;
pub mod law;
pub mod machine;
pub mod oil;
pub mod pitch;
pub mod pulleys;
pub mod ring;
pub mod run;
pub mod stack;
pub mod tone;

pub use belt::{Belt, Vector};
pub use case::Case;
pub use law::{Law, Options};
pub use machine::{Fault, Ledger, Machine};
pub use pulleys::{Cone, Load, Pulley, Shaft};
pub use run::{Row, Run};
