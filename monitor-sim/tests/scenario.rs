//! Scenarios as data: what the default says, what is refused and how.

use monitor_sim::fault::{FaultKind, FaultPoint, FaultProfile};
use monitor_sim::scenario::{FIGURE_1_TOML, Scenario, ScenarioError, SetPoint, Start};

const SMALLEST: &str = "name = \"x\"\nduration_s = 140\n";

/// Key and line of the value refused in `text`.
fn refused(text: &str) -> (String, Option<usize>) {
    match Scenario::from_toml(text) {
        Err(ScenarioError::Value { key, line, problem, remedy }) => {
            assert!(!problem.is_empty() && !remedy.is_empty());
            (key, line)
        }
        other => panic!("not refused for a value: {other:?}\n{text}"),
    }
}

/// Figure 1 with `from` replaced by `to`, which must be there.
fn figure_1_with(from: &str, to: &str) -> String {
    assert!(FIGURE_1_TOML.contains(from), "{from}");
    FIGURE_1_TOML.replacen(from, to, 1)
}

/// Line of figure 1 in which `what` first stands, from 1.
fn line_of(what: &str) -> Option<usize> {
    FIGURE_1_TOML.find(what).map(|offset| FIGURE_1_TOML[..offset].matches('\n').count() + 1)
}

#[test]
fn the_shipped_file_is_figure_1() {
    assert_eq!(Scenario::from_toml(FIGURE_1_TOML), Ok(Scenario::figure_1()));
}

#[test]
fn figure_1_has_the_papers_schedule() {
    let scenario = Scenario::figure_1();
    assert_eq!(scenario.duration_s, 140.0);
    assert_eq!((scenario.learn.start_s, scenario.learn.end_s), (5.0, 20.0));
    assert_eq!(scenario.rate_hz(), 1000.0);
    assert_eq!(scenario.start, Start::Standstill);
    let schedule: Vec<_> = scenario.faults.iter().map(|f| (f.id.as_str(), f.point, f.start_s, f.end_s)).collect();
    assert_eq!(
        schedule,
        [
            ("F1", FaultPoint::LoadTorque, 20.0, 40.0),
            ("F2", FaultPoint::SpeedSensor, 60.0, 80.0),
            ("F3", FaultPoint::CurrentSensor, 100.0, 120.0),
        ]
    );
    assert!(scenario.faults.iter().all(|f| f.profile == FaultProfile::Step));
}

#[test]
fn what_is_left_out_takes_the_values_of_figure_1() {
    let smallest = Scenario::from_toml(SMALLEST).unwrap();
    let expected = Scenario { name: "x".to_owned(), ..Scenario::figure_1().without_faults() };
    assert_eq!(smallest, expected);
}

#[test]
fn a_scenario_written_as_toml_reads_back_the_same() {
    let mut scenario = Scenario::figure_1().with_ramps();
    scenario.faults[1].kind = FaultKind::Gain;
    scenario.start = Start::Steady;
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(Scenario::from_toml(&text), Ok(scenario));
}

#[test]
fn the_variants_change_what_they_say_and_nothing_else() {
    let figure_1 = Scenario::figure_1();
    let mut expected = figure_1.clone();
    expected.faults.iter_mut().for_each(|f| f.profile = FaultProfile::Ramp);
    assert_eq!(figure_1.with_ramps(), expected);

    let mut expected = figure_1.clone();
    expected.faults.iter_mut().for_each(|f| f.amplitude *= 0.5);
    assert_eq!(figure_1.scaled_faults(0.5), expected);

    let mut expected = figure_1.clone();
    expected.load.constant_nm = 0.0;
    expected.load.viscous_nm_s = 0.06 / 300.0;
    assert_eq!(figure_1.with_speed_dependent_load(), expected);

    let mut at_rest = figure_1.clone();
    at_rest.set_points[0].rad_per_s = 0.0;
    assert_eq!(at_rest.with_speed_dependent_load(), at_rest);
}

#[test]
fn a_recorded_sample_every_ten_periods_makes_a_tenth_of_the_rate() {
    let scenario = Scenario { record_every: 10, ..Scenario::figure_1() };
    assert_eq!(scenario.rate_hz(), 100.0);
}

#[test]
fn the_set_point_in_force_is_the_last_one_begun() {
    let step = |at_s, rad_per_s| SetPoint { at_s, rad_per_s };
    let set_points = vec![step(0.0, 100.0), step(10.0, 200.0), step(20.0, 150.0)];
    let scenario = Scenario { set_points, ..Scenario::figure_1() };
    let at = [0.0, 9.999, 10.0, 19.999, 20.0, 100.0].map(|t| scenario.set_point(t));
    assert_eq!(at, [100.0, 100.0, 200.0, 200.0, 150.0, 150.0]);
}

#[test]
fn an_unknown_key_is_refused_with_its_line_and_the_allowed_keys() {
    for (from, to, key, allowed) in [
        ("duration_s =", "duration =", "duration", "duration_s"),
        ("start_s = 5.0", "start = 5.0", "start", "start_s"),
        ("resistance_ohm", "resistance", "resistance", "resistance_ohm"),
        ("constant_nm =", "constant =", "constant", "constant_nm"),
        ("supply_v", "supply", "supply", "supply_v"),
        ("current_sigma_a", "current_sigma", "current_sigma", "current_sigma_a"),
        ("at_s", "at", "at", "at_s"),
        ("amplitude = 8.0", "amplitud = 8.0", "amplitud", "amplitude"),
    ] {
        let text = figure_1_with(from, to);
        let error = Scenario::from_toml(&text).unwrap_err();
        assert!(matches!(error, ScenarioError::Toml(_)), "{error:?}");
        let message = error.to_string();
        let line = line_of(from).unwrap();
        assert!(message.contains(&format!("line {line}")), "line {line}: {message}");
        assert!(message.contains(&format!("unknown field `{key}`")), "{message}");
        assert!(message.contains(&format!("`{allowed}`")), "{message}");
    }
}

#[test]
fn a_missing_key_a_wrong_type_and_an_unknown_word_are_refused_by_name() {
    for (text, expected) in [
        ("name = \"x\"".to_owned(), "duration_s"),
        (figure_1_with("id = \"F2\"", ""), "id"),
        (figure_1_with("140.0", "\"long\""), "expected f64"),
        (figure_1_with("record_every = 1", "record_every = -1"), "-1"),
        (figure_1_with("\"standstill\"", "\"coasting\""), "`standstill`"),
        (figure_1_with("\"offset\"", "\"drift\""), "`offset`"),
        (figure_1_with("\"load_torque\"", "\"inertia\""), "`speed_sensor`"),
    ] {
        let message = Scenario::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

#[test]
fn every_value_no_mission_can_have_is_refused_with_its_key_and_line() {
    for (from, to, key) in [
        ("duration_s = 140.0", "duration_s = nan", "duration_s"),
        ("duration_s = 140.0", "duration_s = -1.0", "duration_s"),
        ("duration_s = 140.0", "duration_s = inf", "duration_s"),
        ("control_rate_hz = 1000.0", "control_rate_hz = 0.0", "control_rate_hz"),
        ("record_every = 1", "record_every = 0", "record_every"),
        ("start_s = 5.0", "start_s = -5.0", "learn.start_s"),
        ("end_s = 20.0", "end_s = 5.05", "learn.end_s"),
        ("end_s = 20.0", "end_s = 4.0", "learn.end_s"),
        ("end_s = 20.0", "end_s = 141.0", "learn.end_s"),
        ("end_s = 20.0", "end_s = nan", "learn.end_s"),
        ("resistance_ohm = 0.299", "resistance_ohm = 0.0", "motor.resistance_ohm"),
        ("inductance_h = 0.0823e-3", "inductance_h = inf", "motor.inductance_h"),
        // A thousandth of the real one: the sub-steps could not follow.
        ("inductance_h = 0.0823e-3", "inductance_h = 0.0823e-6", "motor.inductance_h"),
        ("torque_constant_nm_per_a = 30.2e-3", "torque_constant_nm_per_a = -1.0", "motor.torque_constant_nm_per_a"),
        ("rotor_inertia_kg_m2 = 142e-7", "rotor_inertia_kg_m2 = 0", "motor.rotor_inertia_kg_m2"),
        ("added_inertia_kg_m2 = 1.0e-4", "added_inertia_kg_m2 = -1.0e-4", "motor.added_inertia_kg_m2"),
        ("constant_nm = 0.06", "constant_nm = -0.06", "load.constant_nm"),
        ("viscous_nm_s = 0.0", "viscous_nm_s = -1e-6", "load.viscous_nm_s"),
        ("quadratic_nm_s2 = 0.0", "quadratic_nm_s2 = nan", "load.quadratic_nm_s2"),
        ("turbulence_sigma_nm = 0.0", "turbulence_sigma_nm = -0.1", "load.turbulence_sigma_nm"),
        ("turbulence_bandwidth_hz = 1.0", "turbulence_bandwidth_hz = 0.0", "load.turbulence_bandwidth_hz"),
        ("turbulence_bandwidth_hz = 1.0", "turbulence_bandwidth_hz = 500.0", "load.turbulence_bandwidth_hz"),
        (
            "current_bandwidth_rad_per_s = 200.0",
            "current_bandwidth_rad_per_s = 600.0",
            "controller.current_bandwidth_rad_per_s",
        ),
        (
            "current_bandwidth_rad_per_s = 200.0",
            "current_bandwidth_rad_per_s = 0.0",
            "controller.current_bandwidth_rad_per_s",
        ),
        (
            "speed_bandwidth_rad_per_s = 20.0",
            "speed_bandwidth_rad_per_s = 60.0",
            "controller.speed_bandwidth_rad_per_s",
        ),
        (
            "speed_bandwidth_rad_per_s = 20.0",
            "speed_bandwidth_rad_per_s = -1.0",
            "controller.speed_bandwidth_rad_per_s",
        ),
        ("current_limit_a = 6.0", "current_limit_a = 0.0", "controller.current_limit_a"),
        ("supply_v = 24.0", "supply_v = nan", "controller.supply_v"),
        ("speed_sigma_rad_per_s = 0.1", "speed_sigma_rad_per_s = -0.1", "noise.speed_sigma_rad_per_s"),
        ("current_sigma_a = 0.02", "current_sigma_a = inf", "noise.current_sigma_a"),
        ("voltage_sigma_v = 0.02", "voltage_sigma_v = nan", "noise.voltage_sigma_v"),
        ("speed_step_rad_per_s = 0.0", "speed_step_rad_per_s = -1.0", "noise.speed_step_rad_per_s"),
        ("current_step_a = 0.0", "current_step_a = -1.0", "noise.current_step_a"),
        ("voltage_step_v = 0.0", "voltage_step_v = -1.0", "noise.voltage_step_v"),
        ("at_s = 0.0", "at_s = 1.0", "set_point[0].at_s"),
        ("rad_per_s = 300.0", "rad_per_s = nan", "set_point[0].rad_per_s"),
        // 0.0302 * 800 + 0.6 = 24.8 V.
        ("rad_per_s = 300.0", "rad_per_s = 800.0", "set_point[0].rad_per_s"),
        ("id = \"F2\"", "id = \"F1\"", "fault[1].id"),
        ("id = \"F2\"", "id = \"\"", "fault[1].id"),
        ("amplitude = 8.0", "amplitude = inf", "fault[1].amplitude"),
        ("start_s = 60.0", "start_s = -1.0", "fault[1].start_s"),
        ("start_s = 60.0", "start_s = nan", "fault[1].start_s"),
        ("end_s = 80.0", "end_s = 60.0", "fault[1].end_s"),
        ("end_s = 80.0", "end_s = 50.0", "fault[1].end_s"),
        ("end_s = 80.0", "end_s = nan", "fault[1].end_s"),
        ("end_s = 120.0", "end_s = 140.1", "fault[2].end_s"),
    ] {
        let text = figure_1_with(from, to);
        assert_eq!(refused(&text), (key.to_owned(), line_of(from)), "{to}");
    }
}

#[test]
fn a_message_names_line_key_value_and_remedy() {
    let text = figure_1_with("end_s = 80.0", "end_s = 50.0");
    let line = line_of("end_s = 80.0").unwrap();
    assert_eq!(
        Scenario::from_toml(&text).unwrap_err().to_string(),
        format!(
            "line {line}: `fault[1].end_s` = 50 is not after start_s = 60; \
             let the fault end after it starts"
        )
    );
}

#[test]
fn a_default_that_does_not_fit_points_to_the_table_it_was_left_out_of() {
    // Learning until 20 s by default, in a mission of 10 s: no line of the text says so.
    assert_eq!(refused("name = \"x\"\nduration_s = 10\n"), ("learn.end_s".to_owned(), None));
    let text = "name = \"x\"\nduration_s = 140\n\n[controller]\nsupply_v = 24\ncurrent_limit_a = 1\n";
    assert_eq!(refused(text).0, "set_point[0].rad_per_s", "2 A of load, 1 A of limit");
    let text = "name = \"x\"\nduration_s = 140\ncontrol_rate_hz = 100\n\n[controller]\nsupply_v = 24\n";
    let key = "controller.current_bandwidth_rad_per_s".to_owned();
    assert_eq!(refused(text), (key, Some(5)));
}

#[test]
fn set_points_must_come_in_order_within_the_mission() {
    let step = |at_s: f64| format!("[[set_point]]\nat_s = {at_s}\nrad_per_s = 100\n");
    let with = |times: &[f64]| SMALLEST.to_owned() + &times.iter().map(|&t| step(t)).collect::<String>();
    assert!(Scenario::from_toml(&with(&[0.0, 10.0, 20.0])).is_ok());
    assert_eq!(refused(&with(&[0.0, 20.0, 10.0])), ("set_point[2].at_s".to_owned(), Some(10)));
    assert_eq!(refused(&with(&[0.0, 0.0])), ("set_point[1].at_s".to_owned(), Some(7)));
    assert_eq!(refused(&with(&[0.0, 140.0])), ("set_point[1].at_s".to_owned(), Some(7)));
    assert_eq!(refused("name = \"x\"\nduration_s = 140\nset_point = []\n").0, "set_point");
}

#[test]
fn a_gain_that_turns_the_sign_is_refused_and_a_dead_sensor_is_not() {
    let with = |amplitude: &str| {
        figure_1_with("kind = \"offset\"             #", "kind = \"gain\" #").replacen("amplitude = 0.03", amplitude, 1)
    };
    assert_eq!(refused(&with("amplitude = -1.1")).0, "fault[0].amplitude");
    assert!(Scenario::from_toml(&with("amplitude = -1.0")).is_ok());
}

#[test]
fn faults_beyond_the_papers_are_read_and_refused_where_they_make_no_sense() {
    let with = |point: &str, kind: &str, rest: &str| {
        format!(
            "{SMALLEST}[[fault]]\nid = \"X\"\nname = \"x\"\npoint = \"{point}\"\nkind = \"{kind}\"\n\
             profile = \"ramp\"\nstart_s = 30\nend_s = 60\n{rest}\n"
        )
    };
    for (point, kind, rest) in [
        ("load_inertia", "gain", "amplitude = 1.0"),
        ("armature_resistance", "offset", "amplitude = 0.1"),
        ("torque_constant", "gain", "amplitude = -0.3"),
        ("voltage_actuator", "gain", "amplitude = -0.2"),
        ("voltage_sensor", "coarse", "amplitude = 0.1"),
        ("current_sensor", "stuck", "amplitude = 1.0"),
        ("speed_sensor", "offset", "amplitude = 5.0\nshare = 0.01"),
        ("sampling", "missing", "amplitude = 0.5"),
    ] {
        let read = Scenario::from_toml(&with(point, kind, rest));
        assert!(read.is_ok(), "{point} {kind}: {read:?}");
        let again = toml::to_string(&read.clone().unwrap()).unwrap();
        assert_eq!(Scenario::from_toml(&again), read);
    }
    for (point, kind, rest, key) in [
        ("load_torque", "stuck", "amplitude = 1.0", "kind"),
        ("speed_sensor", "missing", "amplitude = 1.0", "kind"),
        ("sampling", "offset", "amplitude = 1.0", "kind"),
        ("torque_constant", "gain", "amplitude = -1.0", "amplitude"),
        ("armature_resistance", "offset", "amplitude = -0.3", "amplitude"),
        // A billionth of the inertia: the exchange between current and speed would be too fast for the sub-steps.
        ("load_inertia", "gain", "amplitude = -0.999999999", "amplitude"),
        ("current_sensor", "stuck", "amplitude = 1.5", "amplitude"),
        ("voltage_sensor", "coarse", "amplitude = -0.1", "amplitude"),
        ("speed_sensor", "offset", "amplitude = 5.0\nshare = 0.0", "share"),
        ("speed_sensor", "offset", "amplitude = 5.0\nshare = nan", "share"),
        ("sampling", "missing", "amplitude = 0.5\nshare = 0.5", "share"),
    ] {
        let (refused_key, line) = refused(&with(point, kind, rest));
        assert_eq!(
            (refused_key.as_str(), line.is_some()),
            (format!("fault[0].{key}").as_str(), true),
            "{point} {kind}"
        );
    }
}

#[test]
fn faults_may_overlap() {
    assert!(Scenario::from_toml(&figure_1_with("start_s = 60.0", "start_s = 30.0")).is_ok());
}
