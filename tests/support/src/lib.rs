//! What the tests, benchmarks and examples of `pushbelt` share. It is a development dependency and
//! not published.

pub mod bench;
pub mod checks;
pub mod curves;
pub mod differences;
pub mod disturbed;
pub mod film;
pub mod fingerprint;
pub mod laws;
pub mod load_cases;
pub mod loads;
pub mod manoeuvre;
pub mod meter;
mod noise;
pub mod run;
pub mod shared_library;
pub mod shift;
pub mod steady;
pub mod tracking;
pub mod variators;

pub use noise::noise;
