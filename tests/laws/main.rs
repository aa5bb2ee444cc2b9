//! The laws of contact, chain and end stops and the reference curve, with a test for each regime:
//! derivatives against differences, forces against the gradient of their energy, signs of losses.
//! The suite of `paper` tests the beam of `ALE` with the other rings.

mod chain;
mod contact;
mod curve;
mod pulleys;
mod stops;

/// Derivative at 0 by differences of fourth order.
fn slope(f: impl Fn(f64) -> f64, step: f64) -> f64 {
    let around = |k: f64| f(k * step) - f(-k * step);
    (8.0 * around(1.0) - around(2.0)) / (12.0 * step)
}

/// `found` is `expected`, as a share of `scale`.
#[track_caller]
fn assert_near(found: f64, expected: f64, scale: f64, bound: f64, what: &str) {
    let off = (found - expected).abs() / scale;
    assert!(off <= bound, "{what}: {found} against {expected}, off by {off:.1e}");
}
