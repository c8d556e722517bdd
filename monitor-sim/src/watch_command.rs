//! `monitor-sim watch`: a run in the terminal while it is judged.

use std::io::IsTerminal;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use monitor_sim::models::{Models, Place};
use monitor_sim::replay::{guard, paper};
use monitor_sim::watch::{Feed, Player, as_text, draw};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event};
use signal_hook::consts::SIGTERM;

use crate::args::Mode;
use crate::args::watch::WatchArgs;
use crate::replay_command::{guard_replay, paper_replay};
use crate::{Failure, only_in_guard_mode, only_in_paper_mode, print_all, scenario, settings};

/// Time from one frame to the next, and how much of it the run may take: the rest is for drawing and for keys.
const FRAME: Duration = Duration::from_millis(40);
const RUN: Duration = Duration::from_millis(25);

/// Shows a mission or a log.
pub(crate) fn run(args: &WatchArgs) -> Result<ExitCode, Failure> {
    let in_order = args.print_at.windows(2).all(|pair| pair[0] <= pair[1]);
    if !in_order {
        return Err("--print-at goes forward only: give its seconds in ascending order".into());
    }
    if args.print_at.is_empty() && !std::io::stdout().is_terminal() {
        let instead = if args.log.is_some() { "`monitor-sim replay`" } else { "`monitor-sim` without a command" };
        return Err(format!(
            "the output is no terminal, so nothing can be watched: use {instead}, or print single frames with --print-at S"
        )
        .into());
    }
    let player = Player::new(feed(args)?, args.pace);
    if args.print_at.is_empty() { watch(player) } else { print_frames(args, player) }
}

fn feed(args: &WatchArgs) -> Result<Feed, Failure> {
    match args.mode {
        Mode::Guard => only_in_paper_mode("--limits", args.limits.is_some())?,
        Mode::Paper => only_in_guard_mode("--models", args.models.is_some())?,
    }
    if let Some(path) = &args.log {
        let window = || args.how.learn.ok_or("give --learn A..B");
        return match args.mode {
            Mode::Guard => {
                let learn = match &args.models {
                    Some(models) => guard::Learn::Stored { place: Place::at(models), relearn_s: args.relearn },
                    None => guard::Learn::Window(window()?),
                };
                Ok(Feed::log(&guard_replay(path, &args.how, learn)?)?)
            }
            Mode::Paper => {
                let learn = paper::Learn::Window(window()?);
                Ok(Feed::paper_log(&paper_replay(path, &args.how, learn, args.limits.as_deref())?)?)
            }
        };
    }
    let (scenario, seed) = (scenario(args.scenario.as_deref())?, args.seed.unwrap_or(1));
    match args.mode {
        Mode::Guard => {
            let models = args.models.as_deref().map(Models::read).transpose()?;
            Ok(Feed::mission(&scenario, &args.how.alarming.alarming(), seed, models.as_ref())?)
        }
        Mode::Paper => {
            args.how.alarming.only_in_guard_mode()?;
            Ok(Feed::paper(&scenario, &settings(args.limits.as_deref())?, seed)?)
        }
    }
}

fn print_frames(args: &WatchArgs, mut player: Player) -> Result<ExitCode, Failure> {
    let (width, height) = args.size;
    let mut text = String::new();
    for t_s in &args.print_at {
        if !player.advance_to(*t_s)? {
            let end_s = player.shown().map_or(0.0, |bin| bin.t_s);
            return Err(format!("--print-at {t_s}: the run ends at {end_s} s; give a second up to then").into());
        }
        text += &as_text(&player, width, height)?;
    }
    print_all(&text)
}

/// The terminal as it was found, on quitting and on errors; on a panic ratatui's hook has seen to it before its message.
struct Restored;

impl Drop for Restored {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            ratatui::restore();
        }
    }
}

/// Shows the run until its viewer leaves. A polite request to end is answered as a viewer's, with the terminal restored.
fn watch(player: Player) -> Result<ExitCode, Failure> {
    let asked_to_end = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGTERM, Arc::clone(&asked_to_end))?;
    let restored = Restored;
    let terminal =
        ratatui::try_init().map_err(|error| format!("the terminal cannot be set up for watching: {error}"))?;
    let shown = show(player, terminal, &asked_to_end);
    drop(restored);
    shown.map(|()| ExitCode::SUCCESS)
}

/// Draws, moves the run on, and answers keys, until the viewer leaves.
fn show(mut player: Player, mut terminal: DefaultTerminal, asked_to_end: &AtomicBool) -> Result<(), Failure> {
    let mut before = Instant::now();
    while !asked_to_end.load(Ordering::Relaxed) {
        terminal.draw(|frame| draw(&player, frame))?;
        let drawn = Instant::now();
        player.advance(drawn - before, RUN)?;
        before = drawn;
        // Every key that is waiting is answered before the next frame.
        let mut wait = FRAME.saturating_sub(drawn.elapsed());
        while event::poll(wait)? {
            if let Event::Key(key) = event::read()?
                && !player.press(key)
            {
                return Ok(());
            }
            wait = Duration::ZERO;
        }
    }
    Ok(())
}
