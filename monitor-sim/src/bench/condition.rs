//! A condition on one column of a row.

use serde::{Deserialize, Serialize};

use crate::log::{decode, parse_value};

/// Holds for a row when all that is given holds for its field: text, or a number.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The column.
    pub column: String,
    /// The field is this text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub is: Option<String>,
    /// The field begins with this text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts_with: Option<String>,
    /// The field is a number above this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// The field is a number below this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
}

impl Condition {
    /// Whether it asks for anything, and for one kind of field.
    pub(super) fn check(&self) -> Result<(), String> {
        let (text, number) =
            (self.is.is_some() || self.starts_with.is_some(), self.above.is_some() || self.below.is_some());
        if text == number {
            return Err(format!(
                "the condition on column `{}` must ask for a number or text: `above` and `below`, or `is` or `starts_with`",
                self.column
            ));
        }
        Ok(())
    }

    /// Whether the field fulfils it. A field that is no number is neither above nor below one.
    pub(super) fn holds(&self, field: &[u8]) -> bool {
        let text = decode(field);
        let number = parse_value(field).unwrap_or(f64::NAN);
        self.is.as_ref().is_none_or(|is| text == *is)
            && self.starts_with.as_ref().is_none_or(|start| text.starts_with(start))
            && self.above.is_none_or(|limit| number > limit)
            && self.below.is_none_or(|limit| number < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_compared_as_it_stands_and_what_is_no_number_is_on_no_side_of_one() {
        let column = String::new();
        let layer = Condition { column: column.clone(), starts_with: Some("Layer".to_owned()), ..Condition::default() };
        assert_eq!(
            [&b"Layer 1 Up"[..], b" Layer 2", b"layer", b""].map(|f| layer.holds(f)),
            [true, true, false, false]
        );
        let fast = Condition { column, above: Some(50.0), below: Some(60.0), ..Condition::default() };
        let fields = [&b"50"[..], b"50.1", b"59.9", b"60", b"", b"fast", b"nan"];
        assert_eq!(fields.map(|f| fast.holds(f)), [false, true, true, false, false, false, false]);
    }
}
