//! Where the README states what was recorded.

use std::cell::Cell;
use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::list::FIGURES;
use super::passage::{self, Stale, Value};
use super::record::Record;

mod benchmarks;
mod missions;
mod studies;

/// A statement of the README.
#[derive(Clone)]
struct Claim {
    /// Its words, as [`passage::stale`] looks for them.
    says: &'static str,
    values: Vec<Value>,
}

fn claim(says: &'static str, values: impl Into<Vec<Value>>) -> Claim {
    Claim { says, values: values.into() }
}

/// A table that the README shows as it is printed.
struct Table {
    begins: &'static str,
    figure: &'static str,
}

/// Statements that stand or fall together: they are compared when all records that they ask for are there.
type Group = fn(&Records) -> Vec<Claim>;

/// All records there are, by the names of their figures.
struct Records {
    found: BTreeMap<&'static str, Record>,
    /// One was asked for that is not there.
    is_wanting: Cell<bool>,
}

impl Records {
    /// Reads them, and says which are wanting.
    fn read() -> (Self, Vec<String>) {
        let (mut records, mut wanting) = (BTreeMap::new(), Vec::new());
        for figure in FIGURES {
            match figure.record() {
                Ok(Some(record)) => drop(records.insert(figure.name, record)),
                Ok(None) => wanting.push(format!("{}: there is no record of it", figure.name)),
                Err(error) => wanting.push(error),
            }
        }
        (Self { found: records, is_wanting: Cell::new(false) }, wanting)
    }

    fn get(&self, name: &str) -> Option<&Record> {
        let found = self.found.get(name);
        self.is_wanting.set(self.is_wanting.get() || found.is_none());
        found
    }

    fn rows(&self, name: &str) -> &[Json] {
        self.get(name).map_or(&[], |record| &record.rows)
    }

    /// The row whose fields are as said: `row=loop fault=F1`.
    fn row(&self, name: &str, fields: &str) -> &Json {
        let is = |row: &Json, key: &str, value: &str| match &row[key] {
            Json::String(text) => text.replace(' ', "_") == value,
            other => value.parse::<Json>().is_ok_and(|value| value == *other),
        };
        let suits =
            |row: &&Json| fields.split(' ').filter_map(|f| f.split_once('=')).all(|(key, value)| is(row, key, value));
        self.rows(name).iter().find(suits).unwrap_or(&Json::Null)
    }

    fn number(&self, name: &str, fields: &str, pointer: &str) -> Option<f64> {
        self.row(name, fields).pointer(pointer).and_then(Json::as_f64)
    }

    fn about(&self, name: &str, fields: &str, pointer: &str) -> Value {
        Value::About(self.number(name, fields, pointer))
    }

    fn command_of(&self, name: &str) -> &str {
        self.get(name).map_or("", |record| &record.command)
    }

    /// The command that the README names for records, one or one of each mode: without what all have in common.
    fn command(&self, names: &[&str]) -> Value {
        let mut commands: Vec<String> = names
            .iter()
            .filter_map(|name| self.get(name))
            .map(|record| record.command.trim_start_matches("study ").to_owned())
            .collect();
        if commands.len() > 1 {
            commands
                .iter_mut()
                .for_each(|c| *c = c.replace("--mode paper", "--mode ...").replace("--mode guard", "--mode ..."));
        }
        commands.dedup();
        Value::Words(commands.join(" and "))
    }
}

/// What the README states otherwise than it was recorded, and which of its statements cannot be compared at all.
#[must_use]
pub fn stale(readme: &str) -> (Vec<Stale>, Vec<String>) {
    let (records, mut wrong) = Records::read();
    let mut stale = Vec::new();
    let groups = [missions::GROUPS, studies::GROUPS, benchmarks::GROUPS].concat();
    let claims = groups.into_iter().flat_map(|group| {
        records.is_wanting.set(false);
        let claims = group(&records);
        if records.is_wanting.get() { Vec::new() } else { claims }
    });
    let compared = claims.map(|claim| passage::stale(readme, claim.says, &claim.values));
    let tables = missions::TABLES.iter().chain(studies::TABLES);
    let tables = tables
        .filter_map(|table| Some(passage::stale_table(readme, table.begins, &records.get(table.figure)?.printed)));
    for result in compared.chain(tables) {
        match result {
            Ok(some) => stale.extend(some),
            Err(error) => wrong.push(format!("README.md {error}")),
        }
    }
    (stale, wrong)
}

/// A stale value for a person: where it stands, what is said and what was recorded.
#[must_use]
pub fn shown(readme: &str, Stale { place, now }: &Stale) -> String {
    let line = 1 + readme[..place.start].matches('\n').count();
    format!("README.md:{line}: says {}, recorded is {now}", &readme[place.clone()])
}

/// A count, as one says it.
fn no_or(count: u64) -> Value {
    Value::Words(if count == 0 { "no".to_owned() } else { count.to_string() })
}

/// How much, where the README gives no number.
fn in_words(count: f64) -> Value {
    let words = match count {
        0.0 => "none",
        0.0..100.0 => "some",
        100.0..1000.0 => "hundreds",
        1000.0.. => "thousands",
        _ => "",
    };
    Value::Words(words.to_owned())
}

/// The share that is nearest to one of a whole number.
fn one_of(share: f64) -> Value {
    let names = ["whole", "half", "third", "quarter", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth"];
    let nearest = (1.0 / share).round().clamp(1.0, 10.0);
    Value::Words(names.get((nearest - 1.0) as usize).filter(|_| share.is_finite()).map_or("", |name| name).to_owned())
}
