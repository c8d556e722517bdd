//! A view of a run under way, in a terminal: a mission that is flown, or a log that is replayed, at a chosen pace.
//!
//! ```text
//! feed ─ slot ─┬─ chronicle ─ events ──┐
//!              └─ history (a ring) ────┴─ draw     the player moves the feed on, and takes keys
//! ```
//!
//! The run is stepped, not read beforehand, and memory does not grow with its length: what is older than the ring cannot
//! be gone back to. Nothing here knows a terminal: [`draw()`] fills any ratatui frame, [`as_text`] makes one a text.

pub mod pace;
pub mod slot;
pub mod feed;
pub mod chronicle;
pub mod history;
pub mod player;
pub mod draw;

pub use draw::{as_text, draw};
pub use feed::{Feed, Subject, WatchError};
pub use pace::Pace;
pub use player::Player;
