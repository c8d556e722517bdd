//! The trace of a run as CSV: one row a sample, what was measured and what the monitor said.

use std::fmt::Write as _;
use std::marker::PhantomData;
use std::path::PathBuf;

use crate::names::ChannelNames;
use crate::output::{OutputDir, OutputError, PendingFile};

mod guard;
mod paper;

/// Writes a trace, row by row, in constant memory.
#[derive(Debug)]
pub struct TraceWriter<S> {
    csv: csv::Writer<PendingFile>,
    cell: String,
    says: PhantomData<fn(&S)>,
}

/// What a monitor says of a sample, as cells behind those of the sample itself.
pub trait Traced {
    /// Names of the cells.
    fn columns() -> Vec<String>;

    /// Writes the cells, as many as there are names.
    ///
    /// # Errors
    /// What the writer has.
    fn write_cells(&self, trace: &mut TraceWriter<Self>) -> csv::Result<()>
    where
        Self: Sized;
}

/// One row of a trace.
#[derive(Clone, Copy, Debug)]
pub struct TraceRow<'a, S> {
    /// Index of the sample.
    pub row: u64,
    /// Seconds since the beginning.
    pub t_s: f64,
    /// Set point, when there is one.
    pub set_point: Option<f64>,
    /// The three channels.
    pub x: [f64; 3],
    /// What the monitor said.
    pub said: &'a S,
}

impl<S: Traced> TraceWriter<S> {
    /// Begins a trace and writes its header.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written.
    pub fn create(out: &OutputDir, name: &str, channels: &ChannelNames) -> Result<Self, OutputError> {
        let csv = csv::Writer::from_writer(out.create(name)?);
        let mut trace = TraceWriter { csv, cell: String::new(), says: PhantomData };
        let fixed = ["row", "t_s", "set_point"].map(str::to_owned).into_iter();
        let header = fixed.chain(channels.0.iter().cloned()).chain(S::columns());
        let written = trace.csv.write_record(header);
        trace.checked(written)?;
        Ok(trace)
    }

    /// Writes one sample.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written.
    pub fn write(&mut self, row: TraceRow<S>) -> Result<(), OutputError> {
        let written = self.write_cells(row);
        self.checked(written)
    }

    fn write_cells(&mut self, TraceRow { row, t_s, set_point, x, said }: TraceRow<S>) -> csv::Result<()> {
        self.field(format_args!("{row}"))?;
        self.field(format_args!("{t_s:.6}"))?;
        // Values as f32: that is what the monitor was given.
        self.number(set_point.map(|set_point| set_point as f32))?;
        for value in x {
            self.number(Some(value as f32))?;
        }
        said.write_cells(self)?;
        self.csv.write_record(None::<&[u8]>)
    }

    /// Writes a text.
    fn text(&mut self, text: &str) -> csv::Result<()> {
        self.csv.write_field(text)
    }

    /// Writes 1 or 0.
    fn flag(&mut self, holds: bool) -> csv::Result<()> {
        self.csv.write_field(if holds { "1" } else { "0" })
    }

    /// Writes a number, or leaves its cell empty.
    fn number(&mut self, number: Option<f32>) -> csv::Result<()> {
        match number {
            Some(number) => self.field(format_args!("{number}")),
            None => self.csv.write_field(""),
        }
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
