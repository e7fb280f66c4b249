//! Pictures as logs: of folders and of topics in bags.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "common/bag.rs"]
mod bag;

use bag::{COMPRESSED, IMAGE, Recorder, picture};
use image::{GrayImage, ImageFormat, Luma};
use pneuval_ingest::IngestError;
use pneuval_ingest::camera::scale::Scale;
use pneuval_ingest::camera::task::{Setup, Task, What};
use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::formats::pictures::PictureOptions;
use pneuval_ingest::formats::{Format, Options, read};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{ColumnRef, Keep, Recording, Table};
use statrs::distribution::{ContinuousCDF, Normal};

const SIZE: (u32, u32) = (160, 120);

/// A dark strip from top to bottom, so many px wide.
fn strip(width: f64) -> GrayImage {
    let normal = Normal::new(0.0, 1.5).unwrap();
    let below = |x: f64| normal.cdf(x);
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let inside = 0.5 * width - (f64::from(x) - 80.2).abs();
        // Alternating, so that rounding does not show.
        let noise = f64::from((7 * x + 13 * y) % 5) - 2.0;
        let value = 200.0 - 150.0 * below(inside) + noise;
        // Between 48 and 202.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Luma([value.round() as u8])
    })
}

fn png(image: &GrayImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(vec![]);
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The fields of an `Image` behind its header.
fn rows(image: &GrayImage, encoding: &str) -> Vec<u8> {
    let text = [encoding.as_bytes(), &[0]].concat();
    let length = u32::try_from(text.len()).unwrap();
    let mut rest = [&SIZE.1.to_le_bytes()[..], &SIZE.0.to_le_bytes(), &length.to_le_bytes(), &text, &[0]].concat();
    // The header takes 16 bytes: from there on fields of four bytes stand at multiples of four.
    rest.resize(rest.len().next_multiple_of(4), 0);
    [&rest[..], &SIZE.0.to_le_bytes(), &(SIZE.0 * SIZE.1).to_le_bytes(), image.as_raw()].concat()
}

/// The fields of a `CompressedImage`.
fn file(bytes: &[u8]) -> Vec<u8> {
    [&4_u32.to_le_bytes()[..], b"png\0", &u32::try_from(bytes.len()).unwrap().to_le_bytes(), bytes].concat()
}

fn options(topic: &str) -> Options {
    let sought = pneuval_ingest::camera::silhouette::Sought {
        axis: Some(pneuval_ingest::camera::silhouette::Axis::Vertical),
        ..Default::default()
    };
    let setup = Setup { scale: Some(Scale { metre_per_px: 1e-4, std: 0.0 }), ..Setup::default() };
    let task = Some(Task { what: What::Diameter(sought), setup });
    let pictures = PictureOptions { task, topic: Some(topic.to_owned()), ..PictureOptions::default() };
    Options { format: Some(Format::Mcap), pictures, ..Options::default() }
}

fn table<'r>(recording: &'r Recording, name: &str) -> &'r Table {
    recording.tables.iter().find(|table| table.name == name).unwrap()
}

fn numbers<'t>(table: &'t Table, column: &str) -> &'t [f64] {
    table.column(column).unwrap().cells.numbers().unwrap()
}

#[test]
fn the_pictures_of_a_topic_are_measured_at_their_stamps() {
    let mut recorder = Recorder::plain();
    let raw = recorder.channel("/raw", ("sensor_msgs/msg/Image", "ros2msg", IMAGE.as_bytes()), "cdr");
    let small = recorder.channel("/png", ("sensor_msgs/msg/CompressedImage", "ros2msg", COMPRESSED.as_bytes()), "cdr");
    let widths: Vec<f64> = (0..21).map(|i| 40.0 + 0.7 * f64::from(i)).collect();
    for (i, width) in (0..).zip(&widths) {
        let image = strip(*width);
        recorder.send(raw, u64::from(i) * 1_000_000, &picture(i, &rows(&image, "mono8")));
        recorder.send(small, u64::from(i) * 1_000_000, &picture(i, &file(&png(&image))));
    }
    // One that cannot be read, one that is cut, one without a body.
    let odd = strip(50.0);
    recorder.send(raw, 30_000_000, &picture(30, &rows(&odd, "bayer_rggb8")));
    recorder.send(small, 30_000_000, &picture(30, &file(&png(&odd)[..900])));
    recorder.send(raw, 31_000_000, &picture(31, &rows(&GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([90])), "mono8")));
    let bytes = recorder.bytes();
    for (topic, of, told) in [
        (
            "/raw",
            23,
            vec![
                FindingKind::BrokenPicture,
                FindingKind::NotMeasured,
                FindingKind::PictureQuality,
                FindingKind::PictureScale,
                FindingKind::PictureScale,
            ],
        ),
        (
            "/png",
            22,
            vec![
                FindingKind::BrokenPicture,
                FindingKind::PictureQuality,
                FindingKind::PictureScale,
                FindingKind::PictureScale,
            ],
        ),
    ] {
        let found = read(&RawFile::of_bytes("r.mcap", &bytes), &options(topic), Keep::All).unwrap();
        let measured = table(&found, topic);
        assert_eq!((measured.rows, found.tables.len()), (of, 2));
        let (stamps, values) = (numbers(measured, "header.stamp"), numbers(measured, "diameter"));
        assert_eq!(measured.time().unwrap().name, "header.stamp");
        for (i, width) in widths.iter().enumerate() {
            assert!((stamps[i] - i as f64).abs() < 1e-6 && (values[i] - 0.1 * width).abs() < 0.005, "{i} {values:?}");
        }
        assert!(values[21..].iter().all(|v| v.is_nan()));
        let kinds: Vec<FindingKind> = found.findings.iter().map(|f| f.kind).collect();
        assert_eq!(kinds, told, "{:?}", found.findings);
        assert!(found.findings[0].text.contains("#21"), "{:?}", found.findings);
        // Some are shown, spread over all; their number does not grow with that of the pictures.
        let shown: Vec<usize> = found.photographs.iter().map(|p| p.sample).collect();
        assert_eq!(shown, [0, 4, 8, 12, 16, 20], "{shown:?}");
        assert!(found.photographs.iter().all(|p| p.table == topic && p.marks.label.ends_with("mm")));
        // What is not asked for is not kept.
        let asked = [ColumnRef::Name(format!("{topic}.diameter"))];
        let kept = read(&RawFile::of_bytes("r.mcap", &bytes), &options(topic), Keep::Only(&asked)).unwrap();
        let kept = table(&kept, topic);
        assert_eq!(numbers(kept, "diameter")[..21], values[..21]);
        assert!(
            kept.column("tilt").unwrap().cells.is_empty() && !kept.column("header.stamp").unwrap().cells.is_empty()
        );
    }
    let error = read(&RawFile::of_bytes("r.mcap", &bytes), &options("/rwa"), Keep::All).unwrap_err();
    assert!(matches!(&error, IngestError::Malformed { .. }) && error.to_string().contains("did you mean `/raw`?"));
}
