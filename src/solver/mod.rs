//! Implicit solution of stiff systems around a loop. Knows no belt.

pub mod arrow;
