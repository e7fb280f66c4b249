//! Which pressures and conditions a sitting visits, and in which runs.

use pneuval_ingest::IngestError;

use super::plan::{Response, Setting, Sitting, Truth};
use super::programme::State;
use super::truth::{Sources, same};

/// States that are visited in one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// What tells its runs from others: nothing where there is one group.
    pub name: String,
    /// States, in order.
    pub states: Vec<State>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Visit {
    /// Groups of states.
    pub groups: Vec<Group>,
    /// Sets of values of the settings, in the order of `setting_ids`.
    pub settings: Vec<Vec<f64>>,
    /// Ids of the settings of all responses.
    pub setting_ids: Vec<String>,
    /// Levels in all.
    pub levels: usize,
}

/// What a sitting visits: its levels at every value of its settings, or the rows of the first response's printed table.
///
/// # Errors
/// [`IngestError::Malformed`] if there are neither levels nor a table.
pub fn visit(sitting: &Sitting, sources: &Sources) -> Result<Visit, IngestError> {
    let settings: Vec<&Setting> = {
        let mut all: Vec<&Setting> = Vec::new();
        for setting in sitting.responses.iter().flat_map(|response| &response.conditions) {
            if all.iter().all(|known| known.id != setting.id) {
                all.push(setting);
            }
        }
        all
    };
    let rows = if sitting.programme.levels.is_empty() {
        printed_rows(sitting, &settings, sources)?
    } else {
        let sets = settings.iter().fold(vec![vec![]], |sets: Vec<Vec<f64>>, setting| {
            let with = |set: &Vec<f64>| {
                let values = if setting.values_si.is_empty() { &[0.0][..] } else { &setting.values_si };
                values.iter().map(|value| [set.as_slice(), &[*value]].concat()).collect::<Vec<_>>()
            };
            sets.iter().flat_map(with).collect()
        });
        let levels = &sitting.programme.levels;
        levels.iter().flat_map(|level| sets.iter().map(move |set| (level.clone(), set.clone()))).collect()
    };
    let mut sets: Vec<Vec<f64>> = Vec::new();
    let mut groups: Vec<(Vec<f64>, Group)> = Vec::new();
    let per_run = |set: &[f64]| -> Vec<f64> {
        set.iter().zip(&settings).filter(|(_, setting)| setting.per_run).map(|(value, _)| *value).collect()
    };
    let mut levels = 0;
    for (pressures_pa, set) in rows {
        let index = sets.iter().position(|known| same(known, &set)).unwrap_or_else(|| {
            sets.push(set.clone());
            sets.len() - 1
        });
        let key = per_run(&set);
        let group = groups.iter().position(|(known, _)| same(known, &key)).unwrap_or_else(|| {
            groups.push((key, Group { name: String::new(), states: vec![] }));
            groups.len() - 1
        });
        groups[group].1.states.push(State { pressures_pa, set: index, level: Some(levels) });
        levels += 1;
    }
    let several = groups.len() > 1;
    let named = |(number, (_, mut group)): (usize, (Vec<f64>, Group))| {
        if several {
            group.name = format!("set-{}-run", number + 1);
        }
        group
    };
    let groups = groups.into_iter().enumerate().map(named).collect();
    let setting_ids = settings.iter().map(|setting| setting.id.clone()).collect();
    Ok(Visit { groups, settings: sets, setting_ids, levels })
}

/// Pressures of the chambers, and values of the settings.
type Row = (Vec<f64>, Vec<f64>);

/// The rows of the first response whose truth is printed: pressures of the programme's chambers, and values of its conditions.
fn printed_rows(sitting: &Sitting, settings: &[&Setting], sources: &Sources) -> Result<Vec<Row>, IngestError> {
    let is_printed = |response: &&Response| matches!(response.truth, Truth::Published);
    let Some(response) = sitting.responses.iter().find(is_printed).or(sitting.responses.first()) else {
        return Ok(vec![]);
    };
    let table = sources.table(response)?;
    let mut rows = Vec::new();
    for (row, printed) in table.pressures_gauge_pa.iter().enumerate() {
        // At rest it is in any case.
        if printed.iter().all(|pressure| *pressure <= 0.0) || table.measured[row].is_none() {
            continue;
        }
        let pressure = |chamber: &String| {
            let index = table.chambers.iter().position(|known| known == chamber);
            index.and_then(|index| printed.get(index)).copied().unwrap_or(0.0)
        };
        let pressures = sitting.programme.chambers.iter().map(pressure).collect();
        let own = sources.conditions(response, table, row)?;
        let setting = |setting: &&Setting| {
            let at = response.conditions.iter().position(|known| known.id == setting.id);
            // What only another response is set at stays at its first value.
            at.map_or_else(|| setting.values_si.first().copied().unwrap_or(0.0), |at| own[at])
        };
        rows.push((pressures, settings.iter().map(setting).collect()));
    }
    Ok(rows)
}

/// The sets of conditions as one response sees them.
pub fn sets_of(response: &Response, sets: &[Vec<f64>], ids: &[String]) -> Vec<Vec<f64>> {
    let index = |setting: &Setting| ids.iter().position(|id| *id == setting.id);
    let own: Vec<usize> = response.conditions.iter().filter_map(index).collect();
    sets.iter().map(|set| own.iter().map(|index| set[*index]).collect()).collect()
}
