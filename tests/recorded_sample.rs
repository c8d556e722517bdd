//! Promise: the recorded sample in the repository is what its scenario file says it is.

use monitor_sim::plant::Plant;
use monitor_sim::scenario::Scenario;

const SCENARIO: &str = include_str!("../monitor-sim/samples/thruster.toml");
const SAMPLE: &str = include_str!("../monitor-sim/samples/thruster.csv");

#[test]
fn the_recorded_sample_is_made_by_the_scenario_beside_it() {
    let plant = Plant::new(&Scenario::from_toml(SCENARIO).unwrap(), 7);
    let mut lines = SAMPLE.lines();
    assert_eq!(lines.next(), Some("t_s,set_point,speed,current,voltage"));
    let mut rows = 0;
    for (measured, line) in plant.zip(&mut lines) {
        let values = [measured.speed, measured.armature_current, measured.armature_voltage].map(|v| v as f32);
        let [speed, current, voltage] = values;
        assert_eq!(line, format!("{:.6},{},{speed},{current},{voltage}", measured.t_s, measured.set_point));
        rows += 1;
    }
    assert_eq!((rows, lines.next()), (3000, None));
}
