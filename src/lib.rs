//! A pushbelt CVT variator around an Arbitrary-Lagrangian-Eulerian ring.
pub mod variator;
