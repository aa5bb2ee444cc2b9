//! Assertions, and lists of numbers.

/// `found` is `expected` within a relative bound.
#[track_caller]
pub fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (found / expected - 1.0).abs() <= relative,
        "{what}: {found} against {expected}, off by {:.2e}",
        found / expected - 1.0
    );
}

/// Work must not exceed `pinned` by more than 5 %. Less work is an improvement, but less than half indicates that the case has
/// changed.
#[track_caller]
pub fn assert_pinned(found: u64, pinned: u64, what: &str) {
    assert!(
        100 * found <= 105 * pinned,
        "{what}: {found}, pinned at {pinned}: more work than 5 % over the pin. Find out why, or pin the new count if the \
         change is meant"
    );
    assert!(
        2 * found >= pinned,
        "{what}: {found}, pinned at {pinned}: less than half. If that is an improvement and no run that ended early, pin \
         the new count"
    );
    if 100 * found < 95 * pinned {
        println!("{what}: {found}, pinned at {pinned}: an improvement, pin the new count");
    }
}

/// Numbers in a line.
pub fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!(" {x:.2e}")).collect()
}

/// Orders of convergence between successive errors, whose steps or lengths differ by the factor `ratio`.
pub fn orders(errors: &[f64], ratio: f64) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).ln() / ratio.ln()).collect()
}

/// Asserts `≈ order ± 0.2` for successively halved steps or element lengths.
pub fn assert_order(name: &str, errors: &[f64], expected: f64) {
    let observed = orders(errors, 2.0);
    println!("{name}: errors {}, orders {observed:.2?}", list(errors));
    assert!(
        observed.iter().all(|order| (order - expected).abs() < 0.2),
        "{name}: {observed:?}"
    );
}
