//! The trace of a run as CSV: one row a sample, what was measured and what the monitor said.

use std::fmt::Write as _;
use std::path::PathBuf;

use monitor_core::sample::ModelId;
use monitor_core::{Phase, Verdict};

use crate::names::{ChannelNames, diagnosis_id, model_key};
use crate::output::{OutputDir, OutputError, PendingFile};

/// Writes a trace, row by row, in constant memory.
#[derive(Debug)]
pub struct TraceWriter {
    csv: csv::Writer<PendingFile>,
    cell: String,
}

/// One row of a trace.
#[derive(Clone, Copy, Debug)]
pub struct TraceRow<'a> {
    /// Index of the sample.
    pub row: u64,
    /// Seconds since the beginning.
    pub t_s: f64,
    /// Set point, when there is one.
    pub set_point: Option<f64>,
    /// The three channels.
    pub x: [f64; 3],
    /// What the monitor said.
    pub verdict: &'a Verdict,
}

impl TraceWriter {
    /// Begins a trace and writes its header. T2 cells are empty where nothing was judged.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written.
    pub fn create(out: &OutputDir, name: &str, channels: &ChannelNames) -> Result<Self, OutputError> {
        let mut trace = TraceWriter { csv: csv::Writer::from_writer(out.create(name)?), cell: String::new() };
        let fixed = ["row", "t_s", "set_point"].map(str::to_owned).into_iter();
        let models = ["t2", "relay"].iter().flat_map(|p| ModelId::ALL.map(|m| format!("{p}_{}", model_key(m))));
        let header = fixed
            .chain(channels.0.iter().cloned())
            .chain(["phase", "rejected"].map(str::to_owned))
            .chain(models)
            .chain(["located".to_owned()]);
        let written = trace.csv.write_record(header);
        trace.checked(written)?;
        Ok(trace)
    }

    /// Writes one sample.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written.
    pub fn write(&mut self, row: TraceRow) -> Result<(), OutputError> {
        let written = self.write_cells(row);
        self.checked(written)
    }

    fn write_cells(&mut self, TraceRow { row, t_s, set_point, x, verdict }: TraceRow) -> csv::Result<()> {
        let phase = match verdict.phase() {
            Phase::Settling(_) => "settling",
            Phase::Learning => "learning",
            Phase::ModelDue => "model due",
            Phase::Monitoring => "monitoring",
        };
        self.field(format_args!("{row}"))?;
        self.field(format_args!("{t_s:.6}"))?;
        // Values as f32: that is what the monitor was given.
        match set_point {
            Some(set_point) => self.field(format_args!("{}", set_point as f32))?,
            None => self.csv.write_field("")?,
        }
        for value in x {
            self.field(format_args!("{}", value as f32))?;
        }
        self.csv.write_field(phase)?;
        self.csv.write_field(if verdict.rejected().is_some() { "1" } else { "0" })?;
        for model in ModelId::ALL {
            match verdict.residuals() {
                Some(residuals) => self.field(format_args!("{}", residuals.get(model)))?,
                None => self.csv.write_field("")?,
            }
        }
        for model in ModelId::ALL {
            self.csv.write_field(if *verdict.relays().get(model) { "1" } else { "0" })?;
        }
        self.csv.write_field(diagnosis_id(verdict.diagnosis()).unwrap_or_default())?;
        self.csv.write_record(None::<&[u8]>)
    }

    /// Writes a number without allocating for each.
    fn field(&mut self, number: std::fmt::Arguments) -> csv::Result<()> {
        self.cell.clear();
        let _ = self.cell.write_fmt(number); // writing to a String cannot fail
        self.csv.write_field(&self.cell)
    }

    fn checked(&self, result: csv::Result<()>) -> Result<(), OutputError> {
        result.map_err(|error| self.csv.get_ref().failed(error.into()))
    }

    /// Moves the trace into its place and returns it.
    ///
    /// # Errors
    /// [`OutputError`] when the system refuses.
    pub fn finish(mut self) -> Result<PathBuf, OutputError> {
        self.csv.flush().map_err(|source| self.csv.get_ref().failed(source))?;
        match self.csv.into_inner() {
            Ok(file) => file.finish(),
            Err(error) => {
                let source = std::io::Error::new(error.error().kind(), error.error().to_string());
                Err(error.into_inner().get_ref().failed(source))
            }
        }
    }
}
