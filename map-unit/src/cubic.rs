//! Monotone piecewise cubic interpolation (Fritsch and Butland, 1984): between two points the curve
//! stays between their values.

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

/// The curve through `y` at ascending points `x`; constant beyond the ends.
fn curve(x: &[f64], y: &[f64]) -> impl Fn(f64) -> f64 {
    let last = x.len() - 1;
    let step = |k: usize| x[k + 1] - x[k];
    let rise = |k: usize| (y[k + 1] - y[k]) / step(k);
    let tangent = |k: usize| match k {
        _ if last == 0 => 0.0,
        _ if last == 1 => rise(0),
        0 => end_tangent([0, 1].map(step), [0, 1].map(rise)),
        _ if k == last => end_tangent([k - 1, k - 2].map(step), [k - 1, k - 2].map(rise)),
        _ if rise(k - 1) * rise(k) <= 0.0 => 0.0,
        _ => {
            let (before, after) = (2.0 * step(k) + step(k - 1), step(k) + 2.0 * step(k - 1));
            (before + after) / (before / rise(k - 1) + after / rise(k))
        }
    };
    let tangents: Vec<f64> = (0..=last).map(tangent).collect();
    move |point| {
        let Some(k) = (0..last).find(|&k| (x[k]..x[k + 1]).contains(&point)) else {
            return if point < x[0] { y[0] } else { y[last] };
        };
        let step = x[k + 1] - x[k];
        let t = (point - x[k]) / step;
        let (a, b) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t));
        y[k] + (y[k + 1] - y[k]) * a + step * b * (tangents[k] * (1.0 - t) - tangents[k + 1] * t)
    }
}

/// Values at other points of an axis. The values of a point on it are `width` numbers, each with a
/// curve of its own, and points of further axes before it follow one another.
pub fn resampled(x: &[f64], values: &[f64], width: usize, points: impl Iterator<Item = f64>) -> Vec<f64> {
    let points: Vec<f64> = points.collect();
    let mut found = vec![0.0; values.len() / x.len() * points.len()];
    let blocks = values
        .chunks(x.len() * width)
        .zip(found.chunks_mut(points.len() * width));
    for (block, found) in blocks {
        for column in 0..width {
            let y: Vec<f64> = block.iter().skip(column).step_by(width).copied().collect();
            let curve = curve(x, &y);
            for (found, point) in found.iter_mut().skip(column).step_by(width).zip(&points) {
                *found = curve(*point);
            }
        }
    }
    found
}
