//! Assertions, and lists of numbers.

use pushbelt::variator::settings::Outputs;

/// `found` is `expected` within a relative bound.
#[track_caller]
pub fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    let off = found / expected - 1.0;
    assert!(
        off.abs() <= relative,
        "{what}: {found} against {expected}, off by {off:.2e}"
    );
}

/// A belt in reverse is that of `forward` mirrored in the line of the axes: speeds and torques
/// change sign, all else is the same.
#[track_caller]
pub fn assert_mirrored(reverse: &Outputs, forward: &Outputs, relative: f64) {
    for (name, sign, read) in [
        ("primary speed", -1.0, (|o| o.primary.speed) as fn(&Outputs) -> f64),
        ("secondary speed", -1.0, |o| o.secondary.speed),
        ("belt speed", -1.0, |o| o.belt_speed),
        ("ring speed", -1.0, |o| o.ring_speed),
        ("primary torque", -1.0, |o| o.primary.shaft_torque),
        ("secondary torque", -1.0, |o| o.secondary.shaft_torque),
        ("thrust ratio", 1.0, |o| o.thrust_ratio),
        ("ratio", 1.0, |o| o.ratio_geometric),
        ("push force", 1.0, |o| o.push_force_max),
        ("tension", 1.0, |o| o.ring_tension_max),
        ("losses", 1.0, |o| o.losses.total()),
        ("primary idle arc", 1.0, |o| o.primary.idle_arc),
        ("secondary idle arc", 1.0, |o| o.secondary.idle_arc),
    ] {
        let (found, expected) = (read(reverse), sign * read(forward));
        let off = (found - expected).abs();
        assert!(off <= relative * expected.abs(), "{name}: {found}, {expected}");
    }
}

/// Work must not exceed `pinned` by more than 5 %. Less work is an improvement, but less than half
/// indicates a run that ended early.
#[track_caller]
pub fn assert_pinned(found: u64, pinned: u64, what: &str) {
    let advice = format!(
        "{what}: {found}, pinned at {pinned}: find out why, or pin the new count if the change is meant"
    );
    assert!(100 * found <= 105 * pinned, "{advice}");
    assert!(2 * found >= pinned, "{advice}");
}

pub fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!(" {x:.2e}")).collect()
}

/// Orders of convergence between successive errors, whose steps or lengths differ by the factor
/// `ratio`.
pub fn orders(errors: &[f64], ratio: f64) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).ln() / ratio.ln()).collect()
}

/// Asserts `≈ order ± 0.2` for successively halved steps or element lengths.
pub fn assert_order(name: &str, errors: &[f64], expected: f64) {
    let observed = orders(errors, 2.0);
    println!("{name}: errors {}, orders {observed:.2?}", list(errors));
    let near = observed.iter().all(|order| (order - expected).abs() < 0.2);
    assert!(near, "{name}: {observed:?}");
}
