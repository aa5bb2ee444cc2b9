//! Positions on axes, and cubics.

use crate::cubic::resampled;
use crate::tables::{AxisPosition, UniformAxis, interval};

#[test]
fn positions_are_found_on_long_and_short_axes() {
    let position = |index, fraction| AxisPosition { index, fraction };
    for (value, index, fraction) in [(3.0, 1, 0.5), (0.0, 0, 0.0), (9.0, 1, 1.0)] {
        assert_eq!(interval(&[1.0, 2.0, 4.0], value), position(index, fraction));
    }
    assert_eq!(interval(&[1.0], 9.0), position(0, 0.0));
    let even = UniformAxis::over(&[-1.0, 1.0], 5);
    assert_eq!([even.find(0.25), even.find(7.0)], [position(2, 0.5), position(3, 1.0)]);
    assert_eq!(UniformAxis::over(&[2.0], 5).find(7.0), position(0, 0.0));
}

/// As those of scipy's PchipInterpolator. In the second one the tangent at the beginning is
/// limited, and the rise changes its sign.
#[test]
fn cubics_are_monotone() {
    let x = [[0.0, 0.5, 2.0, 2.2, 4.0], [0.0, 1.0, 1.5, 3.0, 4.0]];
    let y = [[0.0, 0.1, 0.1, 3.0, 3.1], [0.0, 2.0, -3.0, -3.5, -6.0]];
    let points = [[0.2, 1.0, 2.1, 3.9], [0.3, 0.9, 2.5, 3.9]];
    let expected = [
        [0.0532, 0.1, 1.546_237_024_221_453_4, 3.099_898_127_975_47],
        [1.314, 1.998, -3.317_555_013_559_646, -5.662_878_512_396_694],
    ];
    for n in 0..2 {
        let both = y[n].map(|y| [y, 2.0 * y]);
        let found = resampled(&x[n], both.as_flattened(), 2, points[n].into_iter());
        for (pair, expected) in found.chunks(2).zip(expected[n]) {
            let off = [pair[0] - expected, pair[1] - 2.0 * expected].map(f64::abs);
            assert!(off[0].max(off[1]) < 1e-14, "{pair:?} {expected}");
        }
    }
    let curve = |x: &[f64], y: &[f64]| resampled(x, y, 1, [-1.0, 0.5, 9.0].into_iter());
    assert_eq!(curve(&[1.0], &[7.0]), [7.0; 3]);
    assert_eq!(curve(&[0.0, 2.0], &[1.0, 3.0]), [1.0, 1.5, 3.0]);
}
