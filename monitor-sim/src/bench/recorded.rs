//! One recorded run: the samples, when they were taken, and what is known of them.

use std::fs;
use std::path::Path;

use csv::ByteRecord;
use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::condition::Condition;
use super::protocol::Protocol;
use super::{BenchError, Sample};
use crate::intervals::Intervals;
use crate::log::{ColumnRef, Delimiter, decode, find_column, not_a_number, parse_value, sniff_delimiter};

/// How much of a file is looked at to find its delimiter.
const HEAD_BYTES: usize = 64 * 1024;

/// A run, as far as a protocol asks for it.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// Path of the file below the directory.
    pub name: String,
    /// Rows of the file.
    pub rows: usize,
    /// The samples: of the rows that count.
    pub samples: Vec<Sample>,
    /// When each was taken, in nanoseconds from the first.
    pub at_ns: Vec<i64>,
    /// Whether each is anomalous, where the protocol has labels.
    pub anomaly: Vec<bool>,
    /// Whether something changes at each, where the protocol has such labels.
    pub change_point: Vec<bool>,
    /// Whether each fulfils what is asked of rows to learn from.
    pub learnable: Vec<bool>,
    /// Whether the run is one of the healthy ones.
    pub healthy: bool,
}

impl Recorded {
    /// Reads a run.
    ///
    /// # Errors
    /// [`BenchError::Run`] says what is wrong with the file, and where.
    pub fn read(protocol: &Protocol, path: &Path, name: String) -> Result<Self, BenchError> {
        let wrong = |why: String| BenchError::Run { path: path.to_owned(), why };
        let bytes = fs::read(path).map_err(|error| wrong(format!("it cannot be read ({error}); check the file")))?;
        read(protocol, &bytes, name).map_err(wrong)
    }

    /// Seconds from the first sample to another.
    #[must_use]
    pub fn seconds(&self, row: usize) -> f64 {
        self.at_ns.get(row).or(self.at_ns.last()).map_or(0.0, |at| *at as f64 * 1e-9)
    }

    /// The stretches over which something held, in seconds: `holds` begins with row `from`. The last one ends with the run.
    #[must_use]
    pub fn stretches(&self, holds: &[bool], from: usize) -> Vec<(f64, f64)> {
        let mut intervals = Intervals::default();
        for (row, holds) in holds.iter().enumerate() {
            intervals.push((from + row) as u64, *holds);
        }
        intervals.all().into_iter().map(|at| (self.seconds(at.start as usize), self.seconds(at.end as usize))).collect()
    }

    /// The longest stretch of samples to learn from, over which the set point does not move: its first row and the one
    /// behind its last.
    #[must_use]
    pub fn longest_stretch(&self, set_point_tolerance: f64) -> (usize, usize) {
        let (mut longest, mut begun): ((usize, usize), Option<(usize, f64)>) = ((0, 0), None);
        for (row, (sample, learnable)) in self.samples.iter().zip(&self.learnable).enumerate() {
            let at = sample.set_point;
            let goes_on = begun.filter(|(_, from)| *learnable && (at - from).abs() <= set_point_tolerance);
            begun = goes_on.or(learnable.then_some((row, at)));
            if let Some((start, _)) = begun
                && row + 1 - start > longest.1 - longest.0
            {
                longest = (start, row + 1);
            }
        }
        longest
    }
}

/// Where the columns are that a protocol asks for.
struct Columns {
    header: Vec<String>,
    channels: Vec<usize>,
    set_point: Option<usize>,
    time: Option<usize>,
    anomaly: Option<usize>,
    change_point: Option<usize>,
    rows_where: Vec<(usize, Condition)>,
    learn_where: Vec<(usize, Condition)>,
    healthy: Option<(usize, Condition)>,
}

impl Columns {
    fn find(protocol: &Protocol, header: Vec<String>) -> Result<Self, String> {
        let find = |what: &str, column: &str| {
            let asked: ColumnRef = column.parse().map_err(|error| format!("{what}: {error}"))?;
            find_column(what, &asked, &header, true).map_err(|error| error.to_string())
        };
        let label = |what: &str, column: &str| {
            find(what, column).map_err(|why| {
                format!("{why}. A run without labels cannot be scored: label it, or name its file under `skip`")
            })
        };
        let found = |conditions: &[Condition]| {
            let found =
                conditions.iter().map(|condition| Ok((find("condition", &condition.column)?, condition.clone())));
            found.collect::<Result<Vec<_>, String>>()
        };
        let (data, labels) = (&protocol.data, protocol.labels.as_ref());
        let channels = protocol.channel.iter().map(|channel| find(&channel.name, &channel.column));
        let change_point = labels.and_then(|labels| labels.change_point.as_ref());
        let columns = Columns {
            channels: channels.collect::<Result<_, _>>()?,
            set_point: data.set_point.as_ref().map(|column| find("set point", column)).transpose()?,
            time: data.time.as_ref().map(|column| find("time", column)).transpose()?,
            anomaly: labels.map(|labels| label("label", &labels.anomaly)).transpose()?,
            change_point: change_point.map(|column| label("label", column)).transpose()?,
            rows_where: found(&data.conditions)?,
            learn_where: found(&protocol.learn.longest_where)?,
            healthy: match &protocol.drifts {
                Some(drifts) => found(std::slice::from_ref(&drifts.healthy))?.pop(),
                None => None,
            },
            header: Vec::new(),
        };
        Ok(Columns { header, ..columns })
    }
}

fn read(protocol: &Protocol, bytes: &[u8], name: String) -> Result<Recorded, String> {
    let head = bytes.get(..HEAD_BYTES).unwrap_or(bytes);
    let delimiter = match &protocol.data.delimiter {
        Some(given) => given.parse::<Delimiter>().map_err(|error| error.to_string())?.byte(),
        None => sniff_delimiter(head),
    };
    let mut csv = csv::ReaderBuilder::new().delimiter(delimiter).has_headers(false).flexible(true).from_reader(bytes);
    let mut record = ByteRecord::new();
    let mut next = |record: &mut ByteRecord| csv.read_byte_record(record).map_err(|error| error.to_string());
    if !next(&mut record)? {
        return Err("it is empty; remove it, or name it under `skip`".to_owned());
    }
    let columns = Columns::find(protocol, record.iter().map(decode).collect())?;
    let mut run = Recorded { name, ..Recorded::default() };
    let (mut row, mut clock) = (0, Clock::new(protocol.data.rate_hz));
    while next(&mut record)? {
        take(&mut run, &columns, &record, row, &mut clock)?;
        row += 1;
    }
    if run.samples.is_empty() {
        return Err(format!("none of its {row} rows counts; check `where` of the description"));
    }
    run.rows = row as usize;
    Ok(run)
}

/// Takes one row, if it is one that counts.
fn take(run: &mut Recorded, columns: &Columns, record: &ByteRecord, row: u64, clock: &mut Clock) -> Result<(), String> {
    let (found, expected) = (record.len(), columns.header.len());
    if found != expected {
        return Err(format!(
            "row {row} has {found} fields where the header has {expected}; repair or remove that line"
        ));
    }
    let field = |column: usize| record.get(column).unwrap_or_default();
    let all = |conditions: &[(usize, Condition)]| conditions.iter().all(|(column, c)| c.holds(field(*column)));
    let named = |column: usize| columns.header.get(column).cloned().unwrap_or_default();
    if !all(&columns.rows_where) {
        return Ok(());
    }
    let number = |column: usize| {
        let line = record.position().map_or(row + 2, csv::Position::line);
        parse_value(field(column)).ok_or_else(|| not_a_number(field(column), row, line, named(column)).to_string())
    };
    let label = |column: usize| {
        truth(field(column)).ok_or_else(|| {
            format!(
                "row {row}: `{}` in column `{}` is no label; write 0 or 1 in every row",
                decode(field(column)),
                named(column)
            )
        })
    };
    let mut x = [f64::NAN; 3];
    for (x, column) in x.iter_mut().zip(&columns.channels) {
        *x = number(*column)?;
    }
    let set_point = columns.set_point.map(number).transpose()?.unwrap_or(0.0);
    let at_ns = match columns.time {
        Some(column) => clock.read(field(column)),
        None => clock.of_row(row),
    };
    run.at_ns.push(at_ns.map_err(|why| format!("row {row}: {why}"))?);
    run.anomaly.extend(columns.anomaly.map(label).transpose()?);
    run.change_point.extend(columns.change_point.map(label).transpose()?);
    run.learnable.push(all(&columns.learn_where));
    if run.samples.is_empty() {
        run.healthy = columns.healthy.as_ref().is_some_and(|(column, condition)| condition.holds(field(*column)));
    }
    run.samples.push(Sample { set_point, x });
    Ok(())
}

/// What a label says.
fn truth(field: &[u8]) -> Option<bool> {
    match decode(field).to_ascii_lowercase().as_str() {
        "true" => Some(true),
        "false" => Some(false),
        text => text.parse::<f64>().ok().filter(|value| value.is_finite()).map(|value| value != 0.0),
    }
}

/// Instants as nanoseconds from the first row that counts.
struct Clock {
    rate_hz: f64,
    first_ns: Option<i128>,
    last_ns: i64,
}

impl Clock {
    const fn new(rate_hz: f64) -> Self {
        Clock { rate_hz, first_ns: None, last_ns: 0 }
    }

    fn of_row(&mut self, row: u64) -> Result<i64, String> {
        self.since_first((row as f64 / self.rate_hz * 1e9).round() as i128)
    }

    /// Seconds, or a date with a time, with or without a time zone.
    fn read(&mut self, field: &[u8]) -> Result<i64, String> {
        let text = decode(field);
        let of_date = |date: DateTime| TimeZone::UTC.to_timestamp(date);
        let ns = match text.parse::<f64>() {
            Ok(seconds) if seconds.is_finite() => Some((seconds * 1e9).round() as i128),
            _ => {
                let local = text.parse::<DateTime>().and_then(of_date);
                text.parse::<Timestamp>().or(local).ok().map(Timestamp::as_nanosecond)
            }
        };
        let ns = ns.ok_or_else(|| format!("`{text}` is no time; write seconds, or YYYY-MM-DD hh:mm:ss"))?;
        self.since_first(ns)
    }

    fn since_first(&mut self, ns: i128) -> Result<i64, String> {
        let since = ns - *self.first_ns.get_or_insert(ns);
        let since = i64::try_from(since).map_err(|_| "its time is centuries from the first row's".to_owned())?;
        if since < self.last_ns {
            return Err("its time is before that of the row in front; sort the rows by time".to_owned());
        }
        self.last_ns = since;
        Ok(since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::protocol::EXAMPLE;

    /// A description with time, labels, change points and a filter.
    const PROTOCOL: &str = r#"
name = "t"
title = "t"
channel = [{ name = "a", column = "A" }, { name = "b", column = "B" }, { name = "c", column = "3" }]
[data]
rate_hz = 4.0
time = "t"
where = [{ column = "phase", is = "run" }]
[learn]
rows = 2
[labels]
anomaly = "bad"
change_point = "cp"
"#;

    fn with_protocol(protocol: &str, text: &str) -> Result<Recorded, String> {
        read(&Protocol::from_toml("t.toml", protocol).unwrap(), text.as_bytes(), "t.csv".to_owned())
    }

    fn run(text: &str) -> Result<Recorded, String> {
        with_protocol(PROTOCOL, text)
    }

    #[test]
    fn rows_that_count_are_read_whole_with_their_time_and_labels() {
        let text = "A;B;C;t;phase;bad;cp\r\n\
                    1;2;3;2020-03-09 10:14:33;run;0;0\r\n\
                    9;9;9;2020-03-09 10:14:34;idle;1;1\r\n\
                    4;;6;2020-03-09 10:15:33.5;run;1.0;true\r\n";
        let run = run(text).unwrap();
        assert_eq!(run.at_ns, [0, 60_500_000_000]);
        assert_eq!(run.samples[0].x, [1.0, 2.0, 3.0]);
        assert!(run.samples[1].x[1].is_nan() && run.samples[1].x[2] == 6.0);
        assert_eq!((run.anomaly, run.change_point), (vec![false, true], vec![false, true]));
    }

    #[test]
    fn time_is_seconds_a_date_with_or_without_a_zone_or_the_row() {
        let at = |t: [&str; 2]| {
            let text = format!("A,B,C,t,phase,bad,cp\n1,2,3,{},run,0,0\n1,2,3,{},run,0,0\n", t[0], t[1]);
            run(&text).map(|run| run.at_ns[1])
        };
        assert_eq!(at(["0.1", "0.3"]), Ok(200_000_000));
        assert_eq!(at(["2020-03-09T10:00:00Z", "2020-03-09T12:00:01+02:00"]), Ok(1_000_000_000));
        let by_row = PROTOCOL.replace("time = \"t\"", "");
        let text = "A,B,C,t,phase,bad,cp\n1,2,3,x,idle,0,0\n1,2,3,x,run,0,0\n1,2,3,x,idle,0,0\n1,2,3,x,run,0,0\n";
        assert_eq!(with_protocol(&by_row, text).unwrap().at_ns, [0, 500_000_000]);
        assert!(at(["noon", "1"]).unwrap_err().contains("no time"));
        assert!(at(["2", "1"]).unwrap_err().contains("sort"));
    }

    #[test]
    fn a_file_that_does_not_fit_says_where_and_what_helps() {
        let head = "A,B,C,t,phase,bad,cp\n";
        let cases = [
            ("A,B,C,t,phase,cp\n1,2,3,0,run,0\n".to_owned(), "without labels"),
            ("A,C,t,phase,bad,cp\n".to_owned(), "`B`"),
            (format!("{head}1,2,3,0,run,,0\n"), "no label"),
            (format!("{head}1,2,3,0,run,nan,0\n"), "no label"),
            (format!("{head}1,2,x,0,run,0,0\n"), "`x` in column `C`"),
            (format!("{head}1,2,3,0,run,0\n"), "6 fields where the header has 7"),
            (format!("{head}1,2,3,0,idle,0,0\n"), "none of its 1 rows counts"),
            (String::new(), "empty"),
        ];
        for (text, word) in cases {
            let why = run(&text).unwrap_err();
            assert!(why.contains(word), "{text}\n{why}");
        }
    }

    #[test]
    fn the_stretch_to_learn_is_the_longest_one_at_one_set_point() {
        let samples = [1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0].map(|set_point| Sample { set_point, x: [0.0; 3] });
        let learnable = vec![true, true, true, true, true, false, true, true];
        let run = Recorded { samples: samples.to_vec(), learnable, ..Recorded::default() };
        assert_eq!(run.longest_stretch(0.0), (2, 5));
        assert_eq!(run.longest_stretch(1.0), (0, 5));
        assert_eq!(Recorded::default().longest_stretch(0.0), (0, 0));
    }

    #[test]
    fn the_example_describes_files_that_can_be_read() {
        let text = "time,speed set point,phase,supply,rpm,amps,volts,faulty,switched\n0,300,run 1,24,300,2,10,0,0\n";
        let run = with_protocol(&EXAMPLE.replace("delimiter = \";\"", "delimiter = \",\""), text).unwrap();
        assert_eq!((run.samples[0].set_point, run.samples[0].x), (300.0, [300.0, 2.0, 10.0]));
    }
}
