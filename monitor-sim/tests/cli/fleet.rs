//! What a replay of several logs says and writes.

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use parquet::data_type::DoubleType;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::Field;
use parquet::schema::parser::parse_message_type;
use serde_json::Value;

use crate::desk::{Desk, GUARD, MOTOR, SAMPLE, first_rows, healthy};

const CONSTANTS: &str = "--resistance 0.33 --torque-constant 0.0275 --load-slope 0";

/// A log of text as Parquet, every column of it as DOUBLE.
fn write_parquet(path: &Path, text: &str) {
    let mut csv = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = csv.headers().unwrap().iter().map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> =
        csv.records().map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect()).collect();
    let fields: String = names.iter().map(|name| format!("REQUIRED DOUBLE {name};")).collect();
    let schema = Arc::new(parse_message_type(&format!("message log {{ {fields} }}")).unwrap());
    let mut file = SerializedFileWriter::new(File::create(path).unwrap(), schema, Arc::default()).unwrap();
    for group in rows.chunks(1000) {
        let mut writer = file.next_row_group().unwrap();
        for position in 0..names.len() {
            let values: Vec<f64> = group.iter().map(|row| row[position]).collect();
            let mut column = writer.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
        }
        writer.close().unwrap();
    }
    file.close().unwrap();
}

/// The cells of a summary in Parquet as they would be written in CSV, under the names of its columns.
fn parquet_cells(path: &Path) -> Vec<Vec<String>> {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let names = schema.columns().iter().map(|column| column.name().to_owned()).collect();
    let cell = |field: &Field| match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        Field::Long(number) => number.to_string(),
        Field::Double(number) => number.to_string(),
        other => panic!("{other:?}"),
    };
    let rows = reader.get_row_iter(None).unwrap();
    let rows = rows.map(|row| row.unwrap().get_column_iter().map(|(_, field)| cell(field)).collect());
    std::iter::once(names).chain(rows).collect()
}

fn csv_cells(path: &Path) -> Vec<Vec<String>> {
    let mut csv = csv::ReaderBuilder::new().has_headers(false).from_path(path).unwrap();
    csv.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

/// A row of a report, by the log's name.
fn row<'a>(report: &'a Value, log: &str) -> &'a Value {
    let rows = report["logs"].as_array().unwrap();
    rows.iter().find(|row| row["file"] == log).unwrap_or_else(|| panic!("no {log} in {report}"))
}

fn three() -> Desk {
    let desk = Desk::with("faulty.csv", SAMPLE);
    desk.write("healthy.csv", healthy());
    desk.write("broken.csv", first_rows(1600) + "noon,300,299,abc,9\n32.02,300,299,2,9\n");
    desk
}

#[test]
fn a_broken_log_is_a_row_with_its_error_and_does_not_stop_the_others() {
    let desk = three();
    let report =
        desk.json(&format!("replay broken.csv faulty.csv healthy.csv gone.csv {GUARD} {CONSTANTS} --out o"), 2);
    let order: Vec<_> = report["logs"].as_array().unwrap().iter().map(|row| row["file"].as_str().unwrap()).collect();
    assert_eq!(order, ["broken.csv", "faulty.csv", "healthy.csv", "gone.csv"]);
    assert_eq!(report["outcome"], serde_json::json!({ "healthy": 1, "faulty": 1, "refused": 2 }));
    let error = |log| row(&report, log)["error"].as_str().unwrap();
    assert!(error("broken.csv").contains("`abc`") && error("gone.csv").contains("no log `gone.csv`"));
    assert_eq!(
        (&row(&report, "broken.csv")["rows"], &row(&report, "gone.csv")["alarms"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(row(&report, "healthy.csv")["alarms"], 0);
    // What the log alone gives, to the last digit.
    let alone = desk.json(&format!("replay faulty.csv {GUARD} {CONSTANTS} --out alone"), 1);
    let (faulty, alarm) = (row(&report, "faulty.csv"), &alone["alarms"][0]);
    for (column, value) in [
        ("rows", &alone["samples"]),
        ("learned", &alone["learned"]["n"]),
        ("half_shift_sigma", &alone["learned"]["quality"]["half_shift_sigma"]),
        ("first_alarm_s", &alarm["start_s"]),
        ("size", &alarm["size"]["value"]),
        ("sigma", &alarm["size"]["sigma"]),
        ("unit", &alarm["size"]["unit"]),
        ("error", &Value::Null),
    ] {
        assert_eq!(&faulty[column], value, "{column}");
    }
    assert_eq!(
        (&faulty["name"], &faulty["alarms"], &faulty["covered_share"]),
        (&"F2 speed sensor".into(), &1.into(), &1.0.into())
    );
}

#[test]
fn the_summary_is_the_same_as_csv_as_parquet_and_as_json() {
    let desk = three();
    let report = desk.json(&format!("replay broken.csv faulty.csv healthy.csv {GUARD} {CONSTANTS} --out o"), 2);
    assert_eq!(report["files"], serde_json::json!(["o/summary.csv", "o/summary.parquet"]));
    let csv = csv_cells(&desk.path("o/summary.csv"));
    assert_eq!(csv.len(), 4);
    assert_eq!(csv, parquet_cells(&desk.path("o/summary.parquet")));
    for (cells, row) in csv[1..].iter().zip(report["logs"].as_array().unwrap()) {
        assert_eq!(row.as_object().unwrap().len(), cells.len());
        for (name, cell) in csv[0].iter().zip(cells) {
            match &row[name] {
                Value::Null => assert_eq!(cell, ""),
                Value::String(text) => assert_eq!(cell, text),
                number => assert_eq!(cell.parse::<f64>().ok(), number.as_f64(), "{name}"),
            }
        }
    }
}

#[test]
fn the_same_log_as_csv_and_as_parquet_gets_the_same_verdict_in_either_mode() {
    let desk = Desk::with("a.csv", SAMPLE);
    write_parquet(&desk.path("b.parquet"), SAMPLE);
    for options in [format!("{GUARD} {CONSTANTS}"), MOTOR.to_owned()] {
        let report = desk.json(&format!("replay a.csv b.parquet {options} --set-point set_point"), 1);
        let (mut csv, mut parquet) = (row(&report, "a.csv").clone(), row(&report, "b.parquet").clone());
        (csv["file"], parquet["file"]) = (Value::Null, Value::Null);
        assert_eq!(csv, parquet);
        assert!(csv["alarms"].as_u64() > Some(0));
        // One in Parquet alone is replayed as one of text is, page and trace included.
        let alone = desk.json(&format!("replay b.parquet {options} --set-point set_point --out alone"), 1);
        assert_eq!(alone["alarms"][0]["start_s"], csv["first_alarm_s"]);
        assert!(desk.read("alone/replay.csv").lines().count() > 1700);
    }
}

#[test]
fn directories_are_searched_for_logs_and_the_results_of_an_earlier_run_are_none() {
    for out in ["logs", "logs/results"] {
        let desk = Desk::new();
        for name in ["logs/b/second.CSV", "logs/a.csv", "logs/notes.md", "logs/.hidden.csv"] {
            fs::create_dir_all(desk.path(name).parent().unwrap()).unwrap();
            desk.write(name, healthy());
        }
        write_parquet(&desk.path("logs/c.parquet"), &healthy());
        for run in 1..=2 {
            let report = desk.json(&format!("replay logs {GUARD} --out {out}"), 0);
            let files = report["logs"].as_array().unwrap().iter().map(|row| row["file"].as_str().unwrap());
            assert!(files.eq(["logs/a.csv", "logs/b/second.CSV", "logs/c.parquet"]), "{out}, run {run}: {report}");
        }
    }
    let desk = Desk::new();
    fs::create_dir(desk.path("empty")).unwrap();
    desk.refuses(&format!("replay empty {GUARD}"), &["'empty'", ".parquet"]);
}

#[test]
fn a_summary_never_overwrites_a_log_and_wrong_settings_are_refused_before_anything_is_read() {
    let desk = Desk::with("summary.csv", &healthy());
    desk.write("other.csv", healthy());
    desk.refuses(&format!("replay summary.csv other.csv {GUARD} --out ."), &["summary.csv", "overwritten"]);
    let options = GUARD.replace("--rate-hz 50", "--rate-hz 0");
    let output = desk.run(&format!("replay other.csv summary.csv {options}")).code(2).stdout("").get_output().clone();
    assert!(String::from_utf8(output.stderr).unwrap().contains("--rate-hz"));
    assert!(!desk.path("monitor-out/summary.csv").exists());
}

#[test]
fn people_get_a_table_that_begins_with_what_needs_them() {
    let desk = three();
    let done =
        desk.run(&format!("replay healthy.csv faulty.csv broken.csv {GUARD} {CONSTANTS} --out o")).code(2).stderr("");
    let text = String::from_utf8(done.get_output().stdout.clone()).unwrap();
    let at = |word: &str| text.find(word).unwrap_or_else(|| panic!("{word}\n{text}"));
    assert!(at("broken.csv") < at("faulty.csv") && at("faulty.csv") < at("healthy.csv"), "{text}");
    for part in
        ["F2 speed sensor", "refused: broken.csv: row 1600", "Logs: 3; without a fault: 1,", "Written: o/summary.csv"]
    {
        at(part);
    }
}
