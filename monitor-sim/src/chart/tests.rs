//! What a picture must show.

use super::ordinate::tick;
use super::*;

fn ramp(n: u32) -> Envelope {
    let mut envelope = Envelope::default();
    (0..n).for_each(|k| envelope.push(f64::from(k) * 0.001, f64::from(k % 1000)));
    envelope
}

fn axis() -> TimeAxis {
    let band = Band { from: 20.0, to: 40.0, label: "F1 <cord>".to_owned() };
    TimeAxis { range: (0.0, 140.0), scaled_from: 0.0, bands: vec![band] }
}

#[test]
fn a_chart_shows_its_series_its_limit_its_bands_and_its_units() {
    let signal = ramp(140_000);
    let series = vec![Series { name: "speed", signal: &signal }];
    let limits = vec![("threshold".to_owned(), 500.0)];
    let chart = TimeChart { y_label: "T², 1", log_y: false, series, limits, stacked: false };
    let Picture { svg, legend } = time_chart(&chart, &axis()).unwrap();
    assert_eq!(svg.matches("stroke=\"#0B0B0B\"").count(), 1, "one line for the series");
    assert!(svg.contains("stroke=\"#040404\""), "the limit");
    assert!(svg.contains("fill=\"#030303\""), "the band");
    assert!(svg.contains("time, s") && svg.contains("T², 1"));
    assert!(svg.contains("F1 &lt;cord&gt;") && !svg.contains("<cord>"));
    assert_eq!(legend.len(), 3);
    assert!(svg.starts_with("<svg viewBox=\"0 0 1000 280\" data-time=\"0 140\" data-bottom=\"48\""));
}

#[test]
fn a_gap_breaks_a_line_in_two() {
    let mut signal = Envelope::default();
    [1.0, 2.0, f64::NAN, 3.0, 4.0].iter().enumerate().for_each(|(k, y)| signal.push(k as f64, *y));
    let chart = TimeChart {
        y_label: "y",
        log_y: true,
        series: vec![Series { name: "s", signal: &signal }],
        limits: vec![],
        stacked: false,
    };
    let svg = time_chart(&chart, &TimeAxis { range: (0.0, 5.0), scaled_from: 0.0, bands: vec![] }).unwrap().svg;
    assert_eq!(svg.matches("stroke=\"#0B0B0B\"").count(), 2);
}

#[test]
fn nothing_to_draw_is_drawn_without_failing() {
    let empty = Envelope::default();
    for log_y in [false, true] {
        let chart = TimeChart {
            y_label: "y",
            log_y,
            series: vec![Series { name: "s", signal: &empty }],
            limits: vec![],
            stacked: false,
        };
        assert!(time_chart(&chart, &axis()).is_ok());
    }
    assert!(logic_chart(&[], &axis()).is_ok());
    assert!(bar_chart(&[], "share, %", ("80 %", 80.0)).is_ok());
}

#[test]
fn every_interval_is_drawn_and_those_closer_than_a_pixel_as_one() {
    let rows =
        vec![LogicRow { name: "r1".to_owned(), colour: 0, intervals: vec![(1.0, 2.0), (2.001, 3.0), (50.0, 60.0)] }];
    let svg = logic_chart(&rows, &axis()).unwrap().svg;
    assert_eq!(svg.matches("fill=\"#0B0B0B\"").count(), 2);
    assert!(svg.contains("r1"));
}

#[test]
fn bars_carry_their_values_and_the_criterion_is_drawn() {
    let groups = vec![BarGroup { name: "all".to_owned(), values: vec![60.0, 30.0, 10.0] }];
    let Picture { svg, legend } = bar_chart(&groups, "share, %", ("80 % criterion", 80.0)).unwrap();
    assert!(svg.contains("60.0") && svg.contains("10.0"));
    assert_eq!(legend.last().map(|(s, n)| (*s, n.as_str())), Some((Swatch::Limit, "80 % criterion")));
}

#[test]
fn every_marker_colour_has_a_rule_in_the_style_sheet() {
    for colour in SERIES.iter().chain([&INK, &LIMIT]) {
        let hex = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
        assert!(STYLE.contains(&format!("stroke=\"{hex}\"")) && STYLE.contains(&format!("fill=\"{hex}\"")), "{hex}");
    }
    for variable in ["--ink", "--grid", "--band", "--limit", "--s0", "--s1", "--s2", "--s3"] {
        assert_eq!(STYLE.matches(&format!("{variable}:")).count(), 3, "{variable} in light, dark and print");
    }
}

#[test]
fn ticks_read_as_a_person_writes_them() {
    assert_eq!([0.0, 0.1 + 0.2, 300.0, -0.05].map(|v| tick(v, false)), ["0", "0.3", "300", "-0.05"]);
    assert_eq!([1e-3, 0.01, 10.0, 1e6].map(|v| tick(v, true)), ["1e-3", "0.01", "10", "1e6"]);
}
