//! Pictures: cost over the number of elements, speed through the manoeuvre.

use std::error::Error;
use std::path::Path;

use plotters::prelude::*;

use pushbelt_support::bench::STEP;

use crate::Pieces;

/// Communication steps that a point of the speed stands for.
const WINDOW: usize = 50;
const NAMES: [&str; 2] = ["ALE", "ALE0"];
const COLOURS: [RGBColor; 2] = [RGBColor(196, 78, 30), RGBColor(31, 99, 168)];

/// Draws both into an SVG file: `growth` are the pieces of a step on three meshes, `costs` the
/// times of the communication steps, s.
///
/// # Errors
/// The file can't be written.
pub fn draw(file: &Path, growth: &[[Pieces; 3]; 2], costs: &[Vec<f64>; 2]) -> Result<(), Box<dyn Error>> {
    let sheet = SVGBackend::new(file, (1100, 420)).into_drawing_area();
    sheet.fill(&WHITE)?;
    let (left, right) = sheet.split_horizontally(440);
    draw_growth(&left, growth)?;
    draw_speed(&right, costs)?;
    sheet.present()?;
    Ok(())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw_growth(area: &Area<'_>, growth: &[[Pieces; 3]; 2]) -> Result<(), Box<dyn Error>> {
    let elements = growth[0].each_ref().map(|p| p.elements as f64);
    let times = growth.iter().flatten().map(|p| 1e3 * p.whole());
    let (least, most) = (times.clone().fold(f64::INFINITY, f64::min), times.fold(0.0, f64::max));
    let mut chart = ChartBuilder::on(area)
        .caption("Residual, Jacobian, factors and solution", ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(
            (0.9 * elements[0]..1.1 * elements[2]).log_scale(),
            (0.7 * least..1.4 * most).log_scale(),
        )?;
    chart.configure_mesh().x_desc("elements").y_desc("time, ms").draw()?;
    for ((pieces, name), colour) in growth.iter().zip(NAMES).zip(COLOURS) {
        let points: Vec<(f64, f64)> = pieces.iter().map(|p| (p.elements as f64, 1e3 * p.whole())).collect();
        chart.draw_series(points.iter().map(|point| Circle::new(*point, 4, colour.filled())))?;
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    legend(&mut chart)
}

fn draw_speed(area: &Area<'_>, costs: &[Vec<f64>; 2]) -> Result<(), Box<dyn Error>> {
    let span = STEP * WINDOW as f64;
    let factors = costs.each_ref().map(|each| -> Vec<f64> {
        let windows = each.chunks(WINDOW);
        windows
            .map(|window| STEP * window.len() as f64 / window.iter().sum::<f64>())
            .collect()
    });
    let all = factors.iter().flatten().copied();
    let (least, most) = (all.clone().fold(f64::INFINITY, f64::min), all.fold(0.0, f64::max));
    let end = span * factors[0].len() as f64;
    let mut chart = ChartBuilder::on(area)
        .caption("Speed through the manoeuvre", ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..end, (0.7 * least..1.5 * most).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("time in the manoeuvre, s")
        .y_desc("simulated time / processor time")
        .draw()?;
    for ((factors, name), colour) in factors.iter().zip(NAMES).zip(COLOURS) {
        let points = factors
            .iter()
            .enumerate()
            .map(|(k, factor)| ((k as f64 + 0.5) * span, *factor));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart.draw_series(LineSeries::new([(0.0, 1.0), (end, 1.0)], BLACK.mix(0.5)))?;
    legend(&mut chart)
}

fn legend<'a, X: Ranged<ValueType = f64>, Y: Ranged<ValueType = f64>>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
) -> Result<(), Box<dyn Error>> {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerMiddle)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}
