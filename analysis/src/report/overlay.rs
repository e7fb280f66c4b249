//! What was measured, drawn on the photograph: edges, axis, the line of the width, the value.

use std::io::Cursor;

use image::codecs::{jpeg::JpegEncoder, png::PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use plotters::prelude::*;
use plotters::style::{FontStyle, FontTransform};

use super::scene::{FONT, register};
use pneuval_ingest::camera::diameter::EdgeUse;
use pneuval_ingest::camera::photograph::Photograph;
use pneuval_ingest::camera::picture::{Picture, Pixels, Place};
use pneuval_ingest::camera::task::Marks;

/// Overlays are as wide as this at most, in px: larger photographs are shown smaller.
const WIDTH_MAX: usize = 1920;

/// Of 100: what a small picture needs, in some 20 kB.
const THUMBNAIL_QUALITY: u8 = 80;

const EDGE: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
const BEYOND: RGBColor = RGBColor(0x8f, 0x9a, 0xa8);
const ODD: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
const AXIS: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
const LINE: RGBColor = RGBColor(0x00, 0xb0, 0x73);
const BOX: RGBColor = RGBColor(0x10, 0x18, 0x22);

/// The photograph with its marks as a PNG file, no wider than `width_max` px.
///
/// # Errors
/// What the plotting library or the PNG encoder says.
pub fn overlay(picture: &Picture, marks: &Marks, width_max: usize) -> Result<Vec<u8>, String> {
    let by = picture.width().div_ceil(width_max.clamp(1, WIDTH_MAX)).max(1);
    let (pixels, size) = drawn(&picture.smaller(by), marks, by)?;
    let mut png = Vec::new();
    PngEncoder::new(Cursor::new(&mut png))
        .write_image(&pixels, size.0, size.1, ExtendedColorType::Rgb8)
        .map_err(|e| e.to_string())?;
    Ok(png)
}

/// A small photograph with its marks as a JPEG file: of noise that nobody looks at, PNG would keep every bit.
///
/// # Errors
/// What the plotting library or the encoder says.
pub fn thumbnail(photograph: &Photograph) -> Result<Vec<u8>, String> {
    let (pixels, size) = drawn(&photograph.picture, &photograph.marks, photograph.by)?;
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, THUMBNAIL_QUALITY)
        .write_image(&pixels, size.0, size.1, ExtendedColorType::Rgb8)
        .map_err(|e| e.to_string())?;
    Ok(jpeg)
}

/// A picture that is so many times smaller than the photograph its marks are for, with these.
fn drawn(small: &Picture, marks: &Marks, by: usize) -> Result<(Vec<u8>, (u32, u32)), String> {
    register()?;
    let (width, height) = (small.width(), small.height());
    let mut pixels: Vec<u8> = match small.pixels() {
        Pixels::Rgb8(all) => all.clone(),
        // Grey as three equal bytes.
        _ => (0..width * height)
            .flat_map(|i| {
                // Rounded and between 0 and 255.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                small.rgb(i % width, i / width).map(|v| v.round() as u8)
            })
            .collect(),
    };
    let size = (u32::try_from(width).unwrap_or(u32::MAX), u32::try_from(height).unwrap_or(u32::MAX));
    draw(&mut pixels, size, marks, by).map_err(|e| e.to_string())?;
    Ok((pixels, size))
}

fn draw(pixels: &mut [u8], size: (u32, u32), marks: &Marks, by: usize) -> Result<(), Box<dyn std::error::Error>> {
    let root = BitMapBackend::with_buffer(pixels, size).into_drawing_area();
    // The middle of a group of px, in its own.
    // Places on a picture are far smaller than 2³¹.
    #[allow(clippy::cast_possible_truncation)]
    let at = |place: &Place| {
        let of = |v: f64| ((v + 0.5) / by as f64 - 0.5).round().clamp(-1e6, 1e6) as i32;
        (of(place.x), of(place.y))
    };
    for (place, used) in &marks.edges {
        let (colour, radius) = match used {
            EdgeUse::Used => (EDGE, 1),
            EdgeUse::Beyond => (BEYOND, 1),
            EdgeUse::Odd => (ODD, 2),
        };
        root.draw(&Circle::new(at(place), radius, colour.filled()))?;
    }
    for line in &marks.axes {
        root.draw(&PathElement::new(
            line.iter().map(at).collect::<Vec<_>>(),
            AXIS.stroke_width((size.0 / 900).max(1)),
        ))?;
    }
    let thick = (size.0 / 700).max(1);
    for line in &marks.lines {
        root.draw(&PathElement::new(line.iter().map(at).collect::<Vec<_>>(), LINE.stroke_width(thick)))?;
        for end in line {
            root.draw(&Circle::new(at(end), 2 * thick, LINE.filled()))?;
        }
    }
    if !marks.label.is_empty() {
        // As high as a fortieth of the picture, and readable on a small one.
        let height = (f64::from(size.0.min(2 * size.1)) / 45.0).max(13.0);
        let font = FontDesc::new(FontFamily::Name(FONT), height * 1.24, FontStyle::Bold).transform(FontTransform::None);
        let style = font.color(&WHITE).into_text_style(&root);
        let (wide, high) = root.estimate_text_size(&marks.label, &style)?;
        let pad = i32::try_from(high / 2).unwrap_or(4);
        let (wide, high) = (i32::try_from(wide).unwrap_or(0), i32::try_from(high).unwrap_or(0));
        let corner = (pad + wide + 2 * pad, pad + high + 2 * pad);
        root.draw(&Rectangle::new([(pad, pad), corner], BOX.mix(0.75).filled()))?;
        root.draw_text(&marks.label, &style, (2 * pad, pad + pad))?;
    }
    root.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_lie_where_they_are_said_to_and_a_large_picture_is_shown_smaller() {
        let picture = Picture::new(4000, 200, Pixels::Gray8(vec![100; 800_000])).unwrap();
        let marks = Marks {
            edges: vec![(Place::new(3000.0, 100.0), EdgeUse::Used)],
            lines: vec![[Place::new(300.0, 150.0), Place::new(900.0, 150.0)]],
            ..Marks::default()
        };
        let png = overlay(&picture, &marks, 2000).unwrap();
        let drawn = image::load_from_memory(&png).unwrap().into_rgb8();
        assert_eq!(drawn.dimensions(), (1333, 66));
        let is = |x: u32, y: u32, colour: RGBColor| drawn.get_pixel(x, y).0 == [colour.0, colour.1, colour.2];
        assert!(is(1000, 33, EDGE) && is(200, 50, LINE) && !is(700, 20, LINE));
        assert_eq!(drawn.get_pixel(700, 20).0, [100; 3]);
        assert_eq!(png, overlay(&picture, &marks, 2000).unwrap());
    }
}
