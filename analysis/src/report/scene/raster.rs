//! A drawing as a PNG file: 300 dots an inch, text from the embedded font, what it is in its own words inside.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};
use std::sync::OnceLock;

use super::{Anchor, CROSS, Element, MARK_STROKE, Px, Scene, Shape, Tint, Words};

/// Font family under which the embedded font is registered.
pub(in crate::report) const FONT: &str = "pneuval";

/// Dots of the file for a px of a page: text of 12 px has 7.2 points in print.
const DOTS_PER_PX: f64 = 2.5;

/// The drawing is made this many times larger and averaged: the plotting library knows whole pixels only, which makes flat curves wobble.
const OVERSAMPLING: u32 = 2;

/// 300 dots an inch.
const PIXELS_PER_METRE: u32 = 11_811;

/// plotters draws text at 1/1.24 of its nominal size.
const FONT_SCALE: f64 = 1.24;

/// The lengths of a dash and of the gap behind it, in px.
const DASH: (f64, f64) = (7.0, 4.5);

type Canvas<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Registers the embedded font once; the machine's own fonts are never asked.
pub(in crate::report) fn register() -> Result<(), String> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let registered = *DONE.get_or_init(|| {
        let regular = include_bytes!("../../../assets/pneuval-sans-regular.otf");
        let semibold = include_bytes!("../../../assets/pneuval-sans-semibold.otf");
        register_font(FONT, FontStyle::Normal, regular).is_ok()
            && register_font(FONT, FontStyle::Bold, semibold).is_ok()
    });
    if registered { Ok(()) } else { Err("the embedded font was refused".to_owned()) }
}

/// The drawing as a PNG file with these texts in it, each behind its keyword.
///
/// # Errors
/// What the plotting library or the encoder says.
pub fn png(scene: &Scene, texts: &[(&str, String)]) -> Result<Vec<u8>, String> {
    register()?;
    // A figure is a few thousand dots wide.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let dots = |px: f64| (px * DOTS_PER_PX).round().clamp(1.0, 20_000.0) as u32;
    let (width, height) = (dots(scene.size.0), dots(scene.size.1));
    let large = (width * OVERSAMPLING, height * OVERSAMPLING);
    let mut pixels = vec![0; 3 * large.0 as usize * large.1 as usize];
    {
        let root = BitMapBackend::with_buffer(&mut pixels, large).into_drawing_area();
        paint(scene, &root).map_err(|e| e.to_string())?;
        root.present().map_err(|e| e.to_string())?;
    }
    let pixels = averaged(&pixels, large.0 as usize);
    encode(&pixels, (width, height), texts).map_err(|e| e.to_string())
}

/// Few colours are written as places in a list of them, which takes a third of the bytes.
fn encode(pixels: &[u8], (width, height): (u32, u32), texts: &[(&str, String)]) -> Result<Vec<u8>, png::EncodingError> {
    let mut out = Vec::new();
    let mut info = png::Info::with_size(width, height);
    info.pixel_dims =
        Some(png::PixelDimensions { xppu: PIXELS_PER_METRE, yppu: PIXELS_PER_METRE, unit: png::Unit::Meter });
    (info.color_type, info.bit_depth) = (png::ColorType::Rgb, png::BitDepth::Eight);
    let mut encoder = png::Encoder::with_info(&mut out, info)?;
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Sub);
    for (keyword, text) in texts {
        encoder.add_itxt_chunk((*keyword).to_owned(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(out)
}

/// Every pixel of the file as the mean of the two by two it was drawn with.
fn averaged(pixels: &[u8], width: usize) -> Vec<u8> {
    const { assert!(OVERSAMPLING == 2, "pixels are averaged two by two") };
    let row = 3 * width;
    let mut out = Vec::with_capacity(pixels.len() / 4);
    for rows in pixels.chunks_exact(2 * row) {
        let (top, bottom) = rows.split_at(row);
        for (a, b) in top.chunks_exact(6).zip(bottom.chunks_exact(6)) {
            for channel in 0..3 {
                let sum = u16::from(a[channel])
                    + u16::from(a[channel + 3])
                    + u16::from(b[channel])
                    + u16::from(b[channel + 3]);
                out.push(((sum + 2) / 4).to_le_bytes()[0]);
            }
        }
    }
    out
}

const SCALE: f64 = DOTS_PER_PX * OVERSAMPLING as f64;

/// A length in drawn pixels.
// Places on a figure are far smaller than 2³¹.
#[allow(clippy::cast_possible_truncation)]
fn dot(px: f64) -> i32 {
    (px * SCALE).round().clamp(-1e6, 1e6) as i32
}

fn dots(p: &Px) -> (i32, i32) {
    (dot(p.0), dot(p.1))
}

fn stroke(tint: Tint, width: f64) -> ShapeStyle {
    colour(tint).stroke_width(dot(width).max(1).unsigned_abs())
}

fn colour(tint: Tint) -> RGBColor {
    let [r, g, b] = tint.rgb();
    RGBColor(r, g, b)
}

fn paint(scene: &Scene, root: &Canvas) -> Result<(), Box<dyn std::error::Error>> {
    root.fill(&WHITE)?;
    for element in &scene.elements {
        match element {
            Element::Rect { at, size, tint } => {
                let corners = [dots(at), dots(&(at.0 + size.0, at.1 + size.1))];
                root.draw(&Rectangle::new(corners, colour(*tint).filled()))?;
            }
            Element::Area { corners, tint } => {
                root.draw(&Polygon::new(corners.iter().map(dots).collect::<Vec<_>>(), colour(*tint).filled()))?;
            }
            Element::Line { points, tint, width, is_dashed } => {
                if *is_dashed {
                    for dash in dashes(points) {
                        line(root, &dash, *tint, *width)?;
                    }
                } else {
                    line(root, points, *tint, *width)?;
                }
            }
            Element::Segments { ends, tint, width } => {
                for ends in ends {
                    line(root, ends, *tint, *width)?;
                }
            }
            Element::Marks { at, tint, shape } => {
                for p in at {
                    mark(root, p, *tint, *shape)?;
                }
            }
            Element::Words(words) => write(root, words)?,
        }
    }
    Ok(())
}

/// A line whose steps are joined by discs: the plotting library would join their sides where they meet, which is far away at a sharp turn.
fn line(root: &Canvas, points: &[Px], tint: Tint, width: f64) -> Result<(), Box<dyn std::error::Error>> {
    let style = stroke(tint, width);
    for step in points.windows(2) {
        root.draw(&PathElement::new(step.iter().map(dots).collect::<Vec<_>>(), style))?;
    }
    let radius = dot(width) / 2;
    if radius > 1 && points.len() > 2 {
        for p in points {
            root.draw(&Circle::new(dots(p), radius, colour(tint).filled()))?;
        }
    }
    Ok(())
}

/// The dashes of a line.
fn dashes(points: &[Px]) -> Vec<Vec<Px>> {
    let (mut all, mut dash) = (Vec::new(), Vec::new());
    let (mut is_on, mut left) = (true, DASH.0);
    dash.extend(points.first());
    for step in points.windows(2) {
        let (mut from, to) = (step[0], step[1]);
        loop {
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let length = dx.hypot(dy);
            if length <= left {
                left -= length;
                if is_on {
                    dash.push(to);
                }
                break;
            }
            let share = left / length;
            from = (from.0 + share * dx, from.1 + share * dy);
            if is_on {
                dash.push(from);
                all.push(std::mem::take(&mut dash));
            } else {
                dash.push(from);
            }
            is_on = !is_on;
            left = if is_on { DASH.0 } else { DASH.1 };
        }
    }
    if dash.len() > 1 {
        all.push(dash);
    }
    all
}

fn mark(root: &Canvas, at: &Px, tint: Tint, shape: Shape) -> Result<(), Box<dyn std::error::Error>> {
    let fill = colour(tint).filled();
    // A rim of paper keeps marks apart where they overlap.
    match shape {
        Shape::Disc => {
            root.draw(&Circle::new(dots(at), dot(shape.radius() + 1.0), WHITE.filled()))?;
            root.draw(&Circle::new(dots(at), dot(shape.radius()), fill))?;
        }
        Shape::Dot => root.draw(&Circle::new(dots(at), dot(shape.radius()), fill))?,
        Shape::Ring => {
            root.draw(&Circle::new(dots(at), dot(shape.radius() + 0.5 * MARK_STROKE), fill))?;
            root.draw(&Circle::new(dots(at), dot(shape.radius() - 0.5 * MARK_STROKE), WHITE.filled()))?;
        }
        Shape::Cross => {
            for dy in [CROSS, -CROSS] {
                let arm = [(at.0 - CROSS, at.1 - dy), (at.0 + CROSS, at.1 + dy)];
                line(root, &arm, Tint::Paper, 4.4)?;
            }
            for dy in [CROSS, -CROSS] {
                let arm = [(at.0 - CROSS, at.1 - dy), (at.0 + CROSS, at.1 + dy)];
                line(root, &arm, tint, MARK_STROKE)?;
            }
        }
        Shape::Square | Shape::Triangle | Shape::Diamond => {
            let corners: Vec<(i32, i32)> = shape.corners().iter().map(|c| dots(&(at.0 + c.0, at.1 + c.1))).collect();
            let closed: Vec<(i32, i32)> = corners.iter().copied().chain(corners.first().copied()).collect();
            root.draw(&Polygon::new(corners, fill))?;
            root.draw(&PathElement::new(closed, stroke(Tint::Paper, 1.0)))?;
        }
    }
    Ok(())
}

fn write(root: &Canvas, words: &Words) -> Result<(), Box<dyn std::error::Error>> {
    let side = match words.anchor {
        Anchor::Start => HPos::Left,
        Anchor::Middle => HPos::Center,
        Anchor::End => HPos::Right,
    };
    let weight = if words.is_bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = (FONT, words.size * SCALE * FONT_SCALE, weight).into_font();
    let style = font.color(&colour(words.tint)).pos(Pos::new(side, VPos::Center));
    root.draw(&Text::new(words.text.clone(), dots(&words.at), style))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_what_it_is_and_how_large_it_prints() {
        let mut scene = Scene::new((120.0, 40.0));
        scene.words((10.0, 20.0), "tip angle", Anchor::Start, Tint::Ink);
        let bytes = png(&scene, &[("Title", "tip angle, °".to_owned())]).unwrap();
        assert_eq!(bytes, png(&scene, &[("Title", "tip angle, °".to_owned())]).unwrap());
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let info = reader.info();
        assert_eq!((info.width, info.height), (300, 100));
        assert_eq!(info.pixel_dims.map(|d| d.xppu), Some(PIXELS_PER_METRE));
        let text = &info.utf8_text[0];
        assert_eq!((text.keyword.as_str(), text.get_text().unwrap().as_str()), ("Title", "tip angle, °"));
    }

    #[test]
    fn dashes_cover_their_share_of_a_line_across_its_corners() {
        let all = dashes(&[(0.0, 0.0), (50.0, 0.0), (50.0, 65.0)]);
        let length = |dash: &Vec<Px>| dash.windows(2).map(|s| (s[1].0 - s[0].0).hypot(s[1].1 - s[0].1)).sum::<f64>();
        assert_eq!(all.len(), 10);
        assert!((all.iter().map(length).sum::<f64>() - 70.0).abs() < 1e-9);
    }
}
