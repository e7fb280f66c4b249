//! What became of the samples of a session on their way to the points of a response.

/// Samples read, lost and used. A sample is one of a table, with its stamp; where the channels of a response come from several tables,
/// those of all of them are counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Census {
    /// Samples of the runs.
    pub samples: usize,
    /// Samples with a hole in one of the channels needed of their table, or without a stamp that counts.
    pub holes: usize,
    /// Samples that lie in a point: of a table beside that of the pressures, those stamped within the window of a plateau.
    pub used: usize,
    /// The same samples and holes table by table, where there are several: a slow one would not be seen beside a fast one.
    pub tables: Vec<TableCensus>,
    /// Plateaus at which nothing was measured.
    pub unmet: Vec<Unmet>,
    /// Runs that have no reading to take their zero from.
    pub untared: Vec<String>,
    /// What still moved while it was averaged.
    pub creeping: Vec<Creep>,
    /// Plateaus that are not read, because a lag leaves open what was measured at them.
    pub unsure: Vec<Unsure>,
}

/// Points of a run at which what is measured still moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Creep {
    /// The run.
    pub run: String,
    /// Its readings, and how many of them move.
    pub readings: usize,
    /// Those that move.
    pub creeping: usize,
    /// The largest move over a window, in SI units.
    pub largest_si: f64,
}

/// Plateaus of a run that are too short for the lag between the clocks or the specimen, of which nobody knows whose it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Unsure {
    /// The run.
    pub run: String,
    /// The device of the table; `None`: the run's `file`.
    pub device: Option<String>,
    /// The table: its device and topic.
    pub table: String,
    /// Plateaus of the run.
    pub plateaus: usize,
    /// Those of them that are not read.
    pub unsure: usize,
    /// How late the motion may be, in s.
    pub late_s: f64,
    /// How far off its stamps may be, either way, in s.
    pub either_s: f64,
    /// Because the motion comes before its pressure, not because a clock is uncertain.
    pub leads: bool,
}

impl Unsure {
    /// In words.
    pub fn text(&self) -> String {
        let Self { run, table, plateaus, unsure, late_s, either_s, leads, .. } = self;
        if *either_s > *late_s {
            let why = if *leads {
                format!("what {table} shows comes before its pressure, and may be off by {either_s:.3} s")
            } else {
                format!("the stamps of {table} are known to ± {either_s:.3} s on the clock of the pressure")
            };
            return format!(
                "run {run}: {why}; {unsure} of {plateaus} plateaus are not read, of whose windows nothing is left when that is taken off both ends"
            );
        }
        format!(
            "run {run}: {table} may be up to {late_s:.3} s late, by its clock or by the specimen; {unsure} of {plateaus} plateaus are not read, \
             whose windows lie in them only if it is one of the two"
        )
    }
}

/// Samples of one table, of all runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableCensus {
    /// Its device and topic.
    pub table: String,
    /// Samples of the runs.
    pub samples: usize,
    /// Samples with a hole, or without a stamp that counts.
    pub holes: usize,
}

/// Plateaus of a run within whose windows no sample of a table is stamped.
#[derive(Debug, Clone, PartialEq)]
pub struct Unmet {
    /// The run.
    pub run: String,
    /// The device of the table; `None`: the run's `file`.
    pub device: Option<String>,
    /// The table: its device and topic.
    pub table: String,
    /// Plateaus of the run.
    pub plateaus: usize,
    /// Those of them without a sample.
    pub unmet: usize,
    /// From the first of their windows to the last, in s.
    pub plateaus_s: (f64, f64),
    /// From the first to the last sample of the table that counts, in s.
    pub table_s: Option<(f64, f64)>,
}

impl Census {
    /// Adds the samples of a run.
    pub(super) fn add(&mut self, more: TableCensus) {
        match self.tables.iter_mut().find(|known| known.table == more.table) {
            Some(known) => {
                known.samples += more.samples;
                known.holes += more.holes;
            }
            None => self.tables.push(more),
        }
    }
}

impl Unmet {
    /// In words.
    pub fn text(&self) -> String {
        let Self { run, table, plateaus, unmet, plateaus_s: (first, last), .. } = self;
        let reach = self.table_s.map_or_else(
            || "it has no sample that counts".to_owned(),
            |(from, to)| format!("its samples reach from {from:.3} s to {to:.3} s"),
        );
        format!(
            "run {run}: no sample of {table} is stamped within the windows of {unmet} of {plateaus} plateaus, which lie from {first:.3} s to \
             {last:.3} s; {reach}. Nothing is measured there"
        )
    }
}
