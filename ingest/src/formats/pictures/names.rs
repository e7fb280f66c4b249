//! Numbers in the names of pictures: `p{pressure:kPa}_{n}.png` reads `p12.5_3.png`.
//!
//! A field is a name in braces, with a unit behind a colon where it has one. It takes a number: digits with a sign and a decimal point or comma, as
//! many as stand there. `*` stands for any text, what is beyond the fields has to be the same.

use std::fmt;

use crate::units::Unit;

/// How files are named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    text: String,
    parts: Vec<Part>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Text(String),
    Any,
    Field(Field),
}

/// A number in a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// The name of its column.
    pub name: String,
    /// The symbol of its unit.
    pub unit: Option<String>,
}

/// Why a pattern is none, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadPattern(pub String);

impl fmt::Display for BadPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Pattern {
    /// A pattern as a user writes it.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, BadPattern> {
        let bad = |why: &str| Err(BadPattern(why.to_owned()));
        let mut parts: Vec<Part> = Vec::new();
        let mut rest = text;
        while let Some(first) = rest.chars().next() {
            let open_ended = matches!(parts.last(), Some(Part::Any | Part::Field(_)));
            match first {
                '{' => {
                    let Some((inside, behind)) = rest[1..].split_once('}') else { return bad("`{` without `}`") };
                    let (name, unit) = inside.split_once(':').map_or((inside, None), |(name, unit)| (name, Some(unit)));
                    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
                    if name.is_empty() || !name.chars().all(is_name) {
                        return bad(
                            "a field is a name of letters, digits, `_` and `-`, with a unit behind a colon: `{pressure:kPa}`",
                        );
                    }
                    if let Some(unit) = unit.filter(|unit| Unit::parse(unit).is_none()) {
                        return Err(BadPattern(format!("`{unit}` is no unit")));
                    }
                    if parts.iter().any(|part| matches!(part, Part::Field(field) if field.name == name)) {
                        return Err(BadPattern(format!("`{name}` twice")));
                    }
                    if open_ended {
                        return bad("no text between two fields: nobody knows where one ends");
                    }
                    parts.push(Part::Field(Field { name: name.to_owned(), unit: unit.map(str::to_owned) }));
                    rest = behind;
                }
                '}' => return bad("`}` without `{`"),
                '*' => {
                    if open_ended {
                        return bad("no text between a field and `*`: nobody knows where one ends");
                    }
                    parts.push(Part::Any);
                    rest = &rest[1..];
                }
                _ => {
                    let end = rest.find(['{', '}', '*']).unwrap_or(rest.len());
                    parts.push(Part::Text(rest[..end].to_owned()));
                    rest = &rest[end..];
                }
            }
        }
        if !parts.iter().any(|part| matches!(part, Part::Field(_))) {
            return bad("no field in braces: `p{pressure:kPa}.png`");
        }
        Ok(Self { text: text.to_owned(), parts })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its fields in order.
    pub fn fields(&self) -> impl Iterator<Item = &Field> {
        self.parts.iter().filter_map(|part| if let Part::Field(field) = part { Some(field) } else { None })
    }

    /// The numbers of a name, in the order of the fields; `None` if it is named otherwise.
    pub fn read(&self, name: &str) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        read(&self.parts, name, &mut numbers).then_some(numbers)
    }
}

fn read(parts: &[Part], rest: &str, numbers: &mut Vec<f64>) -> bool {
    let Some((first, behind)) = parts.split_first() else { return rest.is_empty() };
    match first {
        Part::Text(text) => rest.strip_prefix(text.as_str()).is_some_and(|rest| read(behind, rest, numbers)),
        Part::Any => (0..=rest.len()).filter(|i| rest.is_char_boundary(*i)).any(|i| {
            let before = numbers.len();
            let met = read(behind, &rest[i..], numbers);
            if !met {
                numbers.truncate(before);
            }
            met
        }),
        Part::Field(_) => {
            let sign = usize::from(rest.starts_with(['-', '+', '−']));
            let sign = rest.chars().take(sign).map(char::len_utf8).sum::<usize>();
            let digits = |from: usize| rest[from..].bytes().take_while(u8::is_ascii_digit).count();
            let whole = digits(sign);
            if whole == 0 {
                return false;
            }
            // The longest number first, then without what may be the point of an extension.
            let point = sign + whole;
            let part = if rest[point..].starts_with(['.', ',']) { digits(point + 1) } else { 0 };
            let ends = [(part > 0).then_some(point + 1 + part), Some(point)];
            ends.into_iter().flatten().any(|end| {
                let Ok(number) = rest[..end].replace(',', ".").replace('−', "-").parse::<f64>() else { return false };
                let before = numbers.len();
                numbers.push(number);
                let met = number.is_finite() && read(behind, &rest[end..], numbers);
                if !met {
                    numbers.truncate(before);
                }
                met
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_where_the_pattern_says() {
        let pattern = Pattern::parse("p{pressure:kPa}_{n}.png").unwrap();
        assert_eq!(
            pattern.fields().map(|f| (f.name.as_str(), f.unit.as_deref())).collect::<Vec<_>>(),
            [("pressure", Some("kPa")), ("n", None)]
        );
        assert_eq!(pattern.read("p12.5_3.png"), Some(vec![12.5, 3.0]));
        assert_eq!(pattern.read("p-12,5_03.png"), Some(vec![-12.5, 3.0]));
        for other in ["p12.5_3.jpg", "q12_3.png", "p_3.png", "p12_x.png", "p12_3.png.bak", ""] {
            assert_eq!(pattern.read(other), None, "{other}");
        }
        // A number before the point of an extension.
        assert_eq!(Pattern::parse("{t}.5.png").unwrap().read("3.5.png"), Some(vec![3.0]));
        assert_eq!(Pattern::parse("{t}.png").unwrap().read("3.5.png"), Some(vec![3.5]));
        assert_eq!(Pattern::parse("*-{p}kPa*").unwrap().read("run-2-15kPa (1).jpg"), Some(vec![15.0]));
    }

    #[test]
    fn a_pattern_that_cannot_be_read_is_told() {
        for (text, why) in [
            ("photo.png", "no field"),
            ("p{.png", "without `}`"),
            ("p}.png", "without `{`"),
            ("{a}{b}.png", "between two fields"),
            ("{a}*.png", "between a field"),
            ("{p:furlong}.png", "no unit"),
            ("{a}-{a}.png", "twice"),
            ("{}.png", "a name of letters"),
        ] {
            let found = Pattern::parse(text).unwrap_err().to_string();
            assert!(found.contains(why), "{text}: {found}");
        }
    }
}
