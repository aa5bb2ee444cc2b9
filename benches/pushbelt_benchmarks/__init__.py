"""Benchmarks of Python programs: `cargo fmu bench` with an option."""
