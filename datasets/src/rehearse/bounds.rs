//! The bounds of an actuator, as far as they are about what a plan compares: a bound that meets no comparison is a mistake of its file.

use pneuval_ingest::IngestError;
use pneuval_ingest::document::Document;
use toml::{Table, Value};

use super::plan::Plan;

/// The rows of a bounds file whose models a plan compares, written anew.
///
/// # Errors
/// [`IngestError::Malformed`] if it is no TOML.
pub fn of_plan(file: &str, bytes: &[u8], plan: &Plan) -> Result<String, IngestError> {
    let parsed: Table = Document::new(file, bytes)?.parse()?;
    let mut out = String::from("schema = 1\n");
    let rows = parsed.get("bound").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    for row in rows.iter().filter_map(Value::as_table) {
        let text = |key: &str| row.get(key).and_then(Value::as_str).unwrap_or_default();
        let compared = |form: &str| {
            let mut comparisons = plan.sittings.iter().flat_map(|sitting| &sitting.comparisons);
            comparisons.any(|comparison| comparison.quantity == text("quantity") && comparison.form == form)
        };
        let models: Vec<&str> = match row.get("model") {
            Some(Value::Array(models)) => models.iter().filter_map(Value::as_str).collect(),
            Some(Value::String(model)) => vec![model],
            _ => vec![],
        };
        let models: Vec<Value> = models.into_iter().filter(|form| compared(form)).map(Value::from).collect();
        if models.is_empty() || text("actuator") != plan.actuator {
            continue;
        }
        out += "\n[[bound]]\n";
        for (key, value) in row {
            let value = if key == "model" { &Value::Array(models.clone()) } else { value };
            out.extend([key, " = ", &written(value), "\n"]);
        }
    }
    Ok(out)
}

/// A value on one line.
fn written(value: &Value) -> String {
    match value {
        // A string of JSON is one of TOML.
        Value::String(text) => serde_json::Value::from(text.as_str()).to_string(),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Boolean(is) => is.to_string(),
        Value::Datetime(date) => date.to_string(),
        Value::Array(values) => format!("[{}]", values.iter().map(written).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let pairs = table.iter().map(|(key, value)| format!("{key} = {}", written(value)));
            format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
        }
    }
}
