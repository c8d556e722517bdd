//! Faults put into recorded rows: an offset, a ramp or a gain on one channel.
//!
//! A recorded log of a healthy motor holds no fault to find. An [`Injection`] adds one at a known
//! row, so that the delay of the alarm can be counted from it.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// What every message about a wrong injection ends with.
const SYNTAX: &str = "write CHANNEL:CHANGE@FROM or CHANNEL:CHANGE@FROM..TO, \
                      for example `current:+0.5@800`, `current:x1.1@800..1200` or `current:ramp+0.5@800..1200`";

/// A fault to put into the rows of a log, as given on the command line.
///
/// | text | what it does |
/// |---|---|
/// | `current:+0.5@800` | adds 0.5 from row 800 to the end |
/// | `current:-0.5@800..1200` | takes 0.5 off rows 800 to 1199 |
/// | `current:ramp+0.5@800..1200` | adds a ramp: 0 at row 800, growing towards 0.5 at row 1200, where it ends |
/// | `current:x1.1@800` or `current:*1.1@800` | multiplies by 1.1 from row 800 to the end |
///
/// Rows count from 0. The amounts are in the unit of the column.
///
/// ```
/// use monitor_sim::inject::Injection;
///
/// let injection: Injection = "current:+0.5@2".parse()?;
/// let injection = injection.resolve(&["speed", "current"])?;
/// let mut row = [100.0, 3.0];
/// injection.apply(1, &mut row);
/// assert_eq!(row, [100.0, 3.0]);
/// injection.apply(2, &mut row);
/// assert_eq!(row, [100.0, 3.5]);
/// # Ok::<(), monitor_sim::inject::InjectError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Injection {
    channel: String,
    change: Change,
    from: u64,
    /// The first row after the fault; `None`: it lasts to the end of the log.
    to: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    Offset(f64),
    Ramp(f64),
    Gain(f64),
}

/// Why an injection was refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InjectError {
    /// There is no `@FROM`.
    #[error("the injection `{text}` does not say at which row it begins; {SYNTAX}")]
    NoRow {
        /// The text as given.
        text: String,
    },
    /// There is no `CHANNEL:`.
    #[error("the injection `{text}` does not name a channel; {SYNTAX}")]
    NoChannel {
        /// The text as given.
        text: String,
    },
    /// The change is not an offset, a ramp or a gain.
    #[error("`{change}` in the injection `{text}` is not a change (an offset and a ramp need their sign); {SYNTAX}")]
    Change {
        /// The text as given.
        text: String,
        /// The part that was wrong.
        change: String,
    },
    /// The amount is not a finite number.
    #[error("`{amount}` in the injection `{text}` is not a finite number; {SYNTAX}")]
    Amount {
        /// The text as given.
        text: String,
        /// The part that was wrong.
        amount: String,
    },
    /// A row is not a whole number from 0.
    #[error("`{row}` in the injection `{text}` is not a row (rows are whole numbers from 0); {SYNTAX}")]
    Row {
        /// The text as given.
        text: String,
        /// The part that was wrong.
        row: String,
    },
    /// The fault would end before it begins.
    #[error("the injection `{text}` covers no row, as it ends at or before its first; {SYNTAX}")]
    Empty {
        /// The text as given.
        text: String,
    },
    /// A ramp has no end, so that its slope is unknown.
    #[error("the ramp `{text}` does not say at which row it reaches its full size, so its slope is unknown; {SYNTAX}")]
    RampWithoutEnd {
        /// The text as given.
        text: String,
    },
    /// The log has no such channel.
    #[error("there is no channel `{channel}` to inject a fault into{}; the channels are {}", did_you_mean(.nearest), .known.join(", "))]
    UnknownChannel {
        /// The channel that was asked for.
        channel: String,
        /// The channel that was likely meant.
        nearest: Option<String>,
        /// The channels there are.
        known: Vec<String>,
    },
}

/// The middle of an "unknown name" message.
pub(crate) fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!(" (did you mean `{name}`?)"))
}

/// The one of `known` that `asked` was likely meant to be, or `None` if none is close.
pub(crate) fn nearest_name<'a>(asked: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    // Jaro-Winkler, 0 to 1, measured: names of different quantities reach 0.65 (`pressure` and
    // `temperature`), `current` and `S1_CurrentFeedback` 0.73, a slip of one letter 0.9 and more.
    const CLOSE: f64 = 0.7;
    let asked = asked.to_lowercase();
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&asked, &name.to_lowercase()), name))
        .filter(|(likeness, _)| *likeness >= CLOSE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.to_owned())
}

impl Injection {
    /// The channel the fault is put into, as given.
    pub fn channel(&self) -> &str {
        &self.channel
    }

    /// The first row with the fault.
    pub fn first_row(&self) -> u64 {
        self.from
    }

    /// The first row after the fault; `None` if it lasts to the end of the log.
    pub fn end_row(&self) -> Option<u64> {
        self.to
    }

    /// Finds the channel among the `names` of a row's values.
    ///
    /// # Errors
    /// [`InjectError::UnknownChannel`] with the nearest name.
    pub fn resolve(&self, names: &[&str]) -> Result<ResolvedInjection, InjectError> {
        let index = names.iter().position(|name| *name == self.channel).ok_or_else(|| InjectError::UnknownChannel {
            channel: self.channel.clone(),
            nearest: nearest_name(&self.channel, names.iter().copied()),
            known: names.iter().map(|name| (*name).to_owned()).collect(),
        })?;
        Ok(ResolvedInjection { index, change: self.change, from: self.from, to: self.to.unwrap_or(u64::MAX) })
    }
}

/// An [`Injection`] that knows the place of its channel in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResolvedInjection {
    index: usize,
    change: Change,
    from: u64,
    to: u64,
}

impl ResolvedInjection {
    /// Puts the fault into the `values` of row `row`; leaves rows outside the fault as they are.
    ///
    /// A missing value (NaN) stays missing. A row too short to hold the channel is left alone.
    pub fn apply(&self, row: u64, values: &mut [f64]) {
        if !(self.from..self.to).contains(&row) {
            return;
        }
        let Some(value) = values.get_mut(self.index) else {
            return;
        };
        match self.change {
            Change::Offset(offset) => *value += offset,
            Change::Gain(gain) => *value *= gain,
            Change::Ramp(full) => {
                *value += full * ((row - self.from) as f64 / (self.to - self.from) as f64);
            }
        }
    }
}

impl FromStr for Injection {
    type Err = InjectError;

    fn from_str(text: &str) -> Result<Self, InjectError> {
        let whole = || text.to_owned();
        let (what, rows) = text.rsplit_once('@').ok_or_else(|| InjectError::NoRow { text: whole() })?;
        // From the right, as a channel's name may hold a colon and a change never does.
        let (channel, change) = what.rsplit_once(':').ok_or_else(|| InjectError::NoChannel { text: whole() })?;
        let channel = channel.trim();
        if channel.is_empty() {
            return Err(InjectError::NoChannel { text: whole() });
        }
        let change = parse_change(text, change.trim())?;
        let (from, to) = match rows.split_once("..") {
            None => (parse_row(text, rows)?, None),
            Some((from, to)) => (parse_row(text, from)?, Some(parse_row(text, to)?)),
        };
        match to {
            Some(to) if to <= from => return Err(InjectError::Empty { text: whole() }),
            None if matches!(change, Change::Ramp(_)) => {
                return Err(InjectError::RampWithoutEnd { text: whole() });
            }
            _ => {}
        }
        Ok(Self { channel: channel.to_owned(), change, from, to })
    }
}

fn parse_change(text: &str, change: &str) -> Result<Change, InjectError> {
    let signed = |amount: &str| amount.starts_with(['+', '-']);
    if let Some(gain) = change.strip_prefix(['x', '*']) {
        parse_amount(text, gain).map(Change::Gain)
    } else if let Some(full) = change.strip_prefix("ramp").filter(|full| signed(full)) {
        parse_amount(text, full).map(Change::Ramp)
    } else if signed(change) {
        parse_amount(text, change).map(Change::Offset)
    } else {
        Err(InjectError::Change { text: text.to_owned(), change: change.to_owned() })
    }
}

fn parse_amount(text: &str, amount: &str) -> Result<f64, InjectError> {
    match amount.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(InjectError::Amount { text: text.to_owned(), amount: amount.to_owned() }),
    }
}

fn parse_row(text: &str, row: &str) -> Result<u64, InjectError> {
    row.trim().parse().map_err(|_| InjectError::Row { text: text.to_owned(), row: row.trim().to_owned() })
}

impl fmt::Display for Injection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { channel, change, from, to } = self;
        match change {
            Change::Offset(offset) => write!(f, "{channel}:{offset:+}@{from}")?,
            Change::Ramp(full) => write!(f, "{channel}:ramp{full:+}@{from}")?,
            Change::Gain(gain) => write!(f, "{channel}:x{gain}@{from}")?,
        }
        to.map_or(Ok(()), |to| write!(f, "..{to}"))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CHANNELS: [&str; 3] = ["speed", "current", "voltage"];

    /// The current, 2 A in the log, after the injection at each of `rows`.
    fn current(text: &str, rows: &[u64]) -> Vec<f64> {
        let injection = text.parse::<Injection>().unwrap().resolve(&CHANNELS).unwrap();
        let injected = |row: &u64| {
            let mut values = [100.0, 2.0, 24.0];
            injection.apply(*row, &mut values);
            assert_eq!([values[0], values[2]], [100.0, 24.0], "another channel was touched");
            values[1]
        };
        rows.iter().map(injected).collect()
    }

    fn refusal(text: &str) -> InjectError {
        text.parse::<Injection>().unwrap_err()
    }

    #[test]
    fn an_offset_without_an_end_lasts_from_its_first_row_to_the_end_of_the_log() {
        assert_eq!(current("current:+0.5@800", &[0, 799, 800, 1 << 40]), [2.0, 2.0, 2.5, 2.5]);
    }

    #[test]
    fn an_offset_with_an_end_leaves_its_end_row_alone() {
        let rows = [799, 800, 1199, 1200];
        assert_eq!(current("current:-0.5@800..1200", &rows), [2.0, 1.5, 1.5, 2.0]);
    }

    #[test]
    fn a_ramp_is_zero_at_its_first_row_half_way_at_half_time_and_gone_at_its_end() {
        let rows = [799, 800, 1000, 1100, 1200];
        assert_eq!(current("current:ramp+0.5@800..1200", &rows), [2.0, 2.0, 2.25, 2.375, 2.0]);
        assert_eq!(current("current:ramp-0.5@800..1200", &[1000]), [1.75]);
    }

    #[test]
    fn a_gain_multiplies_and_may_be_written_with_x_or_a_star() {
        assert_eq!(current("current:x1.5@800", &[799, 800]), [2.0, 3.0]);
        assert_eq!(current("current:*1.5@800..801", &[799, 800, 801]), [2.0, 3.0, 2.0]);
    }

    #[test]
    fn a_missing_value_stays_missing_and_a_short_row_is_left_alone() {
        let injection = "current:+0.5@0".parse::<Injection>().unwrap().resolve(&CHANNELS).unwrap();
        let mut values = [100.0, f64::NAN, 24.0];
        injection.apply(0, &mut values);
        assert!(values[1].is_nan());
        let mut short = [100.0];
        injection.apply(0, &mut short);
        assert_eq!(short, [100.0]);
    }

    #[test]
    fn a_channel_name_may_hold_a_colon_and_an_at_sign() {
        let injection: Injection = "axis:1@base:+0.5@3".parse().unwrap();
        assert_eq!(injection.channel(), "axis:1@base");
        assert_eq!((injection.first_row(), injection.end_row()), (3, None));
    }

    #[test]
    fn each_mistake_is_told_with_the_syntax_and_an_example() {
        type IsExpected = fn(&InjectError) -> bool;
        let cases: [(&str, IsExpected); 17] = [
            ("", |e| matches!(e, InjectError::NoRow { .. })),
            ("current:+0.5", |e| matches!(e, InjectError::NoRow { .. })),
            ("+0.5@800", |e| matches!(e, InjectError::NoChannel { .. })),
            (":+0.5@800", |e| matches!(e, InjectError::NoChannel { .. })),
            ("current:0.5@800", |e| matches!(e, InjectError::Change { .. })),
            ("current:@800", |e| matches!(e, InjectError::Change { .. })),
            ("current:ramp0.5@8..9", |e| matches!(e, InjectError::Change { .. })),
            ("current:x@800", |e| matches!(e, InjectError::Amount { .. })),
            ("current:+nan@800", |e| matches!(e, InjectError::Amount { .. })),
            ("current:+1e999@800", |e| matches!(e, InjectError::Amount { .. })),
            ("current:xinf@800", |e| matches!(e, InjectError::Amount { .. })),
            ("current:+0,5@800", |e| matches!(e, InjectError::Amount { .. })),
            ("current:+0.5@", |e| matches!(e, InjectError::Row { .. })),
            ("current:+0.5@-1", |e| matches!(e, InjectError::Row { .. })),
            ("current:+0.5@1..", |e| matches!(e, InjectError::Row { .. })),
            ("current:+0.5@9..9", |e| matches!(e, InjectError::Empty { .. })),
            ("current:ramp+0.5@800", |e| matches!(e, InjectError::RampWithoutEnd { .. })),
        ];
        for (text, expected) in cases {
            let error = refusal(text);
            assert!(expected(&error), "{text}: {error}");
            assert!(error.to_string().contains("for example `current:+0.5@800`"), "{error}");
        }
    }

    #[test]
    fn an_unknown_channel_is_told_with_the_nearest_name() {
        let unknown = |text: &str| text.parse::<Injection>().unwrap().resolve(&CHANNELS).unwrap_err().to_string();
        assert_eq!(
            unknown("Curent:+0.5@800"),
            "there is no channel `Curent` to inject a fault into (did you mean `current`?); \
             the channels are speed, current, voltage"
        );
        assert!(!unknown("torque:+0.5@800").contains("did you mean"));
    }

    proptest! {
        #[test]
        fn a_printed_injection_reads_back_as_itself(
            kind in 0..3, amount in -1e9..1e9, from in 0_u64..1 << 50, rows in 1_u64..1 << 50, ends: bool,
        ) {
            let change = match kind {
                0 => Change::Offset(amount),
                1 => Change::Ramp(amount),
                _ => Change::Gain(amount),
            };
            let to = (ends || kind == 1).then_some(from + rows);
            let injection = Injection { channel: "current".to_owned(), change, from, to };
            prop_assert_eq!(injection.to_string().parse::<Injection>(), Ok(injection));
        }

        #[test]
        fn no_text_makes_the_parser_panic(text: String) {
            let _ = text.parse::<Injection>();
        }
    }
}
