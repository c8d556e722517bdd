//! The stretch of a log to learn from: `800..1200` in rows, or `5s..20s` in seconds.
//!
//! Rows count from 0; the first end is included, the second is not, as in a Rust range.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use thiserror::Error;

/// The largest row a time may resolve to: above 2^53 an f64 no longer holds every whole number.
const LAST_ROW: f64 = 9_007_199_254_740_992.0;

/// A time this close to a row (in rows) means that row. `0.29 s x 100 Hz` is 28.999999999999996 in
/// f64, and must not start one row late because of it.
const SNAP_ROWS: f64 = 1e-6;

/// A stretch of the log, as given on the command line.
///
/// ```
/// use monitor_sim::window::RowWindow;
///
/// let rows: RowWindow = "100..400".parse()?;
/// assert_eq!(rows.rows(10.0)?, 100..400);
///
/// let seconds: RowWindow = "5s..20s".parse()?;
/// assert_eq!(seconds.rows(10.0)?, 50..200);
/// # Ok::<(), monitor_sim::window::WindowError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowWindow(Ends);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Ends {
    Rows { from: u64, to: u64 },
    Seconds { from_s: f64, to_s: f64 },
}

/// Why a window was refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum WindowError {
    /// There is no `..`, or one of its ends is missing.
    #[error("`{text}` is not a window; write both ends, in rows (`0..400`) or in seconds (`5s..20s`)")]
    Syntax {
        /// The text as given.
        text: String,
    },
    /// One end is in rows and the other in seconds.
    #[error("the window `{text}` mixes rows and seconds; put the `s` on both ends or on neither")]
    MixedUnits {
        /// The text as given.
        text: String,
    },
    /// An end is not a number.
    #[error("`{end}` in the window `{text}` is not a number; write rows (`0..400`) or seconds (`5s..20s`)")]
    NotANumber {
        /// The text as given.
        text: String,
        /// The end that was wrong.
        end: String,
    },
    /// An end counted in rows is not whole.
    #[error("`{end}` in the window `{text}` is not a whole row; round it, or put an `s` on both ends to give seconds")]
    NotAWholeRow {
        /// The text as given.
        text: String,
        /// The end that was wrong.
        end: String,
    },
    /// An end lies before the log begins.
    #[error("`{end}` in the window `{text}` is negative; the log begins at row 0 (0 s), so start there or later")]
    Negative {
        /// The text as given.
        text: String,
        /// The end that was wrong.
        end: String,
    },
    /// The window has no row: its second end is not after its first.
    #[error("the window `{text}` is empty; its second end must be after its first")]
    Empty {
        /// The text as given.
        text: String,
    },
    /// A window in seconds is so short that no row falls into it at this rate.
    #[error("no row falls into the window `{text}` at {rate_hz} Hz; make it longer than {} s, or check the rate", 1.0 / .rate_hz)]
    ShorterThanARow {
        /// The window.
        text: String,
        /// The rate of the log, in hertz.
        rate_hz: f64,
    },
    /// An end is further than any log reaches.
    #[error("the window `{text}` ends after the last row that can be counted (2^53); give a smaller end")]
    TooFar {
        /// The window.
        text: String,
    },
    /// The rate is not a positive finite number.
    #[error("the rate {rate_hz} Hz cannot turn seconds into rows; give the log's sample rate, above 0")]
    Rate {
        /// The rate as given, in hertz.
        rate_hz: f64,
    },
}

impl RowWindow {
    /// The rows of the window in a log sampled at `rate_hz`.
    ///
    /// A window in rows needs no rate and ignores it. In seconds, row `k` was taken at `k / rate_hz`,
    /// and the window holds the rows taken at or after its first end and before its second.
    ///
    /// # Errors
    /// [`WindowError::Rate`], [`WindowError::ShorterThanARow`] or [`WindowError::TooFar`], for a
    /// window in seconds.
    pub fn rows(&self, rate_hz: f64) -> Result<Range<u64>, WindowError> {
        let (from_s, to_s) = match self.0 {
            Ends::Rows { from, to } => return Ok(from..to),
            Ends::Seconds { from_s, to_s } => (from_s, to_s),
        };
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            return Err(WindowError::Rate { rate_hz });
        }
        let from = first_row_at(from_s * rate_hz);
        let to = first_row_at(to_s * rate_hz);
        if to > LAST_ROW {
            return Err(WindowError::TooFar { text: self.to_string() });
        }
        if from >= to {
            return Err(WindowError::ShorterThanARow { text: self.to_string(), rate_hz });
        }
        Ok(from as u64..to as u64)
    }
}

/// The first whole row at or after `position` (in rows, with a fraction).
fn first_row_at(position: f64) -> f64 {
    let nearest = position.round();
    if (position - nearest).abs() <= SNAP_ROWS { nearest } else { position.ceil() }
}

impl FromStr for RowWindow {
    type Err = WindowError;

    fn from_str(text: &str) -> Result<Self, WindowError> {
        let (first, second) = text.split_once("..").ok_or_else(|| WindowError::Syntax { text: text.to_owned() })?;
        let (first, second) = (first.trim(), second.trim());
        if first.is_empty() || second.is_empty() {
            return Err(WindowError::Syntax { text: text.to_owned() });
        }
        let ends = match (first.strip_suffix('s'), second.strip_suffix('s')) {
            (None, None) => Ends::Rows { from: row(text, first)?, to: row(text, second)? },
            (Some(from), Some(to)) => Ends::Seconds { from_s: number(text, from)?, to_s: number(text, to)? },
            _ => {
                return Err(WindowError::MixedUnits { text: text.to_owned() });
            }
        };
        let in_order = match ends {
            Ends::Rows { from, to } => from < to,
            Ends::Seconds { from_s, to_s } => from_s < to_s,
        };
        if !in_order {
            return Err(WindowError::Empty { text: text.to_owned() });
        }
        Ok(Self(ends))
    }
}

/// An end in rows. What is wrong with it is found by reading it as a plain number first.
fn row(text: &str, end: &str) -> Result<u64, WindowError> {
    if let Ok(row) = end.parse() {
        return Ok(row);
    }
    let number = number(text, end)?;
    if number > LAST_ROW {
        return Err(WindowError::TooFar { text: text.to_owned() });
    }
    Err(WindowError::NotAWholeRow { text: text.to_owned(), end: end.to_owned() })
}

fn number(text: &str, end: &str) -> Result<f64, WindowError> {
    let named = || (text.to_owned(), end.trim().to_owned());
    match end.trim().parse::<f64>() {
        Ok(number) if number < 0.0 => {
            let (text, end) = named();
            Err(WindowError::Negative { text, end })
        }
        Ok(number) if number.is_finite() => Ok(number),
        _ => {
            let (text, end) = named();
            Err(WindowError::NotANumber { text, end })
        }
    }
}

impl fmt::Display for RowWindow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Ends::Rows { from, to } => write!(f, "{from}..{to}"),
            Ends::Seconds { from_s, to_s } => write!(f, "{from_s}s..{to_s}s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str, rate_hz: f64) -> Range<u64> {
        text.parse::<RowWindow>().unwrap().rows(rate_hz).unwrap()
    }

    fn refusal(text: &str) -> WindowError {
        text.parse::<RowWindow>().unwrap_err()
    }

    #[test]
    fn a_window_in_rows_is_the_rust_range_at_any_rate() {
        assert_eq!(rows("0..400", 10.0), 0..400);
        assert_eq!(rows(" 7 .. 9 ", f64::NAN), 7..9);
    }

    #[test]
    fn a_window_in_seconds_holds_the_rows_taken_from_its_first_end_to_before_its_second() {
        assert_eq!(rows("5s..20s", 10.0), 50..200);
        // Rows at 0, 0.4, 0.8, 1.2 s: the first at or after 0.5 s is row 2; 1.2 s itself is out.
        assert_eq!(rows("0.5s..1.2s", 2.5), 2..3);
    }

    #[test]
    fn a_time_that_is_a_row_but_for_rounding_starts_at_that_row() {
        // 0.29 x 100 = 28.999999999999996 and 0.07 x 100 = 7.000000000000001 in f64.
        assert_eq!(rows("0.07s..0.29s", 100.0), 7..29);
    }

    #[test]
    fn each_mistake_in_a_window_is_told_with_its_remedy() {
        for text in ["", "800", "..", "5..", "..5", "5-9"] {
            assert!(matches!(refusal(text), WindowError::Syntax { .. }), "{text}");
        }
        for text in ["5s..20", "5..20s"] {
            assert!(matches!(refusal(text), WindowError::MixedUnits { .. }), "{text}");
        }
        for text in ["a..5", "0..=5", "nans..5s", "0s..infs", "1..2..3", "0..NaN"] {
            assert!(matches!(refusal(text), WindowError::NotANumber { .. }), "{text}");
        }
        for text in ["-1..5", "-5s..2s", "0..-3"] {
            assert!(matches!(refusal(text), WindowError::Negative { .. }), "{text}");
        }
        for text in ["5..5", "9..5", "9s..5s", "2s..2s"] {
            assert!(matches!(refusal(text), WindowError::Empty { .. }), "{text}");
        }
        assert!(matches!(refusal("0.5..8"), WindowError::NotAWholeRow { .. }));
        assert!(matches!(refusal("0..99999999999999999999"), WindowError::TooFar { .. }));
        assert_eq!(
            refusal("5s..20").to_string(),
            "the window `5s..20` mixes rows and seconds; put the `s` on both ends or on neither"
        );
    }

    #[test]
    fn a_window_in_seconds_that_no_row_falls_into_is_refused_when_the_rate_is_known() {
        let window: RowWindow = "0.1s..0.2s".parse().unwrap();
        assert_eq!(window.rows(1.0), Err(WindowError::ShorterThanARow { text: "0.1s..0.2s".to_owned(), rate_hz: 1.0 }));
        let far: RowWindow = "0s..1e300s".parse().unwrap();
        assert!(matches!(far.rows(1e300), Err(WindowError::TooFar { .. })));
    }

    #[test]
    fn seconds_need_a_positive_finite_rate() {
        let window: RowWindow = "1s..2s".parse().unwrap();
        for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(window.rows(rate_hz), Err(WindowError::Rate { .. })), "{rate_hz}");
        }
    }

    #[test]
    fn a_printed_window_reads_back_as_itself() {
        for text in ["0..400", "5s..20s", "0.25s..1.5s"] {
            let window: RowWindow = text.parse().unwrap();
            assert_eq!(window.to_string(), text);
            assert_eq!(window.to_string().parse::<RowWindow>().unwrap(), window);
        }
    }
}
