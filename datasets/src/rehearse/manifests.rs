//! What a user would have written beside the logs: `session.toml`, and the paper's printed predictions as models of the actuator.

use std::fmt::Write as _;

use pneuval_ingest::formats::Format;
use pneuval_ingest::manifest::{HoldOut, PublishedDataset, PublishedTable};
use pneuval_ingest::units::{Dimension, Unit};

use super::files::{LogFile, STAMPS, column_of};
use super::photographs;
use super::plan::{Channel, Device, Moments, Plan, PlanCamera, ProgrammeKind, Shows, Sitting};

/// What the reader calls a gauge's values, and its stamps.
const GAUGE_COLUMN: &str = "force";
const GAUGE_STAMPS: &str = "time";

/// What `session.toml` says of a run.
pub struct RunFiles {
    /// Its id.
    pub id: String,
    /// A file for each of [`SessionText::devices`].
    pub files: Vec<String>,
}

/// What is written into `session.toml`.
pub struct SessionText<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The sitting.
    pub sitting: &'a Sitting,
    /// Its id.
    pub id: &'a str,
    /// Which specimen.
    pub serial: &'a str,
    /// The sentence that says what this is.
    pub note: &'a str,
    /// The files of the first run, which those of the others are like.
    pub devices: &'a [LogFile],
    /// The runs.
    pub runs: &'a [RunFiles],
    /// Whether all devices have one clock.
    pub has_one_clock: bool,
}

/// A text in quotes.
fn quoted(text: &str) -> String {
    // A string of JSON is one of TOML.
    serde_json::Value::from(text).to_string()
}

fn list(texts: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    format!("[{}]", texts.into_iter().map(|text| quoted(text.as_ref())).collect::<Vec<_>>().join(", "))
}

/// An amount in a unit.
fn amount(si: f64, symbol: &str) -> String {
    let value = Unit::parse(symbol).map_or(si, |unit| unit.from_si(si));
    // What conversions leave behind the ninth digit nobody wrote.
    format!("{{ value = {}, unit = \"{symbol}\" }}", (value * 1e9).round() / 1e9)
}

/// The command that a measured pressure is held against: that of its chamber, logged by the same device.
pub fn follows<'p>(plan: &'p Plan, channel: &Channel) -> Option<&'p Channel> {
    let Shows::Pressure(chamber) = &channel.shows else { return None };
    let is_command =
        |other: &&Channel| other.shows == Shows::Command(chamber.clone()) && other.device == channel.device;
    plan.channels.iter().find(is_command)
}

impl SessionText<'_> {
    /// The text.
    pub fn write(&self) -> String {
        let Self { plan, sitting, id, serial, note, .. } = self;
        let mut out = format!(
            "# {note}\nschema = 1\nid = {}\nactuator = {}\nrig = {}\ntitle = {}\nsynthetic = true\n\
             specimen = {{ serial = {}, cycles_before = {} }}\nnotes = [{}]\n",
            quoted(id),
            quoted(&plan.actuator),
            quoted(&plan.rig),
            quoted(&sitting.title),
            quoted(serial),
            plan.specimen.cycles_before,
            quoted(note),
        );
        if self.has_one_clock && self.devices.iter().map(|file| file.tables.len()).sum::<usize>() > 1 {
            out += "clocks = \"one\"\n";
        }
        self.devices(&mut out);
        self.channels(&mut out);
        self.syncs(&mut out);
        self.runs(&mut out);
        self.responses(&mut out);
        self.comparisons(&mut out);
        out
    }

    /// The camera whose pictures a file is.
    fn camera(&self, file: &LogFile) -> Option<&PlanCamera> {
        self.plan.devices.get(*file.devices.first()?)?.camera.as_ref()
    }

    fn camera_keys(&self, file: &LogFile, camera: &PlanCamera) -> Vec<String> {
        photographs::reader_keys(self.plan, &self.plan.devices[file.devices[0]], camera, &file.tables[0])
    }

    // Writing to a string does not fail.
    fn devices(&self, out: &mut String) {
        for (index, file) in self.devices.iter().enumerate() {
            let format = file.format.id();
            // Where the format has a clock of its own, that is the one.
            let clock = match file.format {
                Format::Csv | Format::Serial => Some(STAMPS),
                Format::Gauge => Some(GAUGE_STAMPS),
                _ => None,
            };
            if index == 0 {
                let _ = write!(out, "\n[reader]\nformat = \"{format}\"\n");
                if let Some(camera) = self.camera(file) {
                    let keys = self.camera_keys(file, camera).join("\n");
                    let _ = write!(out, "\n[reader.camera]\n{keys}\n");
                }
                if let Some(column) = clock {
                    let _ = write!(out, "\n[clock]\ncolumn = \"{column}\"\nunit = \"s\"\n");
                }
            } else if let Some(camera) = self.camera(file) {
                let camera = self.camera_keys(file, camera).join(", ");
                let id = quoted(&file.device);
                let _ = write!(
                    out,
                    "\n[[device]]\nid = {id}\nreader = {{ format = \"{format}\", camera = {{ {camera} }} }}\n"
                );
            } else {
                let _ =
                    write!(out, "\n[[device]]\nid = {}\nreader = {{ format = \"{format}\" }}\n", quoted(&file.device));
                if let Some(column) = clock {
                    let _ = writeln!(out, "clock = {{ column = \"{column}\", unit = \"s\" }}");
                }
            }
        }
    }

    fn channels(&self, out: &mut String) {
        for (index, file) in self.devices.iter().enumerate() {
            for (t, device) in file.devices.iter().enumerate() {
                let device = &self.plan.devices[*device];
                for channel in self.plan.channels.iter().filter(|channel| channel.device == device.id) {
                    let name = column_of(file.format, &channel.shows, &channel.id);
                    // What the sitting does not log has no column.
                    let Some(column) = file.tables[t].column(&name) else { continue };
                    let camera = device.camera.as_ref().filter(|camera| camera.channel == channel.id);
                    let column_name = match camera {
                        Some(camera) => camera.object.measure().to_owned(),
                        None => file.column_name(t, if file.format == Format::Gauge { GAUGE_COLUMN } else { &name }),
                    };
                    let _ = write!(out, "\n[[channel]]\nid = {}\n", quoted(&channel.id));
                    if index > 0 {
                        let _ = writeln!(out, "device = {}", quoted(&file.device));
                    }
                    let _ = writeln!(out, "column = {}", quoted(&column_name));
                    let unit = column.unit.as_deref().or_else(|| channel.unit.map(|unit| unit.symbol));
                    let unit = unit.or_else(|| (file.format == Format::Trakstar).then_some("mm"));
                    let unit = camera.map(|camera| camera.object.symbol()).or(unit).unwrap_or("1");
                    let _ = writeln!(out, "unit = {}", quoted(unit));
                    if let Some(instrument) = &channel.instrument {
                        let _ = writeln!(out, "instrument = {}", quoted(instrument));
                    }
                    match &channel.shows {
                        Shows::Command(_) => *out += "reference = \"gauge\"\ncommanded = true\n",
                        Shows::Pressure(_) => {
                            *out += "reference = \"gauge\"\n";
                            self.follows(out, channel);
                        }
                        _ if Unit::parse(unit).is_some_and(|unit| unit.dimension == Dimension::Pressure) => {
                            *out += "reference = \"gauge\"\n";
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// The trigger line, where several devices have clocks of their own and log it.
    fn syncs(&self, out: &mut String) {
        let is_logged = |channel: &&Channel| {
            let tables =
                self.devices.iter().flat_map(|file| file.devices.iter().zip(&file.tables).map(move |at| (file, at)));
            tables.into_iter().any(|(file, (device, table))| {
                self.plan.devices[*device].id == channel.device
                    && table.column(&column_of(file.format, &channel.shows, &channel.id)).is_some()
            })
        };
        let triggers = self.plan.channels.iter().filter(|channel| channel.shows == Shows::Trigger).filter(is_logged);
        let mut channels: Vec<&Channel> = Vec::new();
        for channel in triggers {
            if channels.iter().all(|known| known.device != channel.device) {
                channels.push(channel);
            }
        }
        if !self.has_one_clock && channels.len() > 1 {
            let ids = list(channels.iter().map(|channel| &channel.id));
            let _ = write!(out, "\n[[sync]]\nchannels = {ids}\nevent = \"edges\"\n");
        }
    }

    /// A measured pressure is held against its command.
    fn follows(&self, out: &mut String, channel: &Channel) {
        if let Some(command) = follows(self.plan, channel) {
            let programme = &self.sitting.programme;
            let within = amount(2.0 * programme.tolerance_pa, "kPa");
            let after = amount(0.5 * programme.hold_s.min(programme.rest_s), "s");
            let id = quoted(&command.id);
            let _ = writeln!(out, "follows = {{ channel = {id}, within = {within}, after = {after} }}");
        }
    }

    fn runs(&self, out: &mut String) {
        for run in self.runs {
            let _ = write!(out, "\n[[run]]\nid = {}\n", quoted(&run.id));
            for (index, (name, file)) in run.files.iter().zip(self.devices).enumerate() {
                match index {
                    0 => _ = writeln!(out, "file = {}", quoted(name)),
                    1 => _ = write!(out, "files = {{ {} = {}", quoted(&file.device), quoted(name)),
                    _ => _ = write!(out, ", {} = {}", quoted(&file.device), quoted(name)),
                }
            }
            if run.files.len() > 1 {
                *out += " }\n";
            }
        }
    }

    fn responses(&self, out: &mut String) {
        let programme = &self.sitting.programme;
        let channel_of = |chamber: &String| {
            let shows = Shows::Pressure(chamber.clone());
            self.plan.channels.iter().find(|channel| channel.shows == shows).map_or("", |channel| &channel.id)
        };
        for response in &self.sitting.responses {
            let quantity = &response.quantity;
            let components = if quantity.components.is_empty() {
                String::new()
            } else {
                format!(", components = {}", list(&quantity.components))
            };
            let pressures: Vec<String> = response
                .chambers
                .iter()
                .map(|id| format!("{{ channel = {}, chamber = {} }}", quoted(channel_of(id)), quoted(id)))
                .collect();
            let measured = match &response.measured[..] {
                [only] => quoted(only),
                several => list(several),
            };
            let _ = write!(
                out,
                "\n[[response]]\nquantity = {{ id = {}, title = {}, unit = {}{components} }}\npressure = [{}]\n\
                 measured = {{ channel = {measured}, method = {} }}\n",
                quoted(&quantity.id),
                quoted(&quantity.title),
                quoted(quantity.unit.symbol),
                pressures.join(", "),
                quoted(&response.method),
            );
            let settings = response.conditions.iter().map(|setting| {
                let [channel, id, title] = [&setting.channel, &setting.id, &setting.title].map(|text| quoted(text));
                format!("{{ channel = {channel}, id = {id}, title = {title} }}")
            });
            let settings: Vec<String> = settings.collect();
            if !settings.is_empty() {
                let _ = writeln!(out, "condition = [{}]", settings.join(", "));
            }
            // Of pictures of states, each is a point.
            let is_stations = |device: &Device| {
                let camera = device.camera.as_ref();
                let pressure = || self.plan.channels.iter().filter(|c| c.device == device.id);
                camera.is_some_and(|camera| camera.moments == Moments::Stations)
                    && pressure().any(|channel| matches!(channel.shows, Shows::Pressure(_)))
            };
            let kind = if self.plan.devices.iter().any(is_stations) { ProgrammeKind::Ramp } else { programme.kind };
            match kind {
                ProgrammeKind::Steps | ProgrammeKind::Cycles => {
                    // The regulator needs a while, and the window lies at the end.
                    let hold_s = 0.5 * (programme.hold_s + programme.window_s);
                    let _ = writeln!(
                        out,
                        "points = {{ from = \"plateaus\", tolerance = {}, hold = {}, window = {} }}",
                        amount(programme.tolerance_pa, "kPa"),
                        amount(hold_s, "s"),
                        amount(programme.window_s, "s"),
                    );
                }
                ProgrammeKind::Ramp | ProgrammeKind::Sine => {
                    let _ = writeln!(
                        out,
                        "points = {{ from = \"samples\", same_within = {} }}",
                        amount(programme.tolerance_pa, "kPa")
                    );
                }
            }
        }
    }

    fn comparisons(&self, out: &mut String) {
        for comparison in &self.sitting.comparisons {
            let (quantity, form) = (quoted(&comparison.quantity), quoted(&comparison.form));
            let _ = write!(out, "\n[[comparison]]\nquantity = {quantity}\nform = {form}\n");
            let texts = [("model", &comparison.model), ("title", &comparison.title), ("remark", &comparison.remark)];
            for (key, text) in texts.into_iter().filter_map(|(key, text)| Some((key, text.as_ref()?))) {
                let _ = writeln!(out, "{key} = {}", quoted(text));
            }
            if let Some(fit) = &comparison.fit {
                let held = match fit.hold_out {
                    HoldOut::None => "none",
                    HoldOut::OnePressure => "one-pressure",
                    HoldOut::OddPressures => "odd-pressures",
                };
                let _ = writeln!(
                    out,
                    "fit = {{ to = {}, parameters = {}, hold_out = \"{held}\" }}",
                    quoted(&fit.to),
                    list(&fit.parameters)
                );
            }
            if let Some(reason) = &comparison.not_judged {
                let _ = writeln!(out, "judge = false\nreason = {}", quoted(reason));
            }
        }
    }
}

/// A printed prediction as a model of the actuator: the text for `actuator.toml`, the table's name and the table.
pub struct PrintedModel {
    /// `[[model]]`.
    pub text: String,
    /// Name of the table.
    pub file: String,
    /// The table.
    pub table: String,
}

/// The predictions that the paper prints for the quantities of a plan, where they depend on one pressure alone.
///
/// Where print does not say it, a row at zero is added: at rest nothing is deflected.
pub fn printed_models(published: &PublishedDataset, plan: &Plan) -> Vec<PrintedModel> {
    let measured = |table: &&PublishedTable| {
        let of = |response: &super::plan::Response| response.quantity.id == table.quantity.id;
        plan.sittings.iter().flat_map(|sitting| &sitting.responses).any(of)
    };
    let mut models = Vec::new();
    for table in published.tables.iter().filter(measured) {
        let [chamber] = &table.chambers[..] else { continue };
        if !table.conditions.is_empty() || !table.quantity.components.is_empty() {
            continue;
        }
        for column in &table.predicted {
            let rows: Vec<(f64, f64)> = table
                .pressures_gauge_pa
                .iter()
                .zip(&column.cells)
                .filter_map(|(pressures, cell)| Some((*pressures.first()?, cell.as_ref()?.first()?.si)))
                .collect();
            let Some((least, _)) = rows.first() else { continue };
            let unit = table.quantity.unit;
            let kpa = |si: f64| (si / 1e3 * 1e9).round() / 1e9;
            let shown = |si: f64| (unit.from_si(si) * 1e9).round() / 1e9;
            let mut text = format!("# {}, as printed\npressure,{}\nkPa,{}\n", table.place, column.form, unit.symbol);
            if *least > 0.0 {
                text = text.replacen(
                    " as printed",
                    " as printed; the row at zero is added: at rest nothing is deflected",
                    1,
                );
                text += "0,0\n";
            }
            for (pressure, value) in &rows {
                let _ = writeln!(text, "{},{}", kpa(*pressure), shown(*value));
            }
            let file = format!("{}-{}.csv", table.quantity.id, column.form);
            models.push(PrintedModel {
                text: format!(
                    "\n[[model]]\nkind = \"imported\"\nform = {}\ntitle = {}\nquantity = {{ id = {}, title = {}, unit = {} }}\n\
                     source = {}\nfile = {}\n\
                     pressure = {{ column = \"pressure\", chamber = {}, reference = \"gauge\" }}\npredicted = {}\n",
                    quoted(&column.form),
                    quoted(&column.title),
                    quoted(&table.quantity.id),
                    quoted(&table.quantity.title),
                    quoted(unit.symbol),
                    quoted(&format!("{}: {}", published.paper.title, table.place)),
                    quoted(&file),
                    quoted(chamber),
                    quoted(&column.form),
                ),
                file,
                table: text,
            });
        }
    }
    models
}
