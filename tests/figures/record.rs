//! What is kept of what a command found.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::list::Figure;
use crate::toolchain::workspace;

/// What a command found. Small enough to be committed: of the units of a study only fingerprints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// As a user types it behind `monitor-sim`.
    pub command: String,
    /// Everything the result depends on, as the command reports it.
    pub settings: Value,
    /// Those rows of the result that the README needs.
    pub rows: Vec<Value>,
    /// The tables as they were printed, where the README shows them.
    pub printed: Vec<String>,
    /// Of each unit of work, in their order.
    pub fingerprints: Vec<String>,
}

impl Figure {
    /// Where its record is.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        workspace().join("tests/figures").join(self.name).with_extension("json")
    }

    /// Its record; none if there is no file.
    ///
    /// # Errors
    /// The file cannot be read, or is no record.
    pub fn record(&self) -> Result<Option<Record>, String> {
        let path = self.path();
        let failed = |why: String| format!("{}: {why}", path.display());
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path).map_err(|error| failed(error.to_string()))?;
        serde_json::from_str(&text).map(Some).map_err(|error| failed(error.to_string()))
    }
}

impl Record {
    /// As a file whose changes can be read: a line for each row.
    #[must_use]
    pub fn text(&self) -> String {
        let quoted = |text: &String| Value::from(text.as_str()).to_string();
        let rows = list(self.rows.iter().map(Value::to_string));
        let printed = list(self.printed.iter().map(quoted));
        let eight = |some: &[String]| some.iter().map(quoted).collect::<Vec<_>>().join(", ");
        let fingerprints = list(self.fingerprints.chunks(8).map(eight));
        format!(
            "{{\n\"command\": {},\n\"settings\": {},\n\"rows\": {rows},\n\"printed\": {printed},\n\"fingerprints\": {fingerprints}\n}}\n",
            quoted(&self.command),
            self.settings
        )
    }
}

fn list(items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.map(|item| format!("  {item}")).collect();
    if items.is_empty() { "[]".to_owned() } else { format!("[\n{}\n]", items.join(",\n")) }
}

/// 64 bits of a JSON text, whatever the order of its keys (FNV-1a: Fowler, Noll, Vo).
///
/// # Errors
/// The text is not JSON.
pub fn fingerprint(json: &str) -> Result<String, String> {
    let value: Value = serde_json::from_str(json).map_err(|error| error.to_string())?;
    Ok(format!("{:016x}", hash(value.to_string().as_bytes())))
}

/// FNV-1a.
#[must_use]
pub fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_hash_is_fnv_1a() {
        // From the published test vectors.
        assert_eq!(
            (hash(b""), hash(b"a"), hash(b"foobar")),
            (0xcbf2_9ce4_8422_2325, 0xaf63_dc4c_8601_ec8c, 0x8594_4171_f739_67e8)
        );
    }

    #[test]
    fn a_record_is_read_back_as_it_was_written() {
        let fingerprints = (0..9).map(|n| format!("{n:016x}")).collect();
        let rows = vec![json!({"row": "total", "hours": 0.1}), json!({})];
        let record =
            Record { command: "study".into(), settings: json!({"seed": 1}), rows, printed: vec![], fingerprints };
        assert_eq!(serde_json::from_str::<Record>(&record.text()).unwrap(), record);
    }
}
