//! Work that is bounded: that of each millisecond in real time, and that of starts. These tests
//! take long.

mod real_time;
mod starts;
