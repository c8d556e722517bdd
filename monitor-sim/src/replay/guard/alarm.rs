//! Alarms: what is said of the rows of a replay amounts to.

use monitor_core::guard::{Loss, Verdict};
use serde::Serialize;

use crate::guardian::{SCALE_NAMES, Said, Size};
use crate::names::ChannelNames;
use crate::names::name::Name;

/// A stretch of rows over which an alarm stood.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// First row of the alarm.
    pub start_row: u64,
    /// Last row of it.
    pub end_row: u64,
    /// Seconds from the first row of the log to the first of the alarm.
    pub start_s: f64,
    /// Seconds from the first row of the log to the last of the alarm.
    pub end_s: f64,
    /// Whether it still stood when the log ended.
    pub ongoing: bool,
    /// The identifier of the name that stood longest; none when no name could be given.
    pub located: Option<&'static str>,
    /// The size that this name gave last.
    pub size: Option<Size>,
    /// Sensors that were lost meanwhile, and how.
    pub lost: Vec<String>,
    /// The largest distance over its limit; none if no row of it was judged.
    pub peak: Option<f64>,
    /// The time scale of that distance.
    pub peak_scale: Option<&'static str>,
    /// Share of each channel in the deviation, where it was largest and, if ever, stood still.
    pub contributions: Option<[f64; 3]>,
    #[serde(skip)]
    name: Option<Name>,
}

impl Alarm {
    /// The name that stood longest, in words.
    #[must_use]
    pub fn located_as(&self) -> String {
        self.name.map_or_else(|| "-".to_owned(), Name::shown)
    }
}

/// Makes alarms of what is said.
#[derive(Debug)]
pub(crate) struct AlarmBuilder {
    rate_hz: f64,
    names: ChannelNames,
    done: Vec<Alarm>,
    open: Option<OpenAlarm>,
}

#[derive(Debug)]
struct OpenAlarm {
    alarm: Alarm,
    /// Rows each name has stood, with the size it gave last.
    stood: Vec<(Name, u64, Option<Size>)>,
    /// Whether the deviation stood still, and its distance, at the row that the contributions are of.
    worst: (bool, f32),
}

impl AlarmBuilder {
    pub(crate) fn new(rate_hz: f64, names: ChannelNames) -> Self {
        AlarmBuilder { rate_hz, names, done: Vec::new(), open: None }
    }

    /// Takes what was said of a row; `contributions` is asked when it is the worst of its alarm so far.
    pub(crate) fn push(&mut self, row: u64, said: &Said, contributions: impl FnOnce() -> Option<[f64; 3]>) {
        let verdict = &said.verdict;
        if !verdict.alarm() {
            self.close();
            return;
        }
        let t_s = row as f64 / self.rate_hz;
        let open = self.open.get_or_insert_with(|| OpenAlarm::begun(row, t_s));
        open.alarm.end_row = row;
        open.alarm.end_s = t_s;
        open.name(said);
        for (channel, loss) in verdict.losses() {
            let how = if loss == Loss::Stuck { "stuck" } else { "silent" };
            let lost = format!("{} {how}", self.names.of(channel));
            if !open.alarm.lost.contains(&lost) {
                open.alarm.lost.push(lost);
            }
        }
        open.weigh(verdict, contributions);
    }

    fn close(&mut self) {
        if let Some(mut open) = self.open.take() {
            open.alarm.ongoing = false;
            self.done.push(open.named());
        }
    }

    pub(crate) fn finish(mut self) -> Vec<Alarm> {
        self.done.extend(self.open.take().map(OpenAlarm::named));
        self.done
    }
}

impl OpenAlarm {
    fn begun(row: u64, t_s: f64) -> Self {
        let alarm = Alarm {
            start_row: row,
            end_row: row,
            start_s: t_s,
            end_s: t_s,
            ongoing: true,
            located: None,
            size: None,
            lost: Vec::new(),
            peak: None,
            peak_scale: None,
            contributions: None,
            name: None,
        };
        OpenAlarm { alarm, stood: Vec::new(), worst: (false, 0.0) }
    }

    fn name(&mut self, said: &Said) {
        let Some(found) = said.found else { return };
        match self.stood.iter_mut().find(|(name, ..)| *name == found.name) {
            Some((_, rows, size)) => {
                *rows += 1;
                *size = found.size;
            }
            None => self.stood.push((found.name, 1, found.size)),
        }
    }

    fn weigh(&mut self, verdict: &Verdict, contributions: impl FnOnce() -> Option<[f64; 3]>) {
        let Some(severity) = verdict.severity() else { return };
        let worst = SCALE_NAMES.into_iter().zip(severity).max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((scale, distance)) = worst else { return };
        if self.alarm.peak.is_none_or(|peak| f64::from(distance) > peak) {
            self.alarm.peak = Some(f64::from(distance));
            self.alarm.peak_scale = Some(scale);
        }
        // Where a fault has come to stand, the estimate says more of it than the readings of one row.
        let now = (verdict.settled(), distance);
        if now > self.worst {
            self.worst = now;
            self.alarm.contributions = contributions().or(self.alarm.contributions);
        }
    }

    fn named(self) -> Alarm {
        let longest = self.stood.into_iter().max_by_key(|(_, rows, _)| *rows);
        let (name, size) = longest.map_or((None, None), |(name, _, size)| (Some(name), size));
        Alarm { located: name.map(Name::id), size, name, ..self.alarm }
    }
}
