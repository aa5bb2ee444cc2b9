//! Monotone piecewise cubic interpolation (Fritsch and Butland, 1984): between two points the curve stays between their values.

/// Tangents at the points of a curve with ascending places.
fn tangents(x: &[f64], y: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    let step: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rise: Vec<f64> = (0..last).map(|k| (y[k + 1] - y[k]) / step[k]).collect();
    let at = |k: usize| match k {
        _ if last < 2 => rise.first().copied().unwrap_or_default(),
        0 => end_tangent([step[0], step[1]], [rise[0], rise[1]]),
        _ if k == last => end_tangent([step[k - 1], step[k - 2]], [rise[k - 1], rise[k - 2]]),
        _ if rise[k - 1] * rise[k] <= 0.0 => 0.0,
        _ => {
            let (before, after) = (2.0 * step[k] + step[k - 1], step[k] + 2.0 * step[k - 1]);
            (before + after) / (before / rise[k - 1] + after / rise[k])
        }
    };
    (0..=last).map(at).collect()
}

/// The tangent at an end by three points, limited so that the curve stays monotone.
fn end_tangent(step: [f64; 2], rise: [f64; 2]) -> f64 {
    let found = ((2.0 * step[0] + step[1]) * rise[0] - step[0] * rise[1]) / (step[0] + step[1]);
    if found * rise[0] <= 0.0 {
        0.0
    } else if rise[0] * rise[1] <= 0.0 && found.abs() > 3.0 * rise[0].abs() {
        3.0 * rise[0]
    } else {
        found
    }
}

/// Values of the curve through `y` at ascending places `x`, at another place; constant beyond the ends.
fn value(x: &[f64], y: &[f64], tangent: &[f64], at: f64) -> f64 {
    let last = x.len() - 1;
    let Some(k) = x.windows(2).position(|pair| (pair[0]..pair[1]).contains(&at)) else {
        return if at < x[0] { y[0] } else { y[last] };
    };
    let step = x[k + 1] - x[k];
    let t = (at - x[k]) / step;
    let (a, b) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t));
    y[k] + (y[k + 1] - y[k]) * a + step * b * (tangent[k] * (1.0 - t) - tangent[k + 1] * t)
}

/// Values at other places of an axis. The values of a place on it are `width` numbers, each with a curve of its own, and places of further
/// axes before it follow one another.
#[must_use]
pub fn resampled(x: &[f64], values: &[f64], width: usize, at: impl Iterator<Item = f64>) -> Vec<f64> {
    let at: Vec<f64> = at.collect();
    let mut found = vec![0.0; values.len() / x.len() * at.len()];
    let blocks = values.chunks(x.len() * width).zip(found.chunks_mut(at.len() * width));
    for (block, found) in blocks {
        for column in 0..width {
            let y: Vec<f64> = block.iter().skip(column).step_by(width).copied().collect();
            let tangent = tangents(x, &y);
            for (found, at) in found.iter_mut().skip(column).step_by(width).zip(&at) {
                *found = value(x, &y, &tangent, *at);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::resampled;

    fn curve(x: &[f64], y: &[f64], at: &[f64]) -> Vec<f64> {
        resampled(x, y, 1, at.iter().copied())
    }

    #[test]
    fn it_passes_through_its_points_and_stays_monotone() {
        let (x, y) = ([0.0, 0.5, 2.0, 2.2, 4.0], [0.0, 0.1, 0.1, 3.0, 3.1]);
        assert_eq!(curve(&x, &y, &x), y);
        let at: Vec<f64> = (0..=400).map(|k| 0.01 * f64::from(k)).collect();
        let found = curve(&x, &y, &at);
        assert!(found.windows(2).all(|pair| pair[0] <= pair[1] + 1e-15));
        // Between 0.5 and 2 both values are the same.
        assert!((found[120] - 0.1).abs() < 1e-15);
        assert_eq!(curve(&[1.0], &[7.0], &[0.0, 1.0, 2.0]), [7.0; 3]);
        assert_eq!(curve(&[0.0, 2.0], &[1.0, 3.0], &[-1.0, 0.5, 9.0]), [1.0, 1.5, 3.0]);
    }

    /// Two curves, of which the second one is twice the first one.
    #[test]
    fn smooth_curves_are_met_to_the_square_of_the_spacing() {
        let x: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k)).collect();
        let y: Vec<f64> = x.iter().flat_map(|x| [x.exp(), 2.0 * x.exp()]).collect();
        let at = |k: usize| 1e-3 * k as f64;
        let found = resampled(&x, &y, 2, (0..=1000).map(at));
        for (k, pair) in found.chunks(2).enumerate() {
            assert!(
                (at(k).exp() - pair[0]).abs() < 1e-4 && (pair[1] - 2.0 * pair[0]).abs() < 1e-15,
                "{k}"
            );
        }
    }
}
