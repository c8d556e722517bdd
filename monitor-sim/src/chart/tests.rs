//! What a picture must show.

use super::*;

fn ramp(n: u32) -> Envelope {
    let mut envelope = Envelope::default();
    (0..n).for_each(|k| envelope.push(f64::from(k) * 0.001, f64::from(k % 1000)));
    envelope
}

fn axis() -> TimeAxis {
    let band = Band { from: 20.0, to: 40.0, label: "F1 <cord>".to_owned() };
    TimeAxis { range: (0.0, 140.0), scaled_from: 0.0, bands: vec![band], shaded: "true fault" }
}

fn chart(log_y: bool, signal: &Envelope) -> TimeChart<'_> {
    let series = vec![Series { name: "speed", signal }];
    TimeChart { name: "T²", unit: "1", log_y, series, limits: vec![], stacked: false }
}

/// The path of the only curve.
fn curve(svg: &str) -> &str {
    svg.split("class=\"curve s0\"").nth(1).and_then(|curve| curve.split(" d=\"").nth(1)?.split('"').next()).unwrap()
}

#[test]
fn a_chart_shows_its_series_its_limit_its_bands_and_its_units() {
    let signal = ramp(140_000);
    let chart = TimeChart { limits: vec![("threshold".to_owned(), 500.0)], ..chart(false, &signal) };
    let Picture { svg, legend } = time_chart(&chart, &axis());
    assert_eq!(svg.matches("class=\"curve s0\"").count(), 1, "one line for the series");
    assert_eq!(svg.matches("class=\"limit\"").count(), 1);
    assert_eq!(svg.matches("class=\"band\"").count(), 1);
    assert!(svg.contains(">time, s<") && svg.contains(">T², 1<"));
    assert!(svg.contains("F1 &lt;cord&gt;") && !svg.contains("<cord>"));
    assert_eq!(legend.len(), 3);
    assert!(svg.contains("aria-label=\"T², 1, over time: speed, threshold, true fault\""));
}

#[test]
fn a_chart_says_what_its_script_needs_to_draw_it_anew() {
    let signal = ramp(140_000);
    let svg = time_chart(&chart(false, &signal), &axis()).svg;
    let (picture, plot) = svg.split_once("<svg class=\"plot\"").unwrap();
    assert!(picture.contains("class=\"time\" data-from=\"0\" data-to=\"140\""));
    for said in [
        "data-name=\"T²\" data-unit=\"1\"",
        "data-low=\"-49.95\" data-high=\"1048.95\"",
        "data-name=\"F1 &lt;cord&gt;\" data-from=\"20\" data-to=\"40\"",
    ] {
        assert!(plot.contains(said), "{said}");
    }
    assert!(plot.contains("data-name=\"speed\" data-low=\"0\" data-span=\"999\" data-pieces=\"0 0.016 2 8750\""));
}

#[test]
fn a_picture_of_a_long_run_with_many_events_is_no_larger_than_one_of_a_short_run() {
    let mut signal = Envelope::default();
    for k in 0..3_000_000 {
        signal.push(f64::from(k) * 0.001, f64::from(k % 1000));
        if k % 5000 == 0 {
            signal.mark();
        }
    }
    let axis = TimeAxis { range: (0.0, 3000.0), ..axis() };
    let svg = time_chart(&chart(false, &signal), &axis).svg;
    assert!(svg.len() < 190_000, "{} bytes", svg.len());
}

#[test]
fn curves_are_drawn_between_pixels_where_the_samples_lie() {
    let mut signal = Envelope::default();
    (0..=140).for_each(|k| signal.push(f64::from(k), f64::from(k % 2)));
    // 832 pixels hold 140 s: six each, and not quite.
    assert!(curve(&time_chart(&chart(false, &signal), &axis()).svg).starts_with("M0 198.5L5.9 9.5L11.9 198.5"));
}

#[test]
fn names_of_what_is_shaded_never_lie_on_each_other_or_leave_the_picture() {
    let band = |from, to, label: &str| Band { from, to, label: label.to_owned() };
    let bands = vec![band(0.0, 1.0, "the first"), band(1.0, 2.0, "the second"), band(139.0, 140.0, &"long ".repeat(9))];
    let axis = TimeAxis { bands, ..axis() };
    let svg = logic_chart(&[], &axis).svg;
    let names: Vec<&str> = svg.split("<text").skip(1).filter(|text| text.contains("data-from")).collect();
    let hidden: Vec<bool> = names.iter().map(|name| name.contains("visibility=\"hidden\"")).collect();
    assert_eq!(hidden, [false, true, false]);
    assert!(names[2].contains(" x=\"820\""), "{}", names[2]);
}

#[test]
fn a_gap_breaks_a_line_in_two() {
    let mut signal = Envelope::default();
    [1.0, 2.0, f64::NAN, 3.0, 4.0].iter().enumerate().for_each(|(k, y)| signal.push(k as f64, *y));
    let axis = TimeAxis { range: (0.0, 5.0), scaled_from: 0.0, bands: vec![], shaded: "" };
    assert_eq!(curve(&time_chart(&chart(true, &signal), &axis).svg).matches('M').count(), 2);
}

#[test]
fn nothing_to_draw_is_drawn_without_failing() {
    let empty = Envelope::default();
    let nothing = TimeAxis { range: (0.0, 0.0), scaled_from: 0.0, bands: vec![], shaded: "" };
    for picture in [
        time_chart(&chart(false, &empty), &axis()),
        time_chart(&chart(true, &empty), &nothing),
        logic_chart(&[], &nothing),
        bar_chart(&[], &[], "share", Some(("80 %", 80.0))),
    ] {
        assert!(
            picture.svg.starts_with("<svg") && !picture.svg.contains("NaN\"") && !picture.svg.contains("inf"),
            "{}",
            picture.svg
        );
    }
}

#[test]
fn every_interval_is_drawn_and_those_closer_than_a_pixel_as_one() {
    let intervals = vec![(1.0, 2.0), (2.001, 3.0), (50.0, 60.0)];
    let svg = logic_chart(&[LogicRow { name: "r1".to_owned(), colour: 0, intervals }], &axis()).svg;
    let row = svg.split("class=\"solid s0\"").nth(1).unwrap();
    assert_eq!(row.split(" d=\"").nth(1).unwrap().split('"').next().unwrap().matches('M').count(), 2);
    assert!(row.contains("data-name=\"r1\" data-spans=\"1 2 2.001 3 50 60\""), "the script is told each");
    assert!(svg.contains(">r1</text>"));
}

#[test]
fn bars_carry_their_values_and_the_criterion_is_drawn() {
    let groups = [BarGroup { name: "all".to_owned(), values: vec![60.0, 30.0, 10.0] }];
    let bars = ["first", "second", "third"].map(str::to_owned);
    let Picture { svg, legend } = bar_chart(&groups, &bars, "share", Some(("80 % criterion", 80.0)));
    assert!(svg.contains(">60.0<") && svg.contains(">10.0<") && svg.matches("class=\"solid").count() == 3);
    assert!(svg.contains("aria-label=\"share, %. all: first 60.0, second 30.0, third 10.0\""));
    assert_eq!(legend.last().map(|(s, n)| (*s, n.as_str())), Some((Swatch::Limit, "80 % criterion")));
}

#[test]
fn every_colour_has_a_value_in_light_dark_and_print() {
    for variable in ["--ink", "--on", "--grid", "--band", "--limit", "--s0", "--s1", "--s2", "--s3"] {
        assert_eq!(STYLE.matches(&format!("{variable}:")).count(), 3, "{variable}");
        assert!(STYLE.contains(&format!("var({variable})")), "{variable}");
    }
}
