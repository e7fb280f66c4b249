//! Writing what the readers of this folder read.

use std::fmt::Write as _;

use crate::recording::{Column, Table};

/// A table as a trakSTAR log of all sensors on one line. Columns whose name begins with `time` are written as times of day to 100 ns;
/// holes as `NaN`.
pub fn write_trakstar(table: &Table) -> String {
    let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
    let mut out = names.join(",");
    out.push('\n');
    for row in 0..table.rows {
        for (index, column) in table.columns.iter().enumerate() {
            if index > 0 {
                out.push(',');
            }
            let value = number(column, row);
            // Writing to a string does not fail.
            let _ = if column.name.starts_with("time") && value.is_finite() {
                write!(out, "{}", clock(value))
            } else {
                write!(out, "{value}")
            };
        }
        out.push('\n');
    }
    out
}

fn number(column: &Column, row: usize) -> f64 {
    column.cells.numbers().and_then(|numbers| numbers.get(row).copied()).unwrap_or(f64::NAN)
}

/// Seconds of a day as `00:00:16.2387951`.
fn clock(seconds: f64) -> String {
    #[expect(clippy::cast_possible_truncation)]
    let ticks = (seconds * 1e7).round() as i64;
    let (rest, ticks) = (ticks.div_euclid(10_000_000), ticks.rem_euclid(10_000_000));
    format!(
        "{:02}:{:02}:{:02}.{ticks:07}",
        rest.div_euclid(3600).rem_euclid(24),
        rest.div_euclid(60).rem_euclid(60),
        rest.rem_euclid(60)
    )
}

/// A table as the header of a PLUS sequence file without pixels: columns `Timestamp` and, of each tool, `Tool.x` to `Tool.qw`. A pose
/// with a hole is written as `INVALID`.
pub fn write_plus(table: &Table) -> String {
    let tools: Vec<&str> = table.columns.iter().filter_map(|c| c.name.strip_suffix(".x")).collect();
    let mut out = String::from("ObjectType = Image\nNDims = 3\nBinaryData = True\nCustomFrameFieldNames =");
    for tool in &tools {
        let _ = write!(out, " {tool}Transform {tool}TransformStatus");
    }
    out.push_str(" Timestamp\n");
    for row in 0..table.rows {
        let frame = format!("Seq_Frame{row:04}_");
        for tool in &tools {
            let part =
                |part: &str| table.column(&format!("{tool}.{part}")).map_or(f64::NAN, |column| number(column, row));
            let pose = ["x", "y", "z", "qx", "qy", "qz", "qw"].map(part);
            let is_ok = pose.iter().all(|v| v.is_finite());
            let [px, py, pz, x, y, z, w] = if is_ok { pose } else { [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] };
            let status = if is_ok { "OK" } else { "INVALID" };
            let _ = write!(
                out,
                "{frame}{tool}Transform = {} {} {} {px} {} {} {} {py} {} {} {} {pz} 0 0 0 1 \n\
                 {frame}{tool}TransformStatus = {status} \n",
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y - z * w),
                2.0 * (x * z + y * w),
                2.0 * (x * y + z * w),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z - x * w),
                2.0 * (x * z - y * w),
                2.0 * (y * z + x * w),
                1.0 - 2.0 * (x * x + y * y),
            );
        }
        let stamp = table.column("Timestamp").map_or(f64::NAN, |column| number(column, row));
        let _ = writeln!(out, "{frame}Timestamp = {stamp}");
    }
    let _ = write!(out, "DimSize = 1 1 {}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", table.rows);
    out
}
