//! The orders of columns in which trakSTAR logs occur, told from the first lines.

use super::plain_cells;
use crate::finding::places::as_text;
use crate::formats::csv::{CellKind, Decimal, cell_kind, parse_number, unit_in_name};
use crate::formats::lines::trim;
use crate::formats::stamps::seconds_of;

/// What a cell of a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The number of the sensor that the line is about.
    Sensor,
    Time,
    Position,
    /// Azimuth, elevation, roll: 0, 1, 2.
    Angle(usize),
    Quality,
    /// A number of another kind: a matrix, a quaternion, a button.
    Other,
    /// Text.
    Word,
}

/// A cell of every line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    pub role: Role,
    pub unit: Option<String>,
    /// The sensor it belongs to, as its name has it.
    sensor: String,
}

/// How a log is laid out.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    delimiter: u8,
    pub decimal: Decimal,
    pub fields: Vec<Field>,
    /// The sensors where every line is about one.
    pub sensors: Option<Vec<String>>,
    pub names_line: Option<usize>,
    pub names_raw: Vec<u8>,
    pub data_line: usize,
    /// Whether dates are in UTC: seconds since 1970 are.
    pub is_utc: bool,
    pub reasons: Vec<String>,
}

/// Lines of data that are looked at.
const LOOKED_AT: usize = 200;

/// Sensors that one line each may be about: four units of four.
const SENSORS_MAX: usize = 64;

const DELIMITERS: [(u8, Decimal); 6] = [
    (b',', Decimal::Point),
    (b'\t', Decimal::Point),
    (b';', Decimal::Point),
    (b' ', Decimal::Point),
    (b'\t', Decimal::Comma),
    (b';', Decimal::Comma),
];

impl Layout {
    /// The layout of a log by its first bytes, `None` if it is no trakSTAR log.
    pub fn of(head: &[u8], is_whole: bool) -> Option<Self> {
        let mut lines: Vec<(usize, &[u8])> = numbered(head);
        // The last line of what is looked at may be cut.
        if !is_whole {
            lines.pop();
        }
        lines.retain(|(_, line)| !line.trim_ascii().is_empty());
        lines.truncate(LOOKED_AT);
        DELIMITERS.into_iter().find_map(|(delimiter, decimal)| with_header(&lines, delimiter, decimal)).or_else(|| {
            DELIMITERS.into_iter().find_map(|(delimiter, decimal)| without_header(&lines, delimiter, decimal))
        })
    }

    /// The cells of a line.
    pub fn cells<'b>(&self, line: &'b [u8], out: &mut Vec<&'b [u8]>) {
        plain_cells(line, self.delimiter, out);
    }

    /// Of each quality, the fields it speaks of: those of its sensor.
    pub fn masks(&self) -> Vec<(usize, Vec<usize>)> {
        let of = |quality: &Field| {
            let is_pose = |f: &Field| matches!(f.role, Role::Position | Role::Angle(_) | Role::Other);
            let fields = self.fields.iter().enumerate();
            fields.filter(|(_, f)| is_pose(f) && f.sensor == quality.sensor).map(|(i, _)| i).collect()
        };
        let fields = self.fields.iter().enumerate();
        fields.filter(|(_, f)| f.role == Role::Quality).map(|(i, f)| (i, of(f))).collect()
    }
}

/// The lines of a text with their numbers, CR CR LF being one line end.
fn numbered(head: &[u8]) -> Vec<(usize, &[u8])> {
    let mut out = Vec::new();
    let mut rest = head;
    while !rest.is_empty() {
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        let (line, behind) = rest.split_at(end);
        out.push((out.len() + 1, line));
        rest = [&b"\r\r\n"[..], b"\r\n", b"\n", b"\r"].iter().find_map(|e| behind.strip_prefix(*e)).unwrap_or(behind);
        if rest.is_empty() && !behind.is_empty() {
            // Whole up to here: what is cut off as the last line is nothing.
            out.push((out.len() + 1, &[]));
        }
    }
    out
}

/// Role and sensor of a name: `x1`, `azimuth_2`, `Sensor 3 roll`.
fn role(name: &str) -> (Role, String) {
    let bare = name.split(['(', '[']).next().unwrap_or(name).to_lowercase();
    let words: Vec<&str> = bare.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let digits = |word: &str| !word.is_empty() && word.bytes().all(|b| b.is_ascii_digit());
    let split = |word: &str| {
        let letters = word.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (letters, number) = word.split_at(letters);
        (letters.to_owned(), number.to_owned())
    };
    let known = |word: &str| match word {
        "x" | "y" | "z" | "posx" | "posy" | "posz" => Some(Role::Position),
        "a" | "az" | "azi" | "azimuth" => Some(Role::Angle(0)),
        "e" | "el" | "ele" | "elevation" => Some(Role::Angle(1)),
        "r" | "ro" | "roll" => Some(Role::Angle(2)),
        "t" | "time" | "timestamp" => Some(Role::Time),
        "q" | "quality" | "qual" | "distortion" => Some(Role::Quality),
        "sensor" | "sensorid" | "sensorno" | "port" => Some(Role::Sensor),
        _ => None,
    };
    match words.as_slice() {
        [word] if known(word).is_some() => (known(word).unwrap_or(Role::Other), String::new()),
        [word] => {
            let (letters, number) = split(word);
            match known(&letters) {
                // `q0` to `q3` are a quaternion, `r11` a matrix; `sensor1` alone says nothing.
                Some(Role::Sensor) | None => (Role::Other, number),
                Some(role) => (role, number),
            }
        }
        ["sensor", "id" | "number" | "no" | "nr"] => (Role::Sensor, String::new()),
        [first, number] if digits(number) && known(first).is_some() => {
            (known(first).unwrap_or(Role::Other), (*number).to_owned())
        }
        ["sensor" | "s", number, rest] if digits(number) => (known(rest).unwrap_or(Role::Other), (*number).to_owned()),
        [first, rest] => {
            let (letters, number) = split(first);
            let is_sensor = matches!(letters.as_str(), "sensor" | "s") && !number.is_empty();
            if is_sensor { (known(rest).unwrap_or(Role::Other), number) } else { (Role::Other, String::new()) }
        }
        _ => (Role::Other, String::new()),
    }
}

fn with_header(lines: &[(usize, &[u8])], delimiter: u8, decimal: Decimal) -> Option<Layout> {
    let mut parts = Vec::new();
    // A header stands near the top.
    for (index, (number, line)) in lines.iter().enumerate().take(40) {
        let line = trim(line);
        let bare = line.strip_prefix(b"#").or(line.strip_prefix(b"%")).unwrap_or(line);
        plain_cells(bare, delimiter, &mut parts);
        if parts.len() < 7 || parts.iter().any(|cell| parse_number(cell, decimal).is_some()) {
            continue;
        }
        let mut fields: Vec<Field> = parts
            .iter()
            .map(|cell| {
                let name = as_text(cell);
                let (role, sensor) = role(&name);
                Field { unit: unit_in_name(&name).map(str::to_owned), name, role, sensor }
            })
            .collect();
        settle_quaternions(&mut fields);
        let has_pose = fields.iter().any(|field| {
            let of = |role: Role| fields.iter().filter(|f| f.sensor == field.sensor && f.role == role).count();
            let angles = (0..3).filter(|angle| of(Role::Angle(*angle)) == 1).count();
            of(Role::Position) == 3 && angles == 3
        });
        if !has_pose {
            continue;
        }
        let data: Vec<Vec<&[u8]>> = data_cells(lines.get(index + 1..)?, delimiter);
        let (first, _) = *lines.get(index + 1)?;
        if !data.iter().any(|cells| cells.len() == fields.len()) {
            return None;
        }
        // Columns of text are told from the first lines.
        for (column, field) in fields.iter_mut().enumerate() {
            let texts = data.iter().filter_map(|cells| cells.get(column)).filter(|cell| {
                cell_kind(cell, decimal) == CellKind::Text
                    && !(field.role == Role::Time && is_clock(cell))
                    && field.role != Role::Sensor
            });
            if texts.count() * 2 > data.len() {
                field.role = Role::Word;
            }
        }
        let mut reasons = vec![format!("line {number} names position and angles of a trakSTAR")];
        let sensors = match fields.iter().position(|f| f.role == Role::Sensor) {
            Some(column) => Some(ids(&data, column)?),
            None => None,
        };
        reasons.push(order(sensors.as_deref()));
        let is_utc = is_utc(&fields, &data, decimal);
        return Some(Layout {
            delimiter,
            decimal,
            fields,
            sensors,
            names_line: Some(*number),
            names_raw: line.to_vec(),
            data_line: first,
            is_utc,
            reasons,
        });
    }
    None
}

/// `q0 q1 q2 q3` are a quaternion; `q1` beside `x1` is the quality of sensor 1.
fn settle_quaternions(fields: &mut [Field]) {
    let is_q = |f: &Field, number: &str| {
        f.role == Role::Quality && f.sensor == number && f.name.to_lowercase().starts_with('q') && f.name.len() <= 3
    };
    let is_quaternion = fields.iter().any(|f| is_q(f, "0"))
        && fields.iter().any(|f| is_q(f, "3"))
        && !fields.iter().any(|f| f.role == Role::Position && f.sensor == "0");
    for field in fields.iter_mut() {
        let is_short = field.name.len() <= 3 && !field.sensor.is_empty();
        if is_quaternion && is_short && field.role == Role::Quality {
            field.role = Role::Other;
            field.sensor = String::new();
        }
    }
    // `r11` or `a12` beside `x` is an element of a matrix.
    let sensors: Vec<String> = fields.iter().filter(|f| f.role == Role::Position).map(|f| f.sensor.clone()).collect();
    for field in fields.iter_mut() {
        if matches!(field.role, Role::Angle(_)) && !sensors.contains(&field.sensor) {
            field.role = Role::Other;
            field.sensor = String::new();
        }
    }
}

fn order(sensors: Option<&[String]>) -> String {
    match sensors {
        Some(sensors) => format!("every line is about one sensor: {}", sensors.join(", ")),
        None => "every line is about all sensors".to_owned(),
    }
}

fn data_cells<'b>(lines: &[(usize, &'b [u8])], delimiter: u8) -> Vec<Vec<&'b [u8]>> {
    let of = |line: &'b [u8]| {
        let mut parts = Vec::new();
        plain_cells(line, delimiter, &mut parts);
        parts
    };
    lines.iter().map(|(_, line)| of(line)).collect()
}

/// The sensors that lines are about, in order of their numbers.
fn ids(data: &[Vec<&[u8]>], column: usize) -> Option<Vec<String>> {
    let mut ids: Vec<String> = Vec::new();
    for cell in data.iter().filter_map(|cells| cells.get(column)) {
        let id = as_text(cell);
        let is_id = !id.is_empty() && id.len() <= 3 && id.bytes().all(|b| b.is_ascii_digit());
        if is_id && !ids.contains(&id) {
            ids.push(id);
        }
    }
    ids.sort_by_key(|id| (id.len(), id.clone()));
    (!ids.is_empty() && ids.len() <= SENSORS_MAX).then_some(ids)
}

fn is_utc(fields: &[Field], data: &[Vec<&[u8]>], decimal: Decimal) -> bool {
    let Some(time) = fields.iter().position(|f| f.role == Role::Time) else { return false };
    let number = data.iter().find_map(|cells| parse_number(cells.get(time)?, decimal));
    number.is_some() || data.iter().any(|cells| cells.get(time).is_some_and(|cell| cell.ends_with(b"Z")))
}

fn is_clock(cell: &[u8]) -> bool {
    std::str::from_utf8(cell).ok().and_then(seconds_of).is_some()
}

/// The orders that occur where no header is.
#[derive(Clone, Copy)]
enum Order {
    /// x, y, z, a, e, r, time, quality of every sensor.
    Wide,
    /// Sensor, time, x, y, z, a, e, r and perhaps quality.
    TimeFirst { quality: bool },
    /// Sensor, x, y, z, a, e, r, time and perhaps quality.
    TimeLast { quality: bool },
}

impl Order {
    fn roles(self, cells: usize) -> Option<Vec<Role>> {
        const POSE: [Role; 6] =
            [Role::Position, Role::Position, Role::Position, Role::Angle(0), Role::Angle(1), Role::Angle(2)];
        let end = |quality: bool| if quality { &[Role::Quality][..] } else { &[] };
        let roles = match self {
            Self::Wide if cells.is_multiple_of(8) && cells > 0 => {
                [&POSE[..], &[Role::Time, Role::Quality]].concat().repeat(cells / 8)
            }
            Self::Wide => return None,
            Self::TimeFirst { quality } => [&[Role::Sensor, Role::Time], &POSE[..], end(quality)].concat(),
            Self::TimeLast { quality } => [&[Role::Sensor], &POSE[..], &[Role::Time], end(quality)].concat(),
        };
        (roles.len() == cells).then_some(roles)
    }
}

fn without_header(lines: &[(usize, &[u8])], delimiter: u8, decimal: Decimal) -> Option<Layout> {
    let data = data_cells(lines, delimiter);
    let mut lengths: Vec<usize> = data.iter().map(Vec::len).filter(|length| *length >= 8).collect();
    lengths.sort_unstable();
    let usual = *lengths.get(lengths.len() / 2)?;
    let whole: Vec<(usize, &Vec<&[u8]>)> =
        lines.iter().map(|(n, _)| *n).zip(&data).filter(|(_, cells)| cells.len() == usual).collect();
    if whole.len() < 3 || whole.len() * 2 < data.len() {
        return None;
    }
    let orders = [
        Order::Wide,
        Order::TimeFirst { quality: true },
        Order::TimeLast { quality: true },
        Order::TimeFirst { quality: false },
        Order::TimeLast { quality: false },
    ];
    let fits = |roles: &Vec<Role>| whole.iter().filter(|(_, cells)| is_record(cells, roles, decimal)).count();
    let roles = orders
        .iter()
        .filter_map(|order| order.roles(usual))
        .find(|roles| fits(roles) * 10 >= whole.len() * 9 && is_sure(&whole, roles, decimal))?;
    let (data_line, _) = whole.iter().find(|(_, cells)| is_record(cells, &roles, decimal))?;
    let of_lines = roles.first() == Some(&Role::Sensor);
    let mut fields = Vec::with_capacity(roles.len());
    let (mut sensor, mut positions) = (1, 0);
    for role in &roles {
        let suffix = if of_lines { String::new() } else { sensor.to_string() };
        let base = match role {
            Role::Sensor => "sensor",
            Role::Time => "time",
            Role::Position => ["x", "y", "z"][positions % 3],
            Role::Angle(angle) => ["a", "e", "r"].get(*angle).copied().unwrap_or("r"),
            Role::Quality => "quality",
            Role::Other | Role::Word => "column",
        };
        positions += usize::from(*role == Role::Position);
        fields.push(Field { name: format!("{base}{suffix}"), role: *role, unit: None, sensor: suffix });
        sensor += usize::from(*role == Role::Quality);
    }
    let data: Vec<Vec<&[u8]>> = whole.iter().map(|(_, cells)| (*cells).clone()).collect();
    let sensors = if of_lines { Some(ids(&data, 0)?) } else { None };
    let names: Vec<&str> = fields.iter().map(|f| f.name.as_str()).take(9).collect();
    let reasons = vec![
        format!("no header: the cells of a line fit the order {} of a trakSTAR", names.join(", ")),
        order(sensors.as_deref()),
    ];
    let is_utc = is_utc(&fields, &data, decimal);
    let data_line = *data_line;
    Some(Layout {
        delimiter,
        decimal,
        fields,
        sensors,
        names_line: None,
        names_raw: Vec::new(),
        data_line,
        is_utc,
        reasons,
    })
}

/// Whether every cell of a line can be what its place says.
fn is_record(cells: &[&[u8]], roles: &[Role], decimal: Decimal) -> bool {
    cells.iter().zip(roles).all(|(cell, role)| {
        let number = parse_number(cell, decimal);
        let within = |limit: f64| number.is_some_and(|n| n.abs() <= limit);
        let digits = !cell.is_empty() && cell.iter().all(u8::is_ascii_digit);
        match role {
            Role::Sensor => digits && within(99.0),
            Role::Time => number.is_some_and(|n| n >= 0.0) || is_clock(cell),
            Role::Position => number.is_some(),
            Role::Angle(1) => within(90.01),
            Role::Angle(_) => within(180.01),
            Role::Quality => digits && within(65_535.0),
            Role::Other | Role::Word => true,
        }
    })
}

/// Numbers alone may be anything: beside them stands a clock time, or the lines take turns with the sensors while time goes on and the
/// angles are in an instrument's steps.
fn is_sure(whole: &[(usize, &Vec<&[u8]>)], roles: &[Role], decimal: Decimal) -> bool {
    let Some(time) = roles.iter().position(|role| *role == Role::Time) else { return false };
    if whole
        .iter()
        .all(|(_, cells)| cells.get(time).is_some_and(|cell| is_clock(cell) && parse_number(cell, decimal).is_none()))
    {
        return true;
    }
    if roles.first() != Some(&Role::Sensor) {
        return false;
    }
    let turn: Vec<&[u8]> = whole.iter().filter_map(|(_, cells)| cells.first().copied()).collect();
    let first = turn.first().copied().unwrap_or_default();
    let length = turn.iter().skip(1).position(|id| *id == first).map_or(turn.len(), |at| at + 1);
    // A pose is printed with decimals; counts are not.
    let has_decimals = whole.iter().all(|(_, cells)| {
        let poses = cells.iter().zip(roles).filter(|(_, role)| matches!(role, Role::Position | Role::Angle(_)));
        poses.into_iter().all(|(cell, _)| cell.iter().any(|b| matches!(b, b'.' | b',')))
    });
    let takes_turns =
        has_decimals && length > 1 && turn.len() >= 2 * length && turn.chunks(length).all(|c| turn.starts_with(c));
    let times: Vec<f64> = whole.iter().filter_map(|(_, cells)| parse_number(cells.get(time)?, decimal)).collect();
    let mut grid = super::AngleGrid::default();
    for (_, cells) in whole {
        for (cell, _) in cells.iter().zip(roles).filter(|(_, role)| matches!(role, Role::Angle(_))) {
            grid.add(cell, decimal);
        }
    }
    times.is_sorted() && times.first() < times.last() && (takes_turns || grid.step_deg().is_some())
}
