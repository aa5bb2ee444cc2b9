//! `model.png`, the picture of the FMU in a user interface: a variator seen along its shafts, in underdrive.

use std::f32::consts::{PI, TAU};

use anyhow::Context;
use tiny_skia::{
    Color, FillRule, GradientStop, Paint, Path, PathBuilder, Pixmap, Point, RadialGradient, SpreadMode, Stroke,
    Transform,
};

/// Size, pixels.
const SIZE: (u32, u32) = (640, 400);
/// Centres of the secondary and the primary pulley, and their running radii, pixels.
const CENTRES: [Point; 2] = [Point { x: 190.0, y: 200.0 }, Point { x: 474.0, y: 200.0 }];
const RADII: [f32; 2] = [114.0, 76.0];
/// Outer radius of the sheaves and radius of the shafts, pixels.
const SHEAVE: f32 = 142.0;
const SHAFT: f32 = 26.0;
/// Height and spacing of the elements, pixels.
const ELEMENT: f32 = 22.0;
const SPACING: f32 = 6.5;

const STEEL: [u8; 3] = [0x5b, 0x6b, 0x7d];
const PUSHED: [u8; 3] = [0xd9, 0x6b, 0x27];
const LINE: [u8; 3] = [0x2a, 0x35, 0x42];

/// Draws the picture.
///
/// # Errors
/// The picture can't be encoded.
pub fn variator() -> anyhow::Result<Vec<u8>> {
    let mut canvas = Pixmap::new(SIZE.0, SIZE.1).context("a picture has a size")?;
    for centre in CENTRES {
        sheave(&mut canvas, centre).context("a sheave can't be drawn")?;
    }
    belt(&mut canvas);
    canvas.encode_png().context("the picture can't be encoded")
}

fn paint(rgb: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(rgb[0], rgb[1], rgb[2], 255);
    paint
}

fn mix(a: [u8; 3], b: [u8; 3], share: f32) -> [u8; 3] {
    std::array::from_fn(|i| {
        let (a, b) = (f32::from(a[i]), f32::from(b[i]));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between two bytes"
        )]
        let mixed = (a + share.clamp(0.0, 1.0) * (b - a)).round() as u8;
        mixed
    })
}

fn stroke(canvas: &mut Pixmap, path: &Path, rgb: [u8; 3], width: f32) {
    let stroke = Stroke {
        width,
        ..Stroke::default()
    };
    canvas.stroke_path(path, &paint(rgb), &stroke, Transform::identity(), None);
}

/// Cone, its edge and the shaft with its keyway.
fn sheave(canvas: &mut Pixmap, centre: Point) -> Option<()> {
    let disc = PathBuilder::from_circle(centre.x, centre.y, SHEAVE)?;
    let grey = |light: u8, at: f32| GradientStop::new(at, Color::from_rgba8(light, light + 4, light + 9, 255));
    let light = Point {
        x: centre.x - 45.0,
        y: centre.y - 55.0,
    };
    let shader = RadialGradient::new(
        light,
        0.0,
        centre,
        1.15 * SHEAVE,
        vec![grey(246, 0.0), grey(214, 0.55), grey(172, 1.0)],
        SpreadMode::Pad,
        Transform::identity(),
    )?;
    let mut fill = paint(LINE);
    fill.shader = shader;
    canvas.fill_path(&disc, &fill, FillRule::Winding, Transform::identity(), None);
    stroke(canvas, &disc, LINE, 2.0);
    for radius in [SHEAVE - 7.0, SHAFT + 14.0] {
        stroke(
            canvas,
            &PathBuilder::from_circle(centre.x, centre.y, radius)?,
            [0x8f, 0x9a, 0xa6],
            1.0,
        );
    }
    let shaft = PathBuilder::from_circle(centre.x, centre.y, SHAFT)?;
    canvas.fill_path(
        &shaft,
        &paint([0x7b, 0x88, 0x96]),
        FillRule::Winding,
        Transform::identity(),
        None,
    );
    stroke(canvas, &shaft, LINE, 2.0);
    let key = tiny_skia::Rect::from_xywh(centre.x - 5.0, centre.y - SHAFT - 5.0, 10.0, 11.0)?;
    canvas.fill_rect(key, &paint(LINE), Transform::identity(), None);
    Some(())
}

/// A place on the belt: where, outward direction, and how far along the push strand it is, 0 to 1 (below 0: not on it).
struct Place {
    at: Point,
    normal: Point,
    pushed: f32,
}

/// The loop: around the secondary pulley, over the upper strand, around the primary pulley, back under it.
fn places() -> Vec<Place> {
    let [s, p] = CENTRES;
    let distance = p.x - s.x;
    // Angle of the strands' normals from the vertical.
    let tilt = ((RADII[0] - RADII[1]) / distance).asin();
    let strand = distance * tilt.cos();
    let (wrap_s, wrap_p) = (PI + 2.0 * tilt, PI - 2.0 * tilt);
    let lengths = [wrap_s * RADII[0], strand, wrap_p * RADII[1], strand];
    let whole: f32 = lengths.iter().sum();
    let count = (whole / SPACING).round();
    let mut places = Vec::new();
    let mut number = 0.0;
    while number < count {
        let mut along = whole * number / count;
        number += 1.0;
        let mut part = 0;
        while part < 3 && along > lengths[part] {
            along -= lengths[part];
            part += 1;
        }
        let share = along / lengths[part];
        // Angles count clockwise from the vertical, as the picture's y points down.
        let (angle, centre, radius, offset) = match part {
            0 => (PI - tilt + share * wrap_s, s, RADII[0], 0.0),
            1 => (TAU + tilt, s, RADII[0], along),
            2 => (TAU + tilt + share * wrap_p, p, RADII[1], 0.0),
            _ => (PI - tilt, p, RADII[1], along),
        };
        let normal = Point {
            x: angle.sin(),
            y: -angle.cos(),
        };
        places.push(Place {
            at: Point {
                x: centre.x + radius * normal.x - offset * normal.y,
                y: centre.y + radius * normal.y + offset * normal.x,
            },
            normal,
            pushed: match part {
                2 => share,
                3 => 1.0,
                0 => 1.0 - 1.3 * share,
                _ => -1.0,
            },
        });
    }
    places
}

/// Elements, warm where they push one another, and the ring above their pitch line.
fn belt(canvas: &mut Pixmap) {
    let places = places();
    for Place { at, normal, pushed } in &places {
        let mut line = PathBuilder::new();
        line.move_to(at.x - 0.55 * ELEMENT * normal.x, at.y - 0.55 * ELEMENT * normal.y);
        line.line_to(at.x + 0.45 * ELEMENT * normal.x, at.y + 0.45 * ELEMENT * normal.y);
        if let Some(line) = line.finish() {
            stroke(canvas, &line, LINE, SPACING - 0.6);
            stroke(canvas, &line, mix(STEEL, PUSHED, *pushed), SPACING - 2.2);
        }
    }
    let mut ring = PathBuilder::new();
    for (number, Place { at, normal, .. }) in places.iter().enumerate() {
        let (x, y) = (at.x + 2.0 * normal.x, at.y + 2.0 * normal.y);
        if number == 0 {
            ring.move_to(x, y);
        } else {
            ring.line_to(x, y);
        }
    }
    ring.close();
    if let Some(ring) = ring.finish() {
        stroke(canvas, &ring, LINE, 5.0);
        stroke(canvas, &ring, [0xd5, 0xdc, 0xe3], 2.6);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_belt_closes_with_even_spacing() {
        let places = places();
        for (number, one) in places.iter().enumerate() {
            let next = &places[(number + 1) % places.len()];
            let gap = (next.at.x - one.at.x).hypot(next.at.y - one.at.y);
            assert!((gap - SPACING).abs() < 0.05 * SPACING, "{gap} after element {number}");
        }
    }

    #[test]
    fn the_picture_is_a_png_and_always_the_same() {
        let picture = variator().unwrap();
        assert!(picture.starts_with(b"\x89PNG"));
        assert_eq!(picture, variator().unwrap());
    }
}
