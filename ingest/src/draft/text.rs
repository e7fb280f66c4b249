//! Words of a draft: ids, titles, TOML strings, and the parts that stand in every draft.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::parts::{Part, words};

/// Letters of an id: room is left for what a user adds.
const ID_LETTERS_MAX: usize = 60;

/// The id, or where it is taken, the first free of `-2`, `-3` and so on behind it, cut to fit.
pub(super) fn unique(id: &str, taken: &mut BTreeSet<String>) -> String {
    let (mut free, mut copy) = (id.to_owned(), 1);
    while !taken.insert(free.clone()) {
        copy += 1;
        let ending = format!("-{copy}");
        let room = id.len().min(ID_LETTERS_MAX - ending.len());
        // Ids are ASCII.
        free = format!("{}{ending}", id.get(..room).unwrap_or(id).trim_end_matches('-'));
    }
    free
}

/// A name as a title: its first letter is a capital.
pub(super) fn titled(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Text on one line, fit for a comment.
pub(super) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A TOML string.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// An id from a name: lower-case words joined by `-`; `channel-3` where nothing of it is left.
pub(super) fn slug(name: &str, number: usize) -> String {
    let ascii = |word: &String| word.chars().filter(char::is_ascii_alphanumeric).collect::<String>();
    let words: Vec<String> = words(name).iter().map(ascii).filter(|word| !word.is_empty()).collect();
    let mut id = words.join("-");
    id.truncate(ID_LETTERS_MAX);
    let id = id.trim_matches('-').to_owned();
    match id.as_str() {
        "" | "index" | "measured" | "none" => format!("channel-{number}"),
        _ => id,
    }
}

pub(super) const COMPARISONS: &str = "\
# Without [[comparison]] every model of a response is compared with it: the catalogue's, and those of actuator.toml.
# [[comparison]]
# quantity = \"…\"
# form = \"…\"
";

pub(super) const ACTUATOR: &str = "\
schema = 1
# id = \"…\"  # while absent, this file describes the actuator of the session beside it
# type = \"…\"  # an embedded type, whose models then apply (`pneuval models`)
# title = \"…\"
# summary = \"…\"

# A model as a table, such as an export of a finite-element program: a name row, a unit row, pressures that rise.
# [[model]]
# kind = \"imported\"
# form = \"fea\"
# quantity = { id = \"…\", title = \"…\", unit = \"mm\" }
# file = \"fea.csv\"
# pressure = { column = \"pressure\", chamber = \"chamber\", reference = \"gauge\" }
# predicted = \"displacement\"
# std = \"displacement_std\"
# source = \"which program, which mesh\"

# [geometry]
# length = { value = 100, unit = \"mm\", source = \"measured\" }
";

pub(super) fn rig(pressure: Option<&Part>) -> String {
    let input = pressure.and_then(|part| part.unit).map_or("V", |unit| unit.symbol);
    let hash = if pressure.is_some() { "" } else { "# " };
    format!(
        "schema = 1\nid = \"bench\"\n\n# Instruments: what they log (input), what that means (output), how sure it is.\n\
         {hash}[instrument.pressure]\n{hash}input = {}\n{hash}output = \"kPa\"\n\
         {hash}calibration = {{ kind = \"line\", slope = 1, offset = 0 }}  # FILL IN: output per input, output at zero\n\
         # range = {{ min = 0, max = 100 }}\n# std = 0.1  # standard uncertainty, in kPa\n# certificate = \"calibrated on …\"\n",
        quoted(input)
    )
}

pub(super) fn bounds(actuator: Option<&str>, parts: &[Part]) -> String {
    let quantity = parts.first().map_or("…".to_owned(), |part| part.id.replace('_', "-"));
    format!(
        "schema = 1\n\n# What error is acceptable, and why: from an application need or a claim, never from a computed value.\n\
         # [[bound]]\n# actuator = {}\n# quantity = {}\n# model = \"fea\"\n# metric = \"rmse\"\n\
         # max = {{ value = 1, unit = \"mm\" }}\n# allow_single_repeat = true  # judge one repeat by its instruments' uncertainty\n# reason = \"…\"\n",
        quoted(actuator.unwrap_or("…")),
        quoted(&quantity)
    )
}
