//! The points of responses as tables: pressures, conditions, what was measured, and what each form says there.

use pneuval_ingest::manifest::{Abscissa, ResponseSpec};
use pneuval_ingest::units::{Dimension, Unit};

use super::samples::{component_base, component_title};
use super::table::{Head, Origin, Table};
use super::{Compared, Export};
use crate::pairing;
use crate::prediction::Prediction;
use crate::response::Response;
use crate::results::Point;
use crate::study::Data;

/// A form and what becomes of every point in its comparison.
struct Form<'a> {
    id: &'a str,
    title: String,
    note: Option<String>,
    points: Vec<Point>,
}

/// The points of all responses of a session, one under the other, each with its quantity and runs.
pub(super) fn of_session(export: &Export) -> Table {
    let mut all = Table::default();
    for (index, response) in export.study.responses.iter().enumerate() {
        let Some(movement) = &response.movement else {
            all.stack(of_response(export, index, response, forms(export, index, response), None));
            continue;
        };
        // Each form meets a movement at places of its own.
        for compared in export.compared.iter().filter(|compared| compared.response == index) {
            let forms = vec![form(compared)];
            all.stack(of_response(export, index, &compared.points, forms, Some(movement.rule.at)));
        }
    }
    all
}

fn of_response(export: &Export, index: usize, response: &Response, forms: Vec<Form>, at: Option<Abscissa>) -> Table {
    let mut table = Table::default();
    let quantities = vec![response.quantity.id.clone(); response.points.len()];
    table.words(Head::new("quantity", "Quantity", Origin::Label), quantities);
    let runs = response.points.iter().map(|point| point.runs.join(", ")).collect();
    table.words(Head::new("runs", "Runs whose mean it is", Origin::Label), runs);
    let places = response.points.iter().map(|point| point.at.unwrap_or(f64::NAN));
    match at {
        Some(Abscissa::Time) => table.numbers(Head::new("time", "Time", Origin::Time), Unit::SECOND, places),
        Some(Abscissa::ArcLength) => {
            table.numbers(Head::new("arc-share", "Share of the arc length", Origin::Setting), Unit::ONE, places);
        }
        Some(Abscissa::Pressure) | None => {}
    }
    fill(&mut table, export, index, response, forms);
    table
}

/// A printed table.
pub(super) fn of_print(export: &Export, index: usize) -> Table {
    let mut table = Table::default();
    let response = &export.study.responses[index];
    fill(&mut table, export, index, response, forms(export, index, response));
    table
}

fn fill(table: &mut Table, export: &Export, index: usize, response: &Response, forms: Vec<Form>) {
    settings(table, export, index, response);
    measured(table, response);
    for form in forms {
        predicted(table, response, &form);
    }
}

/// Pressures and conditions.
fn settings(table: &mut Table, export: &Export, index: usize, response: &Response) {
    for (i, chamber) in response.chambers.iter().enumerate() {
        let base = format!("pressure-{chamber}");
        let channel = |spec: &pneuval_ingest::manifest::ResponseSpec| Some(spec.pressure.get(i)?.0.clone());
        let head = Head::new(&base, &format!("Gauge pressure, {chamber}"), origin(export, index, channel));
        let values = response.points.iter().map(|point| point.pressures_gauge_pa[i]);
        table.numbers(head, Dimension::Pressure.display_unit(), values);
    }
    for (i, condition) in response.conditions.iter().enumerate() {
        let channel = |spec: &pneuval_ingest::manifest::ResponseSpec| Some(spec.conditions.get(i)?.channel.clone());
        let head = Head::new(&condition.id, &condition.title, origin(export, index, channel));
        table.numbers(head, condition.unit, response.points.iter().map(|point| point.conditions[i].si));
    }
}

/// Where a pressure or condition comes from.
fn origin(export: &Export, index: usize, channel: impl Fn(&ResponseSpec) -> Option<String>) -> Origin {
    let Data::Session(session) = &export.study.input.data else { return Origin::Setting };
    let id = session.manifest.responses.get(index).and_then(channel);
    let of_id = || session.runs.iter().filter_map(|run| run.channels.get(id.as_deref()?));
    let is_derived = session.manifest.derived.iter().any(|derived| Some(&derived.id) == id.as_ref());
    if of_id().any(|channel| channel.commanded) {
        Origin::Commanded
    } else if is_derived {
        Origin::Derived
    } else {
        Origin::Measured
    }
}

fn measured(table: &mut Table, response: &Response) {
    let quantity = &response.quantity;
    let unknown = Prediction::none(response);
    let points = pairing::points(response, &unknown.at);
    for component in 0..quantity.width() {
        let name = quantity.components.get(component);
        let title = component_title(&quantity.title, name);
        let value = |point: &Point| component_of(point.measured.as_ref(), component);
        let base = component_base(&quantity.id, name, "measured");
        table.numbers(Head::new(&base, &title, Origin::Measured), quantity.unit, points.iter().map(value));
        // Nothing known of an interval is a hole, not a width of zero.
        let width = |i: usize| component_of(points[i].measured_half_width.as_ref(), component);
        let base = component_base(&quantity.id, name, "half-width");
        table.numbers(Head::new(&base, &title, Origin::HalfWidth), quantity.unit, (0..points.len()).map(width));
    }
}

fn predicted(table: &mut Table, response: &Response, form: &Form) {
    let quantity = &response.quantity;
    let head = |base: &str, title: &str, origin| {
        let title = format!("{title}: {}", form.title);
        Head { form: Some(form.id.to_owned()), note: form.note.clone(), ..Head::new(base, &title, origin) }
    };
    for component in 0..quantity.width() {
        let name = quantity.components.get(component);
        let base = component_base(&quantity.id, name, &format!("predicted-{}", form.id));
        let head = head(&base, &component_title(&quantity.title, name), Origin::Predicted);
        let value = |point: &Point| component_of(point.predicted.as_ref(), component);
        table.numbers(head, quantity.unit, form.points.iter().map(value));
    }
    let base = component_base(&quantity.id, None, &format!("residual-{}", form.id));
    let residuals = form.points.iter().map(|point| point.residual.unwrap_or(f64::NAN));
    table.numbers(head(&base, &quantity.title, Origin::Residual), quantity.unit, residuals);
    let base = component_base(&quantity.id, None, &format!("status-{}", form.id));
    let status = form.points.iter().map(|point| point.status.id().to_owned()).collect();
    table.words(head(&base, &quantity.title, Origin::Status), status);
}

fn component_of(values: Option<&Vec<f64>>, component: usize) -> f64 {
    values.and_then(|values| values.get(component)).copied().unwrap_or(f64::NAN)
}

/// A comparison.
fn form<'a>(compared: &'a Compared) -> Form<'a> {
    Form {
        id: &compared.spec.form,
        title: compared.title().to_owned(),
        note: compared.note(),
        points: pairing::points(&compared.points, &compared.posed.prediction.at),
    }
}

/// The comparisons of a response, then the printed columns that nothing compares.
fn forms<'a>(export: &'a Export<'a>, index: usize, response: &'a Response) -> Vec<Form<'a>> {
    let of_response = || export.compared.iter().filter(move |compared| compared.response == index);
    let is_compared = |form: &str| of_response().any(|compared| compared.spec.form == form);
    let printed = response.columns.iter().filter(|column| !is_compared(&column.form)).map(|column| Form {
        id: &column.form,
        title: column.title.clone(),
        note: None,
        points: pairing::points(response, &Prediction::published(response, column).at),
    });
    of_response().map(form).chain(printed).collect()
}
