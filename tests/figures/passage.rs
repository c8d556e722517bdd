//! Finds a statement of a document, reads its numbers, and says or writes what they are now.
//!
//! A statement is looked for by its words, with `{}` where a value stands and `…` where anything may: line breaks do not
//! matter. A number is compared to the digits that the document shows.

use std::ops::Range;

/// The longest value, and the longest stretch that is skipped, in bytes.
const LONGEST_VALUE: usize = 100;
const LONGEST_SKIP: usize = 600;

/// A value that a document states.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number, rounded to the nearest; none where there is no such number.
    About(Option<f64>),
    /// A number that is not exceeded: rounded upwards.
    AtMost(f64),
    /// A number that is reached: rounded downwards.
    AtLeast(f64),
    /// Words, such as a command.
    Words(String),
}

/// A value that the document states otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stale {
    /// Where it stands.
    pub place: Range<usize>,
    /// What should stand there.
    pub now: String,
}

impl Value {
    fn is_wanting(&self) -> bool {
        match self {
            Self::Words(words) => words.is_empty(),
            Self::About(x) => x.is_some_and(|x| !x.is_finite()),
            Self::AtMost(x) | Self::AtLeast(x) => !x.is_finite(),
        }
    }

    /// In the form in which the document shows it.
    fn shown_like(&self, said: &str) -> String {
        match self {
            Self::Words(words) => words.clone(),
            Self::About(None) => "none".to_owned(),
            Self::About(Some(x)) => number(*x, said, f64::round),
            Self::AtMost(x) => number(*x, said, f64::ceil),
            Self::AtLeast(x) => number(*x, said, f64::floor),
        }
    }
}

/// A number with the decimals of another one.
fn number(x: f64, like: &str, round: fn(f64) -> f64) -> String {
    let decimals = if like.parse::<f64>().is_ok() || like.contains(',') {
        like.split_once('.').map_or(0, |(_, decimals)| decimals.len())
    } else {
        // The document has no number here.
        (1.0 - x.abs().log10().floor()).clamp(0.0, 9.0) as usize
    };
    let scale = 10_f64.powi(i32::try_from(decimals).unwrap_or_default());
    // What lies within the last bits of a rounded number is that number.
    let exact = (x * scale * 1e6).round() / 1e6;
    let text = format!("{:.decimals$}", round(exact) / scale);
    let (whole, rest) = text.split_at(text.find('.').unwrap_or(text.len()));
    grouped(whole) + rest
}

/// Thousands apart.
fn grouped(whole: &str) -> String {
    let (sign, digits) = whole.split_at(usize::from(whole.starts_with('-')));
    let groups: Vec<String> = digits.as_bytes().rchunks(3).rev().map(|g| String::from_utf8_lossy(g).into()).collect();
    format!("{sign}{}", groups.join(","))
}

/// The document with each stretch of blanks as one blank, and where each byte of that came from.
fn flattened(text: &str) -> (String, Vec<usize>) {
    let (mut flat, mut places) = (String::new(), Vec::new());
    for (place, c) in text.char_indices() {
        let c = if c.is_whitespace() { ' ' } else { c };
        if c == ' ' && flat.ends_with(' ') {
            continue;
        }
        flat.push(c);
        places.extend((place..).take(c.len_utf8()));
    }
    places.push(text.len());
    (flat, places)
}

/// A piece of a statement: words, and what stands behind them.
struct Piece<'a> {
    words: &'a str,
    is_value: bool,
}

fn pieces(statement: &str) -> (Vec<Piece<'_>>, &str) {
    let (mut pieces, mut rest) = (Vec::new(), statement);
    while let Some(at) = [rest.find("{}"), rest.find('…')].into_iter().flatten().min() {
        let is_value = rest[at..].starts_with("{}");
        pieces.push(Piece { words: &rest[..at], is_value });
        rest = &rest[at + if is_value { 2 } else { '…'.len_utf8() }..];
    }
    (pieces, rest)
}

/// Where the values of a statement stand in a document.
///
/// # Errors
/// The document does not say so, or does so more than once.
fn places(document: &str, statement: &str) -> Result<Vec<Range<usize>>, String> {
    let (flat, origin) = flattened(document);
    let (pieces, last) = pieces(statement);
    let first = pieces.first().map_or(last, |piece| piece.words);
    let found: Vec<Vec<Range<usize>>> =
        flat.match_indices(first).filter_map(|(at, _)| matched(&flat, at + first.len(), &pieces, last)).collect();
    match &found[..] {
        [values] => Ok(values.iter().map(|value| origin[value.start]..origin[value.end - 1] + 1).collect()),
        [] => Err(format!("no longer says: {statement}")),
        _ => Err(format!("says more than once: {statement}")),
    }
}

/// The values of a statement whose first words end at `from`.
fn matched(flat: &str, mut from: usize, pieces: &[Piece<'_>], last: &str) -> Option<Vec<Range<usize>>> {
    let mut values = Vec::new();
    for (n, piece) in pieces.iter().enumerate() {
        let next = pieces.get(n + 1).map_or(last, |piece| piece.words);
        let length = flat[from..].find(next)?;
        let longest = if piece.is_value { LONGEST_VALUE } else { LONGEST_SKIP };
        if length == 0 || length > longest {
            return None;
        }
        if piece.is_value {
            // What stands in code marks is a value or holds none: it does not reach from one command into the next.
            if flat[from..from + length].contains('`') {
                return None;
            }
            values.push(from..from + length);
        }
        from += length + next.len();
    }
    Some(values)
}

/// The values that a document states otherwise.
///
/// # Errors
/// The document does not make the statement, or not with so many values.
pub fn stale(document: &str, statement: &str, values: &[Value]) -> Result<Vec<Stale>, String> {
    let places = places(document, statement)?;
    if places.len() != values.len() {
        return Err(format!("{} values are recorded for: {statement}", values.len()));
    }
    if values.iter().any(Value::is_wanting) {
        return Err(format!("states what no record has: {statement}"));
    }
    let judged = places.into_iter().zip(values).filter_map(|(place, value)| {
        let said = &document[place.clone()];
        let now = value.shown_like(said);
        (now.replace(',', "") != said.replace(',', "")).then_some(Stale { place, now })
    });
    Ok(judged.collect())
}

/// The table of a document that begins with these words, line for line as it was printed, or what differs.
///
/// # Errors
/// One of both has no such table.
pub fn stale_table(document: &str, begins: &str, printed: &[String]) -> Result<Vec<Stale>, String> {
    let is_head = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ").starts_with(begins);
    let printed = printed.iter().skip_while(|line| !is_head(line));
    let mut place = 0;
    let mut lines = Vec::new();
    for line in document.split_inclusive('\n') {
        let shown = line.trim_end();
        if !lines.is_empty() && !shown.starts_with([' ', '─']) {
            break;
        }
        if !lines.is_empty() || (line.starts_with(' ') && is_head(line)) {
            lines.push(place..place + shown.len());
        }
        place += line.len();
    }
    let printed: Vec<&String> = printed.take(lines.len()).collect();
    if lines.is_empty() || lines.len() != printed.len() {
        return Err(format!("no longer has the whole table that begins with: {begins}"));
    }
    let judged = lines.into_iter().zip(printed).filter(|(place, now)| document[place.clone()] != ***now);
    Ok(judged.map(|(place, now)| Stale { place, now: now.clone() }).collect())
}

/// The document with what should stand there.
#[must_use]
pub fn mended(document: &str, stale: &[Stale]) -> String {
    let mut stale: Vec<&Stale> = stale.iter().collect();
    stale.sort_by_key(|stale| stale.place.start);
    let (mut text, mut from) = (String::new(), 0);
    for Stale { place, now } in stale {
        text += &document[from..place.start];
        text += now;
        from = place.end;
    }
    text + &document[from..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use Value::{About, AtLeast, AtMost, Words};

    const DOCUMENT: &str = "First.\n- `study x`: 19 alarms in\n  100 hours, of 2,250, at most\n  0.87 s.\n";

    fn now(statement: &str, values: &[Value]) -> String {
        mended(DOCUMENT, &stale(DOCUMENT, statement, values).unwrap())
    }

    #[test]
    fn a_number_is_compared_to_the_digits_that_are_shown() {
        let statement = "{} alarms in {} hours, of {}, at most {} s.";
        let statement = &format!("`study x`: {statement}");
        let holds = [About(Some(19.4)), About(Some(100.2)), About(Some(2250.0)), AtMost(0.8613)];
        assert_eq!(stale(DOCUMENT, statement, &holds), Ok(vec![]));
        let moved = [About(Some(20.0)), About(None), About(Some(12_345.0)), AtMost(0.8701)];
        let mended =
            DOCUMENT.replace("19", "20").replace("100", "none").replace("2,250", "12,345").replace("0.87", "0.88");
        assert_eq!(now(statement, &moved), mended);
    }

    #[test]
    fn bounds_are_rounded_to_the_side_on_which_they_hold() {
        assert_eq!(AtMost(0.1 + 0.2).shown_like("0.3"), "0.3");
        assert_eq!((AtMost(0.301).shown_like("0.3"), AtLeast(99.69).shown_like("99.6")), ("0.4".into(), "99.6".into()));
        assert_eq!(About(Some(1.447)).shown_like("none"), "1.4");
    }

    #[test]
    fn words_are_found_across_lines_and_must_be_there_once() {
        let of = |statement: &str| stale(DOCUMENT, statement, &[Words("study y".to_owned())]);
        assert_eq!(of("- `{}`: … hours, of").unwrap()[0].now, "study y");
        assert!(of("- `{}`: … minutes").unwrap_err().contains("no longer says"));
        assert!(of("{}, of").unwrap_err().contains("more than once"));
        assert!(of("19 alarms in 100 hours").unwrap_err().contains("1 values"));
    }

    #[test]
    fn a_table_is_compared_line_for_line_below_its_head() {
        let document = "```text\n a   b\n───────\n 1   2\n```\n";
        let printed = [" other".to_owned(), " a   b".to_owned(), "───────".to_owned(), " 1   3".to_owned()];
        assert_eq!(mended(document, &stale_table(document, "a b", &printed).unwrap()), document.replace('2', "3"));
        assert!(stale_table(document, "a b", &printed[..3]).is_err());
    }
}
