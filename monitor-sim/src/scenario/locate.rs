//! From the dotted path of a key to its line in the text, so that a refused value can be found.

use toml::de::{DeTable, DeValue};

use super::ScenarioError;

/// `error` with the line of its key in `text`.
pub(super) fn with_line(error: ScenarioError, text: &str) -> ScenarioError {
    match error {
        ScenarioError::Value { key, problem, remedy, .. } => {
            let line = line_of(&key, text);
            ScenarioError::Value { key, line, problem, remedy }
        }
        other => other,
    }
}

/// Line (from 1) of the dotted path `key`, or of the deepest part of it that the text has; `None` if it has none.
fn line_of(key: &str, text: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let mut offset = None;
    let mut table = Some(document.get_ref());
    for part in key.split('.') {
        let (name, index) = match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
            Some((name, index)) => (name, index.parse::<usize>().ok()),
            None => (part, None),
        };
        let Some((found, value)) = table.and_then(|table| table.get_key_value(name)) else {
            break;
        };
        let value = match (value.get_ref(), index) {
            (DeValue::Array(entries), Some(index)) => entries.get(index)?,
            _ => value,
        };
        offset = Some(if index.is_some() { value.span().start } else { found.span().start });
        table = value.get_ref().as_table();
    }
    let before = text.get(..offset?)?;
    Some(before.matches('\n').count() + 1)
}
