//! `pneuval export`: measured and predicted values as files for other programs.

use pneuval_analysis::bounds::Bounds;
use pneuval_analysis::export::{self, ExportRecord, FileRecord, Format};
use pneuval_analysis::study::{BoundsScope, Input, Study};
use pneuval_ingest::finding::Severity;

use crate::cli::{Export, ExportFormat};
use crate::exit::{Failure, Outcome};
use crate::validate::data_of;
use crate::{output, table};

pub fn run(arguments: &Export) -> Result<Outcome, Failure> {
    let found = pneuval_datasets::find(&arguments.paths)?;
    let inputs: Vec<Input> = found
        .into_iter()
        .map(|found| Input {
            file: found.file,
            data: data_of(found.data),
            actuator: found.actuator,
            actuator_path: found.actuator_file,
            // Nothing is judged here.
            bounds: Bounds::default(),
            bounds_source: None,
            bounds_scope: BoundsScope::Shared,
        })
        .collect();
    let studies = inputs.iter().map(Study::of).collect::<Result<Vec<_>, _>>()?;
    let format = match arguments.format {
        ExportFormat::Mcap => Format::Mcap,
        ExportFormat::Csv => Format::Csv,
        ExportFormat::Parquet => Format::Parquet,
    };
    let record = export::publish(&arguments.out, &studies, format)?;
    let mut outcome = Outcome::Expected;
    for study in &studies {
        for finding in study.findings() {
            output::tell(&format!("{}: {}, {}: {}", finding.severity.id(), study.id, finding.file, finding.text));
            if finding.severity == Severity::Lost {
                outcome = Outcome::Open;
            }
        }
    }
    if record.data.iter().any(|data| data.too_many_excluded) {
        outcome = Outcome::Open;
    }
    if arguments.json {
        output::print_json(&record)?;
    } else {
        output::print(&format!("{}Export: {}\n", text(&record), arguments.out.display()))?;
    }
    Ok(outcome)
}

fn text(record: &ExportRecord) -> String {
    let mut rows = table::plain(&["file", "topic", "rows", "columns"], &[2]);
    for file in record.data.iter().flat_map(|data| &data.files) {
        for row in rows_of(file) {
            rows.add_row(row);
        }
    }
    table::fit(&mut rows);
    let mut out = format!("{}\n\n", rows.trim_fmt());
    for data in &record.data {
        if data.synthetic {
            out.extend([&data.id, ": ", export::SYNTHETIC, "\n"]);
        }
        for left in &data.left_out {
            out.extend(["Left out: ", &left.what, ": ", &left.why, "\n"]);
        }
    }
    out
}

/// A row for each table of a file.
fn rows_of(file: &FileRecord) -> impl Iterator<Item = Vec<String>> + '_ {
    file.tables.iter().map(|table| {
        let columns: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        let topic = table.topic.as_deref().unwrap_or("–");
        vec![file.file.clone(), topic.to_owned(), table.rows.to_string(), columns.join(", ")]
    })
}
