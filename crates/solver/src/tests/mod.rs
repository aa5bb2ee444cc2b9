//! The solver on small problems without a belt.

mod arrow;
mod bounded;
mod continuation;
mod integrator;
mod newton;
mod problems;

use super::newton::Counts;

/// Numbers without a pattern within ±1: a tone whose pitch rises.
pub fn numbers(count: usize, seed: u32) -> Vec<f64> {
    let rise = 0.7 + 0.01 * f64::from(seed);
    (0..count).map(|i| (rise * ((i + 1) * (i + 1)) as f64).sin()).collect()
}

/// Work of a run in numbers: steps, rejected, failed, residuals, factorizations.
fn work(mut counts: Counts) -> [u64; 5] {
    counts.each_mut().map(|count| *count)
}

/// Asserts that work is at most 2 % above that pinned, and 10 % below.
fn assert_work<const N: usize>(found: [u64; N], pinned: [u64; N], what: &str) {
    let in_band =
        |(found, pinned): (&u64, &u64)| (pinned - pinned / 10..=pinned + pinned / 50).contains(found);
    assert!(
        found.iter().zip(&pinned).all(in_band),
        "{what}: {found:?}, pinned {pinned:?}"
    );
}
