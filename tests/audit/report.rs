//! What an audit found: tables for people, figures for the budgets, faults, and what it cannot see.

use serde::Serialize;

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// The rows. The first column is text, the others are numbers.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    #[must_use]
    pub fn new(caption: impl Into<String>, header: &[&str]) -> Self {
        let header = header.iter().map(|name| (*name).to_owned()).collect();
        Table { caption: caption.into(), header, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.into());
    }
}

/// Something measured that the budgets file has a limit for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Figure {
    /// Its name, in words with dots between, from the general to the special: `stack.footprint.core_step`.
    pub name: String,
    /// The value.
    pub value: u64,
    /// Its unit: `bytes`, `instructions`, `cycles`, ...
    pub unit: &'static str,
}

impl Figure {
    /// So many bytes.
    #[must_use]
    pub fn bytes(name: impl Into<String>, value: u64) -> Self {
        Figure { name: name.into(), value, unit: "bytes" }
    }
}

/// What one audit found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// What was audited, and of what.
    pub title: String,
    /// Tables for people.
    pub tables: Vec<Table>,
    /// Figures for the budgets.
    pub figures: Vec<Figure>,
    /// What must not be, each a sentence. One is enough to fail.
    pub faults: Vec<String>,
    /// What is worth saying and does not fail.
    pub notes: Vec<String>,
    /// What the audit cannot see.
    pub blind_spots: Vec<&'static str>,
}
