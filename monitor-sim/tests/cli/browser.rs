//! The page in a real browser. What a reader does with it is in `browser.js`; each test looks at what came of it.

use std::env;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

use assert_cmd::Command;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::desk::{Desk, SHORT};

/// What came of it.
#[derive(Deserialize)]
struct Seen {
    pictures: Vec<PictureSeen>,
    linked: [f64; 2],
    whole: [f64; 2],
    drawn: Vec<f64>,
    events: Vec<f64>,
    visited: [f64; 2],
    zoomed: usize,
    told: Option<Vec<String>>,
    escaped: Option<Vec<String>>,
    hovered: Option<Vec<String>>,
    crosses: Vec<String>,
    stepped: Option<Vec<String>>,
    left: Option<Vec<String>>,
    nearer: [f64; 2],
    further: [f64; 2],
    dragged: [f64; 2],
    pinched: [f64; 2],
    panned: [f64; 2],
    narrow: Narrow,
    printed: Printed,
    /// What the console said, and the trace of the same run.
    #[serde(skip)]
    console: String,
    #[serde(skip)]
    trace: String,
}

#[derive(Deserialize)]
struct PictureSeen {
    alternative: String,
    width: f64,
    drawn: bool,
    /// Texts that lie on another or reach out of the picture.
    crowded: Vec<String>,
}

#[derive(Deserialize)]
struct Narrow {
    letters: f64,
    scrolls: bool,
    points: usize,
}

#[derive(Deserialize)]
struct Printed {
    view: [f64; 2],
    points: usize,
    read: Option<Vec<String>>,
    unfolded: bool,
}

/// Chromium, if there is one.
fn browser() -> Option<PathBuf> {
    let given = env::var_os("CHROMIUM").filter(|path| !path.is_empty()).map(PathBuf::from);
    given.or_else(|| {
        let directories: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
        let named = ["chromium", "chromium-browser", "google-chrome"].into_iter();
        named.flat_map(|name| directories.iter().map(move |d| d.join(name))).find(|path| path.is_file())
    })
}

/// Opens a page of the desk at a `place` of it and runs `script` there; returns what it reports, and what the console said.
fn used<T: DeserializeOwned>(browser: &Path, desk: &Desk, (page, place): (&str, &str), script: &str) -> (T, String) {
    let script = format!("<script>{}{script}</script></body>", include_str!("pictures.js"));
    desk.write("used.html", desk.read(page).replace("</body>", &script));
    let output = Command::new(browser)
        .args(["--headless", "--disable-gpu", "--no-sandbox", "--enable-logging=stderr", "--v=0", "--dump-dom"])
        .arg("--window-size=1200,900")
        .arg(format!("--user-data-dir={}", desk.path("profile").display()))
        .arg(format!("file://{}{place}", desk.path("used.html").display()))
        .timeout(Duration::from_secs(120))
        .output()
        .unwrap();
    let document = String::from_utf8_lossy(&output.stdout);
    let console: Vec<String> = String::from_utf8_lossy(&output.stderr)
        .lines()
        .filter(|line| line.contains("CONSOLE"))
        .map(str::to_owned)
        .collect();
    let found = document.split("<pre id=\"seen\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let found = found.unwrap_or_else(|| panic!("nothing came of it: {console:?}"));
    (serde_json::from_str(found).unwrap(), console.join("\n"))
}

/// The page of a mission, opened at its fifth event and used; none without a browser. It is so long that a bin of a curve holds
/// several samples.
static SEEN: LazyLock<Option<Seen>> = LazyLock::new(|| {
    let Some(browser) = browser() else {
        // Not by a macro, whose output the test harness would keep to itself.
        let _ = writeln!(
            std::io::stderr(),
            "skipped: no browser to try the page in; install Chromium, or name one by CHROMIUM=PATH"
        );
        return None;
    };
    let desk = Desk::with("long.toml", &SHORT.replace("duration_s = 30.0", "duration_s = 70.0"));
    desk.run("--scenario long.toml").success();
    let page = ("monitor-out/mission.html", "#event=5");
    let (seen, console): (Seen, _) = used(&browser, &desk, page, include_str!("browser.js"));
    Some(Seen { console, trace: desk.read("monitor-out/trace.csv"), ..seen })
});

fn width([from, to]: [f64; 2]) -> f64 {
    to - from
}

/// Views are told to the last bit, and pixels are not.
fn close(found: [f64; 2], expected: [f64; 2]) -> bool {
    found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02)
}

#[test]
fn the_page_opens_without_a_word_on_the_console_and_every_picture_is_there() {
    let Some(seen) = &*SEEN else { return };
    assert_eq!(seen.console, "");
    assert!(seen.pictures.len() >= 19, "{}", seen.pictures.len());
    assert_pictured(&seen.pictures);
}

fn assert_pictured(pictures: &[PictureSeen]) {
    for PictureSeen { alternative, width, drawn, crowded } in pictures {
        assert!(*width >= 800.0 && *drawn && !alternative.is_empty(), "{alternative:?} is {width} wide");
        assert!(crowded.is_empty(), "no room for {crowded:?} in {alternative:?}");
    }
}

#[test]
fn every_picture_of_a_study_is_there_and_no_text_in_it_lies_on_another() {
    let Some(browser) = browser() else { return };
    let desk = Desk::new();
    for (study, pictures) in [
        ("false-alarms --motors 2 --hours 0.01", 1),
        ("delay --seeds 1 --sizes 1,2", 3),
        ("ramp --seeds 2", 1),
        ("localization --motors 2", 2),
        ("robustness --motors 1 --healthy 10", 3),
        ("tune --runs 2", 1),
        ("speed --steps 1000", 2),
    ] {
        desk.run(&format!("study {study} --page page.html")).success();
        let (seen, console): (Vec<PictureSeen>, _) =
            used(&browser, &desk, ("page.html", ""), "report(picturesSeen());");
        assert_eq!((console.as_str(), seen.len()), ("", pictures), "{study}");
        assert_pictured(&seen);
    }
}

#[test]
fn a_link_to_an_event_and_the_events_button_show_where_it_was() {
    let Some(seen) = &*SEEN else { return };
    assert_eq!(seen.whole, [0.0, 70.0]);
    let around = |view: [f64; 2], event: f64| view[0] < event && event < view[1] && width(view) < 3.01;
    // A third of the view lies before it: a second.
    assert!(close(seen.linked, [seen.events[4] - 1.0, seen.events[4] + 2.0]), "{:?}", seen.linked);
    assert!(around(seen.visited, seen.events[0]), "{:?}", seen.visited);
    let told = seen.told.as_ref().unwrap();
    assert_eq!(told[0], format!("{:.3} s", seen.events[0]));
    assert!(told.last().unwrap().contains("alarm"), "{told:?}");
}

#[test]
fn a_zoomed_curve_has_more_points_than_the_same_stretch_of_the_drawn_one() {
    let Some(seen) = &*SEEN else { return };
    let pixels = seen.visited.map(|t_s| 832.0 * t_s / 70.0);
    let before = seen.drawn.iter().filter(|x| (pixels[0]..pixels[1]).contains(x)).count();
    assert!(before > 10 && seen.zoomed > 15 * before, "{before} became {}", seen.zoomed);
}

/// Of the instant it was read at, each name with its unit has the value of the trace's column.
fn assert_reads(read: &[String], columns: &[(&str, &str, &str)], trace: &str) {
    let mut trace = csv::Reader::from_reader(trace.as_bytes());
    let header = trace.headers().unwrap().clone();
    let instant = read[0].trim_end_matches(" s");
    let row = trace.records().map(Result::unwrap).find(|row| row[1].starts_with(instant)).unwrap();
    for (name, unit, column) in columns {
        let text = read.iter().find_map(|text| text.strip_prefix(name)?.strip_suffix(unit)).unwrap();
        let shown: f64 = text.trim().parse().unwrap();
        let traced: f64 = row[header.iter().position(|found| found == *column).unwrap()].parse().unwrap();
        // Four digits.
        assert!((shown - traced).abs() <= 6e-4 * traced.abs(), "{name}: {shown} is {traced}");
    }
}

#[test]
fn the_cross_hair_reads_what_the_trace_has_and_is_hidden_otherwise() {
    let Some(seen) = &*SEEN else { return };
    let hovered = seen.hovered.as_ref().unwrap();
    let channels = [
        ("speed set point", "rad/s", "set_point"),
        ("speed measured", "rad/s", "speed"),
        ("current", "A", "current"),
        ("voltage", "V", "voltage"),
    ];
    assert_reads(hovered, &channels, &seen.trace);
    assert_reads(seen.told.as_ref().unwrap(), &[("fast: T²/limit", "", "severity_fast")], &seen.trace);
    let places: Vec<_> = seen.crosses.iter().map(|cross| cross.split(' ').next().unwrap()).collect();
    assert!(places.len() >= 19 && places.iter().all(|x| *x == "M499.2"), "{places:?}");
    assert!(seen.stepped.as_ref().unwrap()[0] > hovered[0], "the keyboard moves it");
    assert!(seen.left.is_none() && seen.escaped.is_none());
}

#[test]
fn keys_the_mouse_and_fingers_change_the_view() {
    let Some(seen) = &*SEEN else { return };
    assert!((width(seen.nearer) - width(seen.visited) / 2.0).abs() < 1e-9, "{:?}", seen.nearer);
    assert!(seen.further[0] > seen.nearer[0] && (width(seen.further) - width(seen.nearer)).abs() < 1e-9);
    assert!(close(seen.dragged, [17.5, 35.0]), "{:?}", seen.dragged);
    // What was under the fingers at 0.4 and 0.6 of 70 s is under them at 0.2 and 0.8: 14 s are as wide as 0.6 of the picture.
    assert!(close(seen.pinched, [23.33, 46.67]), "{:?}", seen.pinched);
    assert!(close(seen.panned, [21.0, 44.33]), "{:?}", seen.panned);
}

#[test]
fn in_a_narrow_window_pictures_get_narrower_and_letters_stay_legible() {
    let Some(Seen { narrow, .. }) = &*SEEN else { return };
    assert!(
        narrow.letters > 11.0 && !narrow.scrolls && (300..800).contains(&narrow.points),
        "{} {}",
        narrow.letters,
        narrow.points
    );
}

#[test]
fn on_paper_the_page_stands_as_it_was_drawn() {
    let Some(seen) = &*SEEN else { return };
    assert_eq!((seen.printed.view, seen.printed.points), ([0.0, 70.0], seen.drawn.len()));
    assert!(seen.printed.read.is_none() && seen.printed.unfolded);
}
