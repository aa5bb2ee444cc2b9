//! A pushbelt CVT variator around an Arbitrary-Lagrangian-Eulerian ring.
pub mod reference_curve;
pub mod scalar;
pub mod solver;
pub mod variator;
pub mod fmi2;
pub mod unit;
