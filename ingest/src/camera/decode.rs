//! From the bytes of a PNG, JPEG or TIFF file to a picture the right way up.
//!
//! The size is looked at before anything is decoded, and turned as the camera was held (EXIF). A JPEG without its end is cut: the decoder
//! would paint the rest grey.

use std::fmt;
use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::picture::{Picture, Pixels};

/// Pixels of a picture, at most: beyond any camera of a lab.
pub const PIXELS_MAX: u64 = 64 << 20;

/// Bytes per pixel while it is decoded and turned.
const BYTES_PER_PIXEL: u64 = 16;

/// Bytes behind the end of a JPEG that some cameras write.
const BEHIND_END: usize = 64 << 10;

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Broken {
    /// The bytes are those of no format that is read.
    Unknown,
    /// More pixels than are decoded.
    TooLarge {
        /// In px.
        width: u32,
        /// In px.
        height: u32,
    },
    /// The file ends before the picture does.
    Cut,
    /// What the decoder says.
    Damaged(String),
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => write!(f, "its bytes are those of no PNG, JPEG or TIFF picture"),
            Self::TooLarge { width, height } => {
                write!(f, "{width} × {height} px are more than the {} million that are decoded", PIXELS_MAX / 1_000_000)
            }
            Self::Cut => write!(f, "it ends before the picture does: copied while it was written?"),
            Self::Damaged(why) => write!(f, "it is damaged: {why}"),
        }
    }
}

/// Whether a file begins as a picture that is read.
pub fn is_picture(head: &[u8]) -> bool {
    format(head).is_some()
}

fn format(head: &[u8]) -> Option<ImageFormat> {
    let is = |magic: &[u8]| head.starts_with(magic);
    if is(b"\x89PNG\r\n\x1a\n") {
        Some(ImageFormat::Png)
    } else if is(&[0xff, 0xd8, 0xff]) {
        Some(ImageFormat::Jpeg)
    } else if is(b"II*\0") || is(b"MM\0*") {
        Some(ImageFormat::Tiff)
    } else {
        None
    }
}

/// The picture in the bytes of a file.
///
/// # Errors
/// Why there is none.
pub fn decode(bytes: &[u8]) -> Result<Picture, Broken> {
    let damaged = |error: image::ImageError| Broken::Damaged(error.to_string());
    let format = format(bytes).ok_or(Broken::Unknown)?;
    if format == ImageFormat::Jpeg && !has_end(bytes) {
        return Err(Broken::Cut);
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // What a file says of its size is checked below, by what it would take in memory.
    reader.no_limits();
    let mut decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > PIXELS_MAX {
        return Err(Broken::TooLarge { width, height });
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(PIXELS_MAX * BYTES_PER_PIXEL);
    decoder.set_limits(limits).map_err(damaged)?;
    // What cannot be read of it is as if it were not there.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    image.apply_orientation(orientation);
    let (width, height) = (image.width() as usize, image.height() as usize);
    let pixels = match image {
        DynamicImage::ImageLuma8(grey) => Pixels::Gray8(grey.into_raw()),
        DynamicImage::ImageLuma16(grey) => Pixels::Gray16(grey.into_raw()),
        DynamicImage::ImageRgb8(colour) => Pixels::Rgb8(colour.into_raw()),
        DynamicImage::ImageRgb16(colour) => Pixels::Rgb16(colour.into_raw()),
        DynamicImage::ImageLumaA8(_) => Pixels::Gray8(image.into_luma8().into_raw()),
        DynamicImage::ImageLumaA16(_) => Pixels::Gray16(image.into_luma16().into_raw()),
        DynamicImage::ImageRgba8(_) => Pixels::Rgb8(image.into_rgb8().into_raw()),
        other => Pixels::Rgb16(other.into_rgb16().into_raw()),
    };
    Picture::new(width, height, pixels).ok_or_else(|| Broken::Damaged("it has no pixels".to_owned()))
}

/// Whether a JPEG has its end, or near it.
fn has_end(bytes: &[u8]) -> bool {
    let tail = &bytes[bytes.len().saturating_sub(BEHIND_END)..];
    tail.windows(2).any(|pair| pair == [0xff, 0xd9])
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageBuffer, Luma, RgbImage};

    fn written(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    /// An EXIF segment that says only how the camera was held, behind the first two bytes of a JPEG.
    fn turned(jpeg: &[u8], orientation: u8) -> Vec<u8> {
        let tiff =
            [&b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0"[..], &[orientation], &b"\0\0\0\0\0\0"[..]]
                .concat();
        let length = u16::try_from(tiff.len() + 2).unwrap().to_be_bytes();
        [&jpeg[..2], &[0xff, 0xe1], &length, &tiff, &jpeg[2..]].concat()
    }

    #[test]
    fn every_format_and_depth_gives_its_pixels_and_a_jpeg_is_turned_as_the_camera_was_held() {
        let grey = GrayImage::from_fn(40, 20, |x, _| Luma([u8::try_from(5 * x).unwrap()]));
        for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Jpeg] {
            let picture = decode(&written(&grey.clone().into(), format)).unwrap();
            assert_eq!((picture.width(), picture.height()), (40, 20));
            assert!((picture.luma(30, 7) - 150.0).abs() < 2.0, "{format:?}");
        }
        let deep: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(4, 3, Luma([25_700]));
        for format in [ImageFormat::Png, ImageFormat::Tiff] {
            assert!((decode(&written(&deep.clone().into(), format)).unwrap().luma(1, 1) - 100.0).abs() < 1e-3);
        }
        let colour = RgbImage::from_fn(24, 16, |x, _| image::Rgb([if x < 12 { 200 } else { 20 }, 20, 20]));
        let jpeg = written(&colour.into(), ImageFormat::Jpeg);
        // 6: the top of what was seen lies to the right of the file.
        let picture = decode(&turned(&jpeg, 6)).unwrap();
        assert_eq!((picture.width(), picture.height()), (16, 24));
        assert!(picture.rgb(8, 2)[0] > 150.0 && picture.rgb(8, 22)[0] < 60.0);
        assert_eq!(decode(&turned(&jpeg, 1)).unwrap().width(), 24);
    }

    #[test]
    fn what_is_cut_no_picture_or_too_large_is_refused_before_it_is_decoded() {
        let grey = GrayImage::from_fn(200, 100, |x, y| Luma([u8::try_from((x * y) % 251).unwrap()]));
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff] {
            let bytes = written(&grey.clone().into(), format);
            assert!(is_picture(&bytes) && decode(&bytes).is_ok());
            for cut in [bytes.len() / 2, bytes.len() - 40] {
                assert!(decode(&bytes[..cut]).is_err(), "{format:?} {cut}");
            }
        }
        assert_eq!(decode(b"PK\x03\x04"), Err(Broken::Unknown));
        // A hundred million pixels in 60 bytes: width and height are at bytes 16 to 23, with a checksum behind.
        let mut bomb = written(&grey.into(), ImageFormat::Png);
        bomb[16..20].copy_from_slice(&10_000_u32.to_be_bytes());
        bomb[20..24].copy_from_slice(&10_000_u32.to_be_bytes());
        let mut crc = 0xffff_ffff_u32;
        for byte in &bomb[12..29] {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
            }
        }
        bomb[29..33].copy_from_slice(&(!crc).to_be_bytes());
        assert_eq!(decode(&bomb), Err(Broken::TooLarge { width: 10_000, height: 10_000 }));
    }
}
