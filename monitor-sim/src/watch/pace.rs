//! How fast a run is shown.

use std::fmt;
use std::str::FromStr;

/// How fast a run is shown, in times of real time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// So many times as fast as it was, or would be.
    Times(f64),
    /// As fast as the machine can.
    Max,
}

/// What the keys step through.
const STEPS: [f64; 12] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];

impl Pace {
    /// The next faster one.
    #[must_use]
    pub fn faster(self) -> Self {
        let Pace::Times(times) = self else { return Pace::Max };
        STEPS.into_iter().find(|step| *step > times).map_or(Pace::Max, Pace::Times)
    }

    /// The next slower one.
    #[must_use]
    pub fn slower(self) -> Self {
        let times = if let Pace::Times(times) = self { times } else { f64::INFINITY };
        let slower = STEPS.into_iter().rev().find(|step| *step < times);
        slower.map_or(self, Pace::Times)
    }
}

/// A text that is no pace.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no pace: give how many times as fast as real time (1, 10, 0.5), or `max`")]
pub struct NoPace(String);

impl FromStr for Pace {
    type Err = NoPace;

    fn from_str(text: &str) -> Result<Self, NoPace> {
        match text.trim().parse::<f64>() {
            _ if text.trim() == "max" => Ok(Pace::Max),
            Ok(times) if times > 0.0 && times.is_finite() => Ok(Pace::Times(times)),
            _ => Err(NoPace(text.to_owned())),
        }
    }
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pace::Times(times) => write!(f, "x{times}"),
            Pace::Max => f.write_str("max"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_step_through_every_pace_and_stop_at_both_ends() {
        let mut pace: Pace = "0.1".parse().unwrap();
        assert_eq!(pace.slower(), pace);
        for expected in STEPS.into_iter().skip(1).map(Pace::Times).chain([Pace::Max, Pace::Max]) {
            pace = pace.faster();
            assert_eq!(pace, expected);
        }
        assert_eq!((pace.slower(), Pace::Times(7.0).faster()), (Pace::Times(500.0), Pace::Times(10.0)));
        for text in ["0", "-1", "nan", "inf", "fast", ""] {
            assert!(text.parse::<Pace>().is_err(), "{text}");
        }
    }
}
