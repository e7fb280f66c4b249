//! From rows of pixels, as cameras send them in messages, to a picture.
//!
//! Encodings are those of `sensor_msgs/image_encodings` and of `OpenCV`'s types beside them (three channels are blue, green, red there).

use super::decode::PIXELS_MAX;
use super::picture::{Picture, Pixels};

/// Rows of pixels in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows<'a> {
    /// `mono8`, `bgr8`, `16UC1`, ...
    pub encoding: &'a str,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes from one row to the next.
    pub step: u32,
    /// Whether pixels of several bytes begin with the highest.
    pub big_endian: bool,
    /// The bytes.
    pub data: &'a [u8],
}

/// How the bytes of a pixel lie.
#[derive(Clone, Copy)]
struct Layout {
    /// Bytes of a sample: 1 or 2.
    depth: usize,
    /// Samples of a pixel.
    samples: usize,
    /// Which of them are taken: brightness, or red, green, blue.
    taken: Taken,
}

#[derive(Clone, Copy)]
enum Taken {
    Grey(usize),
    Colour([usize; 3]),
}

fn layout(encoding: &str) -> Option<Layout> {
    let grey = |depth, samples, at| Some(Layout { depth, samples, taken: Taken::Grey(at) });
    let colour = |depth, samples, order| Some(Layout { depth, samples, taken: Taken::Colour(order) });
    match encoding {
        "mono8" | "8UC1" => grey(1, 1, 0),
        "mono16" | "16UC1" => grey(2, 1, 0),
        "rgb8" => colour(1, 3, [0, 1, 2]),
        "bgr8" | "8UC3" => colour(1, 3, [2, 1, 0]),
        "rgba8" => colour(1, 4, [0, 1, 2]),
        "bgra8" | "8UC4" => colour(1, 4, [2, 1, 0]),
        "rgb16" => colour(2, 3, [0, 1, 2]),
        "bgr16" | "16UC3" => colour(2, 3, [2, 1, 0]),
        "rgba16" => colour(2, 4, [0, 1, 2]),
        "bgra16" | "16UC4" => colour(2, 4, [2, 1, 0]),
        // Brightness of every pixel beside the colours of pairs.
        "yuv422" | "uyvy" => grey(1, 2, 1),
        "yuv422_yuy2" | "yuyv" => grey(1, 2, 0),
        _ => None,
    }
}

/// The picture of rows.
///
/// # Errors
/// Why there is none, in words: an encoding that is not read, fewer bytes than the rows take, more pixels than are decoded.
pub fn picture(rows: Rows) -> Result<Picture, String> {
    let Rows { encoding, width, height, step, big_endian, data } = rows;
    let Some(Layout { depth, samples, taken }) = layout(encoding) else {
        let next = if encoding.starts_with("bayer") {
            "record the topic behind `image_proc`, where each pixel has its brightness"
        } else {
            "record it as mono8, mono16, rgb8 or bgr8"
        };
        return Err(format!("the encoding {} is not read; {next}", worded(encoding)));
    };
    if u64::from(width) * u64::from(height) > PIXELS_MAX {
        let most = PIXELS_MAX / 1_000_000;
        return Err(format!("{width} × {height} px are more than the {most} million that are decoded"));
    }
    // At most 2³² of 8 bytes.
    let (width, height, step) = (width as usize, height as usize, step as usize);
    let row_bytes = width * samples * depth;
    let whole = height.checked_sub(1).map_or(0, |before| before.saturating_mul(step).saturating_add(row_bytes));
    if width == 0 || height == 0 || step < row_bytes || data.len() < whole {
        return Err(format!(
            "{} bytes in rows of {step} are not {width} × {height} px of {encoding}: the message is cut, or states another size",
            data.len()
        ));
    }
    let wide = |bytes: &[u8], k: usize| {
        let two = [bytes[2 * k], bytes[2 * k + 1]];
        if big_endian { u16::from_be_bytes(two) } else { u16::from_le_bytes(two) }
    };
    let pixels_of = |row: usize| data[row * step..][..row_bytes].chunks_exact(samples * depth);
    let all = (0..height).flat_map(pixels_of);
    let pixels = match (depth, taken) {
        (1, Taken::Grey(at)) => Pixels::Gray8(all.map(|px| px[at]).collect()),
        (1, Taken::Colour(order)) => Pixels::Rgb8(all.flat_map(|px| order.map(|k| px[k])).collect()),
        (_, Taken::Grey(at)) => Pixels::Gray16(all.map(|px| wide(px, at)).collect()),
        (_, Taken::Colour(order)) => Pixels::Rgb16(all.flat_map(|px| order.map(|k| wide(px, k))).collect()),
    };
    Picture::new(width, height, pixels).ok_or_else(|| "it has no pixels".to_owned())
}

/// A word of a file, as text on one line.
fn worded(word: &str) -> String {
    let short: String = word.chars().take(40).collect();
    format!("`{}`", short.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows<'a>(encoding: &'a str, width: u32, step: u32, data: &'a [u8]) -> Rows<'a> {
        Rows { encoding, width, height: 2, step, big_endian: false, data }
    }

    #[test]
    fn samples_go_where_their_encoding_says() {
        // Two rows of two px, with a byte between rows that belongs to none.
        let grey = picture(rows("mono8", 2, 3, &[1, 2, 99, 3, 4])).unwrap();
        assert_eq!(grey.pixels(), &Pixels::Gray8(vec![1, 2, 3, 4]));
        let deep = [1, 2, 3, 4, 5, 6, 7, 8];
        let little = picture(rows("mono16", 2, 4, &deep)).unwrap();
        assert_eq!(little.pixels(), &Pixels::Gray16(vec![0x0201, 0x0403, 0x0605, 0x0807]));
        let big = picture(Rows { big_endian: true, ..rows("16UC1", 2, 4, &deep) }).unwrap();
        assert_eq!(big.pixels(), &Pixels::Gray16(vec![0x0102, 0x0304, 0x0506, 0x0708]));
        for (encoding, expected) in [("rgb8", [1, 2, 3, 4, 5, 6]), ("bgr8", [3, 2, 1, 6, 5, 4])] {
            let colour = picture(rows(encoding, 1, 3, &[1, 2, 3, 4, 5, 6])).unwrap();
            assert_eq!(colour.pixels(), &Pixels::Rgb8(expected.to_vec()), "{encoding}");
        }
        let with_alpha = picture(rows("bgra8", 1, 4, &[1, 2, 3, 255, 4, 5, 6, 255])).unwrap();
        assert_eq!(with_alpha.pixels(), &Pixels::Rgb8(vec![3, 2, 1, 6, 5, 4]));
        let brightness = picture(rows("yuv422", 2, 4, &[9, 1, 9, 2, 9, 3, 9, 4])).unwrap();
        assert_eq!(brightness.pixels(), &Pixels::Gray8(vec![1, 2, 3, 4]));
    }

    #[test]
    fn messages_that_do_not_hold_what_they_state_are_refused() {
        for (asked, words) in [
            (rows("mono8", 2, 2, &[1, 2, 3]), "3 bytes in rows of 2"),
            (rows("mono8", 2, 1, &[1, 2, 3, 4]), "in rows of 1"),
            (rows("mono8", 0, 2, &[1, 2, 3, 4]), "0 × 2 px"),
            (rows("mono8", u32::MAX, u32::MAX, &[]), "million"),
            (Rows { height: 0, ..rows("mono8", 2, 2, &[]) }, "2 × 0 px"),
            (rows("bayer_rggb8", 2, 2, &[1, 2, 3, 4]), "image_proc"),
            (rows("32FC1", 2, 8, &[0; 16]), "`32FC1` is not read"),
            (rows("a\nb", 2, 8, &[0; 16]), r"`a\nb`"),
        ] {
            let why = picture(asked).unwrap_err();
            assert!(why.contains(words), "{why}");
        }
    }
}
