//! Names of columns and files, from ids and topics that people choose.

use std::collections::BTreeSet;
use std::path::Path;

/// The column of a table that holds its stamps.
pub const TIME: &str = "time_s";

/// A channel's column: its id with the unit behind it, as names of numbers end in their unit; without signs that query languages
/// would take for operators.
///
/// ```
/// use pneuval_ingest::store::column_name;
/// assert_eq!(column_name("tip-force", "N"), "tip_force_N");
/// assert_eq!(column_name("ratio", "1"), "ratio");
/// assert_eq!(column_name("ratio", "%"), "ratio_percent");
/// ```
pub fn column_name(id: &str, unit: &str) -> String {
    let word = |text: &str| -> String {
        let signs = text.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect::<String>();
        signs.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
    };
    match unit {
        "1" | "" => word(id),
        "%" => format!("{}_percent", word(id)),
        unit => format!("{}_{}", word(id), word(unit)),
    }
}

/// A name that is not taken yet, and now is: two ids may differ in signs only.
pub fn unique_name(base: &str, taken: &mut BTreeSet<String>) -> String {
    let (mut name, mut copy) = (base.to_owned(), 1);
    while !taken.insert(name.clone()) {
        copy += 1;
        name = format!("{base}_{copy}");
    }
    name
}

/// A file name from a run's id and what tells its tables apart (a device's id, a topic), which people choose: letters, digits and few
/// signs, every name once.
pub fn file_name(run: &str, parts: &[&str], extension: &str, names: &mut BTreeSet<String>) -> String {
    const LETTERS_MAX: usize = 100;
    let word = |text: &str| -> String {
        let signs = text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' });
        signs.collect::<String>().trim_matches('-').chars().take(LETTERS_MAX).collect()
    };
    // A run without an id of its own is called as its file is.
    let stem = Path::new(run).file_stem().map_or_else(|| run.to_owned(), |stem| stem.to_string_lossy().into_owned());
    let words = std::iter::once(stem.as_str()).chain(parts.iter().copied()).map(word);
    let base = words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join(".");
    let base = if base.is_empty() { "run".to_owned() } else { base };
    let (mut name, mut copy) = (format!("{base}.{extension}"), 1);
    // Names that differ in case only are one file on some systems.
    while names.iter().any(|taken| taken.eq_ignore_ascii_case(&name)) {
        copy += 1;
        name = format!("{base}-{copy}.{extension}");
    }
    names.insert(name.clone());
    name
}
