//! Signals as the page's script reads them: numbers of three characters each.

use std::fmt::Write as _;

use super::scale::Scale;
use crate::envelope::Envelope;

/// Characters from here on are digits of six bits: none of them means anything in HTML.
const ZERO: u8 = b'?';
/// The largest code stands for a gap.
const GAP: u32 = (1 << 18) - 1;

/// The attributes that hold a signal: the ends of what its codes stand for, on the axis `scale`; where its pieces begin, how far
/// apart their values are, how many codes a value has (a second one where least and greatest differ), and how many values
/// there are; and the codes.
pub(super) fn attributes(signal: &Envelope, scale: Scale) -> String {
    let pieces = signal.pieces();
    let values = || pieces.iter().flat_map(|piece| &piece.values).filter(|(least, _)| !least.is_nan());
    let low = values().map(|(least, _)| scale.place(*least)).fold(f64::INFINITY, f64::min);
    let high = values().map(|(_, greatest)| scale.place(*greatest)).fold(f64::NEG_INFINITY, f64::max);
    // A constant is its own low end; without a number there are no codes but gaps.
    let (low, span) = if low <= high { (low, high - low) } else { (0.0, 0.0) };
    let code = |value: f64| {
        let share = if span > 0.0 { (scale.place(value) - low) / span } else { 0.0 };
        if value.is_nan() { GAP } else { (share * f64::from(GAP - 1)).round() as u32 }
    };
    let (mut stretches, mut codes) = (String::new(), String::new());
    for piece in &pieces {
        let paired = piece.values.iter().any(|(least, greatest)| least < greatest);
        let _ = write!(stretches, "{} {} {} {};", piece.from, piece.step, 1 + u8::from(paired), piece.values.len());
        for (least, greatest) in &piece.values {
            push(&mut codes, code(*least));
            if paired {
                push(&mut codes, code(*greatest));
            }
        }
    }
    let stretches = stretches.trim_end_matches(';');
    format!("data-low=\"{low}\" data-span=\"{span}\" data-pieces=\"{stretches}\" data-codes=\"{codes}\"")
}

fn push(codes: &mut String, code: u32) {
    codes.extend([12, 6, 0].map(|shift| char::from(ZERO + (code >> shift & 63) as u8)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn attribute<'a>(attributes: &'a str, name: &str) -> &'a str {
        attributes.split(&format!("{name}=\"")).nth(1).and_then(|rest| rest.split('"').next()).unwrap()
    }

    /// What the script makes of the attributes.
    fn read(attributes: &str) -> Vec<f64> {
        let number = |name| attribute(attributes, name).parse::<f64>().unwrap();
        let (low, span) = (number("data-low"), number("data-span"));
        let digit = |c: &u8| u32::from(c - ZERO);
        let codes = attribute(attributes, "data-codes").as_bytes().chunks(3);
        let code = codes.map(|three| three.iter().fold(0, |code, c| code << 6 | digit(c)));
        code.map(|code| if code == GAP { f64::NAN } else { low + span * f64::from(code) / f64::from(GAP - 1) })
            .collect()
    }

    fn signal(values: &[f64]) -> Envelope {
        let mut signal = Envelope::default();
        values.iter().enumerate().for_each(|(k, y)| signal.push(k as f64, *y));
        signal
    }

    #[test]
    fn a_constant_and_a_gap_are_read_back() {
        let attributes = attributes(&signal(&[3.0, f64::NAN, 3.0]), Scale::linear(0.0, 5.0));
        assert_eq!(attribute(&attributes, "data-pieces"), "0 1 1 3");
        let read = read(&attributes);
        assert!(read[0] == 3.0 && read[1].is_nan() && read[2] == 3.0, "{read:?}");
    }

    #[test]
    fn of_a_logarithmic_axis_the_logarithms_are_written() {
        let read = read(&attributes(&signal(&[1.0, 100.0, 1e4]), Scale::decades(1.0, 1e4)));
        assert!(read.iter().zip([0.0, 2.0, 4.0]).all(|(read, y)| (read - y).abs() < 1e-5), "{read:?}");
    }

    #[test]
    fn the_script_reads_the_digits_that_are_written() {
        let script = include_str!("../page/signal.js");
        assert!(script.contains(&format!("charCodeAt(at) - {ZERO}")) && script.contains("gap = 2 ** 18 - 1"));
    }

    #[test]
    fn what_has_no_logarithm_does_not_blur_what_has_one() {
        let read = read(&attributes(&signal(&[-1.0, 0.0, 1e-300, 2.0]), Scale::decades(0.1, 10.0)));
        assert_eq!(read[..3], [-7.0; 3]);
        assert!((read[3] - 2_f64.log10()).abs() < 1e-4, "{read:?}");
    }

    proptest! {
        #[test]
        fn any_value_is_read_back_to_a_250_000th_of_the_range(values in prop::collection::vec(-1e3..1e3_f64, 1..200)) {
            let attributes = attributes(&signal(&values), Scale::linear(0.0, 1.0));
            let tolerance = 2e3 / 250_000.0;
            prop_assert!(values.iter().zip(read(&attributes)).all(|(y, read)| (y - read).abs() < tolerance));
            prop_assert!(!attributes.split("data-codes=\"").nth(1).unwrap().trim_end_matches('"').contains(['<', '&', '"']));
        }
    }
}
