//! Where the slots come from: a mission that is flown, or a log that is replayed.

use monitor_core::guard::SCALES;
use monitor_core::paper::Monitor;
use monitor_core::sample::{ModelId, Pair};

use super::slot::{Phase, Says, Slot};
use crate::guardian::{Alarming, Guardian, SCALE_NAMES, Said};
use crate::mission::{self, MissionError};
use crate::models::Models;
use crate::names::ChannelNames;
use crate::plant::Plant;
use crate::replay::{self, ReplayError, guard, paper};
use crate::scenario::Scenario;
use crate::settings::PaperSettings;

/// What the distances of `guard` mode are, and those of `paper` mode.
const RATIO_OF_GUARD: &str = "T²/limit";
const RATIO_OF_PAPER: &str = "residual/limit";

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
    Log(Box<guard::Pass>),
    PaperLog(Box<paper::Pass>),
}

impl Feed {
    /// A mission in `guard` mode, by stored models if there are any.
    ///
    /// # Errors
    /// [`WatchError::Mission`] when the monitor refuses its settings or the models.
    pub fn mission(
        scenario: &Scenario,
        alarming: &Alarming,
        seed: u64,
        models: Option<&Models>,
    ) -> Result<Self, WatchError> {
        let config = mission::guard::settings(scenario, alarming);
        let mut guardian = mission::guard::guardian(scenario, &config)?;
        models.map_or(Ok(()), |models| guardian.restore(models)).map_err(MissionError::from)?;
        let subject = of_mission(scenario, seed, ("guard", RATIO_OF_GUARD), time_scales(&config.time_constants_s));
        Ok(Feed { subject, source: Source::Guard(Plant::new(scenario, seed).into(), guardian.into()) })
    }

    /// A mission in `paper` mode.
    ///
    /// # Errors
    /// [`WatchError::Mission`] when the monitor refuses its settings.
    pub fn paper(scenario: &Scenario, settings: &PaperSettings, seed: u64) -> Result<Self, WatchError> {
        let monitor = mission::paper::monitor_for(scenario, settings)?;
        let subject = of_mission(scenario, seed, ("paper", RATIO_OF_PAPER), models(&ChannelNames::motor()));
        Ok(Feed { subject, source: Source::Paper(Plant::new(scenario, seed).into(), monitor.into()) })
    }

    /// A log in `guard` mode.
    ///
    /// # Errors
    /// [`WatchError::Replay`] when the log cannot be opened, or a setting makes no sense.
    pub fn log(replay: &guard::Replay) -> Result<Self, WatchError> {
        let pass = replay.begin()?;
        let scales = time_scales(&pass.config().time_constants_s);
        let subject = of_log(&replay.source, replay.set_point_tolerance, ("guard", RATIO_OF_GUARD), scales);
        Ok(Feed { subject, source: Source::Log(pass.into()) })
    }

    /// A log in `paper` mode, which reads what is learned from beforehand.
    ///
    /// # Errors
    /// [`WatchError::Replay`] when the log cannot be read or learned from, or a setting makes no sense.
    pub fn paper_log(replay: &paper::Replay) -> Result<Self, WatchError> {
        let pass = replay.begin()?;
        let models = models(pass.names());
        let subject = of_log(&replay.source, replay.set_point_tolerance, ("paper", RATIO_OF_PAPER), models);
        Ok(Feed { subject, source: Source::PaperLog(pass.into()) })
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
            Source::PaperLog(pass) => {
                let Some(step) = pass.next_step()? else { return Ok(None) };
                let t_s = step.row as f64 / self.subject.rate_hz;
                let set_point = if pass.has_set_point() { step.set_point } else { f64::NAN };
                let says = match step.judged {
                    Some(verdict) => Says::by_paper(&verdict, pass.monitor(), step.refused),
                    None if pass.is_learned_from(step.row) => Says { phase: Phase::Learning, ..Says::NOTHING },
                    None => Says::NOTHING,
                };
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

fn of_log(
    source: &replay::Source,
    set_point_tolerance: f64,
    (mode, ratio): (&str, &'static str),
    distances: Vec<Distance>,
) -> Subject {
    let name = source.path.file_name().unwrap_or_default().to_string_lossy();
    Subject {
        title: format!("replay of {name}, {mode} mode"),
        names: source.names(),
        units: [""; 3],
        ratio,
        distances,
        rate_hz: source.rate_hz,
        end_s: None,
        set_point_tolerance,
        injected: Vec::new(),
    }
}

fn time_scales(time_constants_s: &[f32; SCALES]) -> Vec<Distance> {
    let distance = |(name, time_s): (&'static str, &f32)| Distance { name, of: format!("over some {time_s} s") };
    SCALE_NAMES.into_iter().zip(time_constants_s).map(distance).collect()
}

fn models(names: &ChannelNames) -> Vec<Distance> {
    let name = |model: ModelId| match model {
        ModelId::Full => "all",
        ModelId::Pair(Pair::SpeedCurrent) => "r1",
        ModelId::Pair(Pair::CurrentVoltage) => "r2",
        ModelId::Pair(Pair::SpeedVoltage) => "r3",
    };
    let of = |model| names.model(model);
    ModelId::ALL.into_iter().map(|model| Distance { name: name(model), of: of(model) }).collect()
}
