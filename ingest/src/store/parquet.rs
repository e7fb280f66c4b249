//! Parquet files of numeric columns. The only module that sees polars.

use std::fs::File;
use std::ops::Range;
use std::path::Path;

use polars::prelude::{
    Column, DataFrame, DataType, Field, Float64Chunked, IntoColumn, NewChunkedArray, ParquetCompression, ParquetReader,
    ParquetWriter, Schema, SerReader,
};
use polars_io::parquet::write::KeyValueMetadata;

use crate::IngestError;
use crate::recording::Cells;

/// A column of a stored table.
#[derive(Debug, Clone, PartialEq)]
pub enum Series {
    /// Words, such as ids.
    Text(Vec<String>),
    /// Numbers; a missing one is `None`.
    Number(Vec<Option<f64>>),
}

impl Series {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Text(cells) => cells.len(),
            Self::Number(cells) => cells.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Named columns of equal length.
pub type Columns = Vec<(String, Series)>;

/// Writes columns as Parquet, zstd, one row group per 262,144 rows: the same bytes for the same columns.
///
/// # Errors
/// [`IngestError::Write`] if the file cannot be made, [`IngestError::Parquet`] if polars refuses, as for unequal lengths.
pub fn write_parquet(path: &Path, columns: &Columns) -> Result<(), IngestError> {
    let parquet = |message: String| IngestError::Parquet { path: path.to_owned(), message };
    let height = columns.first().map_or(0, |(_, series)| series.len());
    let columns = columns
        .iter()
        .map(|(name, series)| match series {
            Series::Text(cells) => Column::new(name.as_str().into(), cells),
            Series::Number(cells) => Column::new(name.as_str().into(), cells),
        })
        .collect();
    let mut frame = DataFrame::new(height, columns).map_err(|e| parquet(e.to_string()))?;

    let file = File::create(path).map_err(|source| IngestError::write(path, source))?;
    writer(&file).finish(&mut frame).map_err(|e| parquet(e.to_string()))?;
    file.sync_all().map_err(|source| IngestError::write(path, source))
}

/// Rows of a row group: what is in memory twice while a table is written.
const GROUP_ROWS: usize = 262_144;

/// Settings that give the same bytes on every machine.
fn writer(file: &File) -> ParquetWriter<&File> {
    ParquetWriter::new(file)
        .with_compression(ParquetCompression::Zstd(None))
        .with_row_group_size(Some(GROUP_ROWS))
        .set_parallel(false)
}

/// Writes numeric columns of equal length as Parquet, zstd, a row group at a time: NaN as null, which programs leave out of means. The
/// same bytes for the same columns.
///
/// # Errors
/// As [`write_parquet`].
pub fn write_table(path: &Path, columns: &[(String, &[f64])]) -> Result<(), IngestError> {
    let columns: Vec<_> = columns.iter().map(|(name, values)| (name.as_str(), Values::Numbers(values))).collect();
    write_groups(path, &columns, &[])
}

/// The same of columns of numbers and text, with words about the table for whoever opens it: key-value metadata of the file.
///
/// # Errors
/// As [`write_parquet`].
pub fn write_cells(path: &Path, columns: &[(&str, &Cells)], metadata: &[(String, String)]) -> Result<(), IngestError> {
    let columns: Vec<_> = columns.iter().map(|(name, cells)| (*name, Values::of(cells))).collect();
    write_groups(path, &columns, metadata)
}

/// The values of a column.
#[derive(Clone, Copy)]
enum Values<'a> {
    Numbers(&'a [f64]),
    Words(&'a [String]),
}

impl<'a> Values<'a> {
    fn of(cells: &'a Cells) -> Self {
        match cells {
            Cells::Numbers(values) => Self::Numbers(values),
            Cells::Text(words) => Self::Words(words),
            Cells::NotKept => Self::Numbers(&[]),
        }
    }

    fn len(self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Words(words) => words.len(),
        }
    }

    fn dtype(self) -> DataType {
        match self {
            Self::Numbers(_) => DataType::Float64,
            Self::Words(_) => DataType::String,
        }
    }

    fn column(self, name: &str, rows: Range<usize>) -> Column {
        match self {
            Self::Numbers(values) => column_of(name, &values[rows]),
            Self::Words(words) => Column::new(name.into(), &words[rows]),
        }
    }
}

fn write_groups(path: &Path, columns: &[(&str, Values)], metadata: &[(String, String)]) -> Result<(), IngestError> {
    let parquet = |message: String| IngestError::Parquet { path: path.to_owned(), message };
    let rows = columns.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != rows) {
        return Err(parquet(format!("column `{name}` holds {} of {rows} rows", values.len())));
    }
    let schema: Schema = columns.iter().map(|(name, values)| Field::new((*name).into(), values.dtype())).collect();
    let file = File::create(path).map_err(|source| IngestError::write(path, source))?;
    let words = (!metadata.is_empty()).then(|| KeyValueMetadata::from_static(metadata.to_vec()));
    let writer = writer(&file).with_key_value_metadata(words);
    let mut writer = writer.batched(&schema).map_err(|e| parquet(e.to_string()))?;
    for first in (0..rows).step_by(GROUP_ROWS) {
        let last = rows.min(first + GROUP_ROWS);
        let group = columns.iter().map(|(name, values)| values.column(name, first..last)).collect();
        let frame = DataFrame::new(last - first, group).map_err(|e| parquet(e.to_string()))?;
        writer.write_batch(&frame).map_err(|e| parquet(e.to_string()))?;
    }
    writer.finish().map_err(|e| parquet(e.to_string()))?;
    file.sync_all().map_err(|source| IngestError::write(path, source))
}

fn column_of(name: &str, values: &[f64]) -> Column {
    let name = name.into();
    let numbers = if values.iter().any(|v| v.is_nan()) {
        Float64Chunked::from_iter_options(name, values.iter().map(|v| (!v.is_nan()).then_some(*v)))
    } else {
        Float64Chunked::from_slice(name, values)
    };
    numbers.into_column()
}

/// The key-value metadata of a Parquet file, without what libraries put there for themselves.
///
/// # Errors
/// As [`read_parquet`].
pub fn read_parquet_metadata(path: &Path) -> Result<Vec<(String, String)>, IngestError> {
    let parquet = |message: String| IngestError::Parquet { path: path.to_owned(), message };
    let file = File::open(path).map_err(|source| IngestError::read(path, source))?;
    let mut reader = ParquetReader::new(file);
    let metadata = reader.get_metadata().map_err(|e| parquet(e.to_string()))?;
    let words = metadata.key_value_metadata().iter().flatten();
    let own = words.filter(|word| !word.key.starts_with("ARROW:"));
    Ok(own.map(|word| (word.key.clone(), word.value.clone().unwrap_or_default())).collect())
}

/// Reads the columns of a Parquet file back.
///
/// # Errors
/// [`IngestError::Read`] if there is no such file, [`IngestError::Parquet`] if it is damaged or holds a column that is neither
/// text nor `f64`.
pub fn read_parquet(path: &Path) -> Result<Columns, IngestError> {
    let parquet = |message: String| IngestError::Parquet { path: path.to_owned(), message };
    let file = File::open(path).map_err(|source| IngestError::read(path, source))?;
    let frame = ParquetReader::new(file).finish().map_err(|e| parquet(e.to_string()))?;
    frame
        .columns()
        .iter()
        .map(|column| {
            let series = match column.dtype() {
                DataType::String => {
                    let cells = column.str().map_err(|e| parquet(e.to_string()))?;
                    Series::Text(cells.iter().map(|cell| cell.unwrap_or_default().to_owned()).collect())
                }
                DataType::Float64 => {
                    let cells = column.f64().map_err(|e| parquet(e.to_string()))?;
                    Series::Number(cells.iter().collect())
                }
                other => return Err(parquet(format!("column `{}` has the unexpected type {other}", column.name()))),
            };
            Ok((column.name().to_string(), series))
        })
        .collect()
}
