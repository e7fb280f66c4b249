//! Pictures as files.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageFormat};

use pneuval_ingest::camera::picture::{Picture, Pixels};

use super::NoPhotograph;

/// Quality of JPEGs: that of most cameras.
const QUALITY: u8 = 95;

/// How a picture is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum File {
    /// 8 or 16 bits, as the picture has them.
    Png,
    /// 8 or 16 bits, as the picture has them.
    Tiff,
    /// 8 bits; with how the camera was held, as EXIF has it (1 upright, 3 upside down, 6 and 8 on a side).
    Jpeg {
        /// Orientation.
        orientation: Option<u8>,
    },
}

/// The bytes of a file.
///
/// # Errors
/// [`NoPhotograph::File`] for 16 bits in a JPEG, and an orientation that there is none of.
pub fn bytes(picture: &Picture, file: File) -> Result<Vec<u8>, NoPhotograph> {
    let failed = |name| move |_: image::ImageError| NoPhotograph::File(name);
    let side = |px: usize, name| u32::try_from(px).map_err(|_| NoPhotograph::File(name));
    let (name, format) = match file {
        File::Png => ("PNG", ImageFormat::Png),
        File::Tiff => ("TIFF", ImageFormat::Tiff),
        File::Jpeg { .. } => ("JPEG", ImageFormat::Jpeg),
    };
    let (width, height) = (side(picture.width(), name)?, side(picture.height(), name)?);
    let deep = |all: &[u16]| all.iter().flat_map(|sample| sample.to_ne_bytes()).collect::<Vec<u8>>();
    let (samples, colour) = match picture.pixels() {
        Pixels::Gray8(all) => (all.clone(), ExtendedColorType::L8),
        Pixels::Rgb8(all) => (all.clone(), ExtendedColorType::Rgb8),
        Pixels::Gray16(all) => (deep(all), ExtendedColorType::L16),
        Pixels::Rgb16(all) => (deep(all), ExtendedColorType::Rgb16),
    };
    let mut bytes = Cursor::new(Vec::new());
    match file {
        File::Jpeg { orientation } => {
            if !matches!(colour, ExtendedColorType::L8 | ExtendedColorType::Rgb8) {
                return Err(NoPhotograph::File("JPEG: it has 8 bits, the picture 16"));
            }
            let mut encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
            if let Some(orientation) = orientation {
                let expected = NoPhotograph::File("JPEG: expected an orientation of 1 to 8");
                let exif = (1..=8).contains(&orientation).then(|| exif(orientation)).ok_or(expected)?;
                encoder.set_exif_metadata(exif).map_err(|_| NoPhotograph::File("JPEG with EXIF"))?;
            }
            encoder.write_image(&samples, width, height, colour).map_err(failed(name))?;
        }
        File::Png | File::Tiff => {
            image::write_buffer_with_format(&mut bytes, &samples, width, height, colour, format)
                .map_err(failed(name))?;
        }
    }
    Ok(bytes.into_inner())
}

/// One entry of TIFF, most significant byte first: the orientation, a short number.
fn exif(orientation: u8) -> Vec<u8> {
    [&b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0"[..], &[orientation], &b"\0\0\0\0\0\0"[..]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneuval_ingest::camera::decode::decode;

    #[test]
    fn what_is_written_is_read_again_in_every_format_and_depth() {
        let ramp = |n: u8| (0..n).map(|i| 3 * i).collect::<Vec<u8>>();
        let deep = |n: u16| (0..n).map(|i| 801 * i).collect::<Vec<u16>>();
        for pixels in
            [Pixels::Gray8(ramp(24)), Pixels::Gray16(deep(24)), Pixels::Rgb8(ramp(72)), Pixels::Rgb16(deep(72))]
        {
            let picture = Picture::new(6, 4, pixels).unwrap();
            for file in [File::Png, File::Tiff] {
                assert_eq!(decode(&bytes(&picture, file).unwrap()).unwrap(), picture);
            }
        }
        let grey = Picture::new(6, 4, Pixels::Gray8(ramp(24))).unwrap();
        let upright = decode(&bytes(&grey, File::Jpeg { orientation: None }).unwrap()).unwrap();
        assert!((upright.luma(3, 2) - grey.luma(3, 2)).abs() < 4.0);
        // Held on a side: the lower left is shown at the upper left.
        let turned = decode(&bytes(&grey, File::Jpeg { orientation: Some(6) }).unwrap()).unwrap();
        assert_eq!((turned.width(), turned.height()), (4, 6));
        assert!((turned.luma(0, 0) - grey.luma(0, 3)).abs() < 4.0);
        assert!(bytes(&grey, File::Jpeg { orientation: Some(9) }).is_err());
        let deep = Picture::new(6, 4, Pixels::Gray16(deep(24))).unwrap();
        assert!(bytes(&deep, File::Jpeg { orientation: None }).is_err());
    }
}
