//! Monotone piecewise cubic interpolation (Fritsch and Butland, 1984): between two points the curve stays between their values.

/// Tangents at the points of a curve with ascending places.
fn tangents(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let step: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rise: Vec<f64> = (0..n - 1).map(|k| (y[k + 1] - y[k]) / step[k]).collect();
    if n == 2 {
        return vec![rise[0]; 2];
    }
    let mut found = vec![0.0; n];
    for k in 1..n - 1 {
        if rise[k - 1] * rise[k] > 0.0 {
            let (before, after) = (2.0 * step[k] + step[k - 1], step[k] + 2.0 * step[k - 1]);
            found[k] = (before + after) / (before / rise[k - 1] + after / rise[k]);
        }
    }
    found[0] = end_tangent([step[0], step[1]], [rise[0], rise[1]]);
    found[n - 1] = end_tangent([step[n - 2], step[n - 3]], [rise[n - 2], rise[n - 3]]);
    found
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

/// Values of the curve through `y` at ascending places `x`, at other ascending places; constant beyond the ends.
#[must_use]
pub fn resampled(x: &[f64], y: &[f64], at: &[f64]) -> Vec<f64> {
    let tangent = tangents(x, y);
    let last = x.len() - 1;
    let mut k = 0;
    let value = |&place: &f64| {
        if place <= x[0] {
            return y[0];
        }
        if place >= x[last] {
            return y[last];
        }
        while k + 2 <= last && place > x[k + 1] {
            k += 1;
        }
        let step = x[k + 1] - x[k];
        let t = (place - x[k]) / step;
        let (a, b) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t));
        y[k] + (y[k + 1] - y[k]) * a + step * b * (tangent[k] * (1.0 - t) - tangent[k + 1] * t)
    };
    at.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::resampled;

    #[test]
    fn it_passes_through_its_points_and_stays_monotone() {
        let (x, y) = ([0.0, 0.5, 2.0, 2.2, 4.0], [0.0, 0.1, 0.1, 3.0, 3.1]);
        assert_eq!(resampled(&x, &y, &x), y);
        let at: Vec<f64> = (0..=400).map(|k| 0.01 * f64::from(k)).collect();
        let found = resampled(&x, &y, &at);
        assert!(found.windows(2).all(|pair| pair[0] <= pair[1] + 1e-15));
        // Between 0.5 and 2 both values are the same.
        assert!((found[120] - 0.1).abs() < 1e-15);
    }

    #[test]
    fn few_points_and_places_beyond_them() {
        assert_eq!(resampled(&[1.0], &[7.0], &[0.0, 1.0, 2.0]), [7.0; 3]);
        assert_eq!(resampled(&[0.0, 2.0], &[1.0, 3.0], &[-1.0, 0.5, 9.0]), [1.0, 1.5, 3.0]);
    }

    #[test]
    fn a_smooth_curve_is_met_to_the_square_of_the_spacing() {
        let x: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k)).collect();
        let y: Vec<f64> = x.iter().map(|x| x.exp()).collect();
        let at: Vec<f64> = (0..=1000).map(|k| 1e-3 * f64::from(k)).collect();
        let found = resampled(&x, &y, &at);
        let worst = at
            .iter()
            .zip(&found)
            .map(|(x, y)| (x.exp() - y).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-4, "{worst}");
    }
}
