//! Where the slots come from: a mission that is flown, or a log that is replayed.

use monitor_core::guard::SCALES;
use monitor_core::paper::Monitor;
use monitor_core::sample::{ModelId, Pair};

use super::slot::{Says, Slot};
use crate::guardian::{Guardian, SCALE_NAMES, Said};
use crate::mission::{self, MissionError};
use crate::names::ChannelNames;
use crate::plant::Plant;
use crate::replay::ReplayError;
use crate::replay::guard::{Pass, Replay};
use crate::scenario::Scenario;
use crate::settings::PaperSettings;

/// What the distances of `guard` mode are.
const RATIO_OF_GUARD: &str = "T²/limit";

/// Why a run cannot be shown, or not any further.
#[derive(Debug, thiserror::Error)]
pub enum WatchError {
    /// The mission cannot be flown.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// The log cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// What is looked at.
#[derive(Clone, Debug)]
pub struct Subject {
    /// What it is, for people.
    pub title: String,
    /// Names of the three channels.
    pub names: ChannelNames,
    /// Their units, where they are known, and else empty.
    pub units: [&'static str; 3],
    /// What is compared with its limit.
    pub ratio: &'static str,
    /// What the distances are called, and how they are made.
    pub distances: Vec<Distance>,
    /// Slots per second.
    pub rate_hz: f64,
    /// When the run ends, s; none of a log, whose rows are not counted beforehand.
    pub end_s: Option<f64>,
    /// Movement of the set point that is not a change.
    pub set_point_tolerance: f64,
    /// What was injected into a mission, and when it begins and ends, s.
    pub injected: Vec<(f64, String)>,
}

/// A distance that has a limit.
#[derive(Clone, Debug)]
pub struct Distance {
    /// A short name.
    pub name: &'static str,
    /// What it looks at.
    pub of: String,
}

/// A run under way.
#[derive(Debug)]
pub struct Feed {
    subject: Subject,
    source: Source,
}

#[derive(Debug)]
enum Source {
    Guard(Box<Plant>, Box<Guardian>),
    Paper(Box<Plant>, Box<Monitor>),
    Log(Box<Pass>),
}

impl Feed {
    /// A mission in `guard` mode.
    ///
    /// # Errors
    /// [`WatchError::Mission`] when the monitor refuses its settings.
    pub fn mission(scenario: &Scenario, false_alarms_per_hour: f64, seed: u64) -> Result<Self, WatchError> {
        let config = mission::guard::settings(scenario, false_alarms_per_hour);
        let guardian = mission::guard::guardian(scenario, &config)?;
        let subject = of_mission(scenario, seed, ("guard", RATIO_OF_GUARD), time_scales(&config.time_constants_s));
        Ok(Feed { subject, source: Source::Guard(Plant::new(scenario, seed).into(), guardian.into()) })
    }

    /// A mission in `paper` mode.
    ///
    /// # Errors
    /// [`WatchError::Mission`] when the monitor refuses its settings.
    pub fn paper(scenario: &Scenario, settings: &PaperSettings, seed: u64) -> Result<Self, WatchError> {
        let monitor = mission::paper::monitor_for(scenario, settings)?;
        let subject = of_mission(scenario, seed, ("paper", "residual/limit"), models());
        Ok(Feed { subject, source: Source::Paper(Plant::new(scenario, seed).into(), monitor.into()) })
    }

    /// A log in `guard` mode.
    ///
    /// # Errors
    /// [`WatchError::Replay`] when the log cannot be opened, or a setting makes no sense.
    pub fn log(replay: &Replay) -> Result<Self, WatchError> {
        let pass = replay.begin()?;
        let name = replay.source.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let subject = Subject {
            title: format!("replay of {name}, guard mode"),
            names: pass.names().clone(),
            units: [""; 3],
            ratio: RATIO_OF_GUARD,
            distances: time_scales(&pass.config().time_constants_s),
            rate_hz: replay.source.rate_hz,
            end_s: None,
            set_point_tolerance: replay.set_point_tolerance,
            injected: Vec::new(),
        };
        Ok(Feed { subject, source: Source::Log(pass.into()) })
    }

    /// What is looked at.
    #[must_use]
    pub const fn subject(&self) -> &Subject {
        &self.subject
    }

    /// The next slot; none at the end of the run.
    ///
    /// # Errors
    /// [`WatchError`] when the log cannot be read on, or its learning window is refused.
    pub fn next_slot(&mut self) -> Result<Option<Slot>, WatchError> {
        match &mut self.source {
            Source::Guard(plant, guardian) => Ok(plant.next().map(|measured| {
                let said = mission::guard::give(guardian, &measured);
                let x = if measured.missing { [f64::NAN; 3] } else { measured.channels() };
                let says = Says::by_guard(&said, guardian);
                Slot { t_s: measured.t_s, set_point: measured.set_point, x, says }
            })),
            Source::Paper(plant, monitor) => Ok(plant.next().map(|measured| {
                let verdict = *mission::paper::give(monitor, &measured);
                let due = verdict.phase() == monitor_core::paper::Phase::ModelDue;
                let refused = if due { monitor.finish_learning().err() } else { None };
                let x = if measured.missing { [f64::NAN; 3] } else { measured.channels() };
                let says = Says::by_paper(&verdict, monitor, refused);
                Slot { t_s: measured.t_s, set_point: measured.set_point, x, says }
            })),
            Source::Log(pass) => {
                let Some(step) = pass.next_step()? else { return Ok(None) };
                let t_s = step.row as f64 / self.subject.rate_hz;
                let set_point = if pass.has_set_point() { step.set_point } else { f64::NAN };
                let says = pass.guardian().map_or(Says::NOTHING, |guardian| {
                    let verdict = *guardian.guard().verdict();
                    let said = step.judged.unwrap_or(Said { verdict, found: None, learned: None });
                    Says::by_guard(&said, guardian)
                });
                Ok(Some(Slot { t_s, set_point, x: step.x, says }))
            }
        }
    }
}

fn of_mission(
    scenario: &Scenario,
    seed: u64,
    (mode, ratio): (&str, &'static str),
    distances: Vec<Distance>,
) -> Subject {
    let ends = |id: &str, what: &str| format!("{id} {what} (injected)");
    let injected =
        scenario.faults.iter().flat_map(|f| [(f.start_s, ends(&f.id, "begins")), (f.end_s, ends(&f.id, "ends"))]);
    let mut injected: Vec<_> = injected.collect();
    injected.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Subject {
        title: format!("{}, seed {seed}, {mode} mode", scenario.name),
        names: ChannelNames::motor(),
        units: ["rad/s", "A", "V"],
        ratio,
        distances,
        rate_hz: scenario.rate_hz(),
        end_s: Some(scenario.duration_s),
        set_point_tolerance: 0.0,
        injected,
    }
}

fn time_scales(time_constants_s: &[f32; SCALES]) -> Vec<Distance> {
    let distance = |(name, time_s): (&'static str, &f32)| Distance { name, of: format!("over some {time_s} s") };
    SCALE_NAMES.into_iter().zip(time_constants_s).map(distance).collect()
}

fn models() -> Vec<Distance> {
    let name = |model: ModelId| match model {
        ModelId::Full => "all",
        ModelId::Pair(Pair::SpeedCurrent) => "r1",
        ModelId::Pair(Pair::CurrentVoltage) => "r2",
        ModelId::Pair(Pair::SpeedVoltage) => "r3",
    };
    let of = |model| ChannelNames::motor().model(model);
    ModelId::ALL.into_iter().map(|model| Distance { name: name(model), of: of(model) }).collect()
}
