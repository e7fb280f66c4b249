//! What is stored comes back, and the same columns make the same bytes.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use pneuval_ingest::IngestError;
use pneuval_ingest::recording::Cells;
use pneuval_ingest::store::{Columns, Series, read_parquet, read_parquet_metadata, write_cells, write_parquet};

fn columns() -> Columns {
    vec![
        ("form".to_owned(), Series::Text(vec!["printed".to_owned(), String::new(), "Δ µ".to_owned()])),
        ("value".to_owned(), Series::Number(vec![Some(-0.0), None, Some(f64::MIN_POSITIVE)])),
    ]
}

#[test]
fn columns_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    write_parquet(&path, &columns()).unwrap();
    assert_eq!(read_parquet(&path).unwrap(), columns());
}

#[test]
fn the_same_columns_make_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.parquet"), folder.path().join("b.parquet"));
    write_parquet(&a, &columns()).unwrap();
    write_parquet(&b, &columns()).unwrap();
    assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
}

#[test]
fn cells_and_words_about_them_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let (words, numbers) = (Cells::Text(vec!["a, b".into(), "Δ".into()]), Cells::Numbers(vec![-0.0, f64::NAN]));
    let metadata = vec![("unit".to_owned(), "kPa".to_owned()), ("title".to_owned(), "Δp".to_owned())];
    write_cells(&path, &[("runs", &words), ("p", &numbers)], &metadata).unwrap();
    let expected = [
        ("runs".to_owned(), Series::Text(vec!["a, b".into(), "Δ".into()])),
        ("p".to_owned(), Series::Number(vec![Some(-0.0), None])),
    ];
    assert_eq!((read_parquet(&path).unwrap(), read_parquet_metadata(&path).unwrap()), (expected.into(), metadata));
    let short = Cells::Numbers(vec![1.0]);
    let error = write_cells(&path, &[("runs", &words), ("p", &short)], &[]).unwrap_err();
    assert!(error.to_string().contains("column `p` holds 1 of 2 rows"), "{error}");
}

#[test]
fn a_damaged_or_missing_file_is_an_error_with_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    assert!(matches!(read_parquet(&path), Err(IngestError::Read { .. })));
    write_parquet(&path, &columns()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for cut in [0, 4, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..cut]).unwrap();
        let error = read_parquet(&path).unwrap_err();
        assert!(matches!(error, IngestError::Parquet { .. }) && error.to_string().contains("a.parquet"), "{error}");
    }
}
