//! What all pictures have: a plot that clips what is in it, with axes, ticks and names around it.

use std::fmt::Write as _;

use super::scale::Scale;
use crate::page::escaped;

/// Size of a picture's coordinate system, which is scaled to the page, and where the plot lies in it: at the same place in
/// every picture, so that those over time stand exactly under each other.
const WIDTH: f64 = 1000.0;
const LEFT: f64 = 150.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 24.0;
pub(super) const PLOT_WIDTH: f64 = WIDTH - LEFT - RIGHT;
/// Height of a plot that has an ordinate.
pub(super) const PLOT_HEIGHT: f64 = 208.0;
/// Room for ticks, and for the name of the axis under them.
const TICKS: f64 = 26.0;
const NAME: f64 = 22.0;
/// From a line of text to the next.
const LINE: f64 = 17.0;
/// From the middle of a line of text to its base.
pub(super) const BASE: f64 = 5.0;
/// About the width of a letter, where it must be known before a browser measures it.
const LETTER: f64 = 8.0;

/// A picture being drawn.
#[derive(Debug)]
pub(super) struct Drawing {
    /// What lies in the plot, in coordinates from its upper left corner, and what lies around it.
    plot: String,
    around: String,
    plot_height: f64,
    height: f64,
    /// How far the names above the plot reach.
    named_to: f64,
}

impl Drawing {
    /// A picture with an empty plot of this height.
    pub(super) fn new(plot_height: f64) -> Self {
        Drawing {
            plot: String::new(),
            around: String::new(),
            plot_height,
            height: TOP + plot_height + TICKS,
            named_to: 0.0,
        }
    }

    /// Puts an element into the plot.
    pub(super) fn draw(&mut self, element: &str) {
        self.plot += element;
        self.plot.push('\n');
    }

    /// Where a value of the ordinate lies, from the upper end of the plot.
    pub(super) fn y(&self, scale: Scale, value: f64) -> f64 {
        self.plot_height * (1.0 - scale.share(value))
    }

    /// The ordinate, with a grid line at each tick.
    pub(super) fn ordinate(&mut self, scale: Scale, name: &str) {
        let mut grid = String::new();
        for (value, label) in scale.ticks(6) {
            let y = self.y(scale, value);
            let _ = write!(grid, "M0 {}h{PLOT_WIDTH}", px(y));
            self.text("end", LEFT - 8.0, TOP + y + BASE, &label);
        }
        self.draw(&format!("<path class=\"grid\" d=\"{grid}\"/>"));
        let middle = px(TOP + self.plot_height / 2.0);
        let name = escaped(name);
        let _ =
            writeln!(self.around, "<text class=\"mid\" transform=\"translate(20 {middle}) rotate(-90)\">{name}</text>");
    }

    /// The abscissa.
    pub(super) fn abscissa(&mut self, scale: Scale, name: Option<&str>) {
        let under = TOP + self.plot_height;
        let _ = write!(self.around, "<g class=\"ticks\" transform=\"translate({LEFT} {under})\">");
        for (value, label) in scale.ticks(8) {
            let x = px(PLOT_WIDTH * scale.share(value));
            let tick = format!("<path class=\"axis\" d=\"M0 0v5\"/><text class=\"mid\" y=\"20\">{label}</text>");
            let _ = write!(self.around, "<g transform=\"translate({x})\">{tick}</g>");
        }
        self.around += "</g>\n";
        if let Some(name) = name {
            self.name_of_abscissa(name);
        }
    }

    /// A dashed line across the plot.
    pub(super) fn limit(&mut self, y: f64) {
        self.draw(&format!("<path class=\"limit\" d=\"M0 {}h{PLOT_WIDTH}\"/>", px(y)));
    }

    /// A name before the plot, at the height `y` in it.
    pub(super) fn name_before(&mut self, y: f64, name: &str) {
        let room = LEFT - 10.0;
        // A long name is narrowed to the room there is.
        let narrowed = if name.chars().count() > 18 {
            format!(" textLength=\"{room}\" lengthAdjust=\"spacingAndGlyphs\"")
        } else {
            String::new()
        };
        let (y, name) = (px(TOP + y + BASE), escaped(name));
        let _ = writeln!(self.around, "<text class=\"end\" x=\"{room}\" y=\"{y}\"{narrowed}>{name}</text>");
    }

    /// A name above the plot, for what reaches from `from` to `to` in it; the element gets these `attributes`.
    pub(super) fn name_above(&mut self, (from, to): (f64, f64), attributes: &str, name: &str) {
        let half = 0.5 * LETTER * name.chars().count() as f64;
        let middle = (LEFT + (from + to) / 2.0).min(WIDTH - half).max(half);
        // A name without room waits for a view in which it has some.
        let hidden = if middle - half < self.named_to { " visibility=\"hidden\"" } else { "" };
        if hidden.is_empty() {
            self.named_to = middle + half + LETTER;
        }
        let (x, y, name) = (px(middle), TOP - 7.0, escaped(name));
        let _ = writeln!(self.around, "<text class=\"mid\" {attributes} x=\"{x}\" y=\"{y}\"{hidden}>{name}</text>");
    }

    /// Names under the plot, which is shared out equally among them, and what they are. Names of several words stand on two lines.
    pub(super) fn names_under(&mut self, names: &[String], across: &str) {
        let room = PLOT_WIDTH / names.len().max(1) as f64;
        let fits = |name: &String| LETTER * name.chars().count() as f64 <= room;
        for (name, n) in names.iter().zip(0..) {
            let middle = room * (f64::from(n) + 0.5);
            match name.rsplit_once(' ').filter(|_| !fits(name)) {
                Some((above, below)) => {
                    self.name_under(middle, above);
                    self.text("mid", LEFT + middle, TOP + self.plot_height + 20.0 + LINE, below);
                }
                None => self.name_under(middle, name),
            }
        }
        if !names.iter().all(fits) {
            self.height += LINE;
        }
        self.name_of_abscissa(across);
    }

    fn name_of_abscissa(&mut self, name: &str) {
        self.text("mid abscissa", LEFT + PLOT_WIDTH / 2.0, self.height + 14.0, name);
        self.height += NAME;
    }

    /// A name under the plot.
    pub(super) fn name_under(&mut self, x: f64, name: &str) {
        self.text("mid", LEFT + x, TOP + self.plot_height + 20.0, name);
    }

    fn text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        let (x, y, text) = (px(x), px(y), escaped(text));
        let _ = writeln!(self.around, "<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{text}</text>");
    }

    /// The picture. `alternative` says in words what it shows; `attributes` and `of_plot` are for the page's script.
    pub(super) fn finish(self, alternative: &str, attributes: &str, of_plot: &str) -> String {
        let Drawing { plot, around, plot_height, height, .. } = self;
        let alternative = escaped(alternative);
        let under = TOP + plot_height;
        format!(
            "<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{alternative}\" focusable=\"false\"{attributes}>\n\
             <svg class=\"plot\" x=\"{LEFT}\" y=\"{TOP}\" width=\"{PLOT_WIDTH}\" height=\"{plot_height}\"{of_plot}>\n\
             <rect class=\"field\" width=\"{PLOT_WIDTH}\" height=\"{plot_height}\"/>\n{plot}</svg>\n\
             <path class=\"axis\" d=\"M{LEFT} {TOP}V{under}h{PLOT_WIDTH}\"/>\n{around}</svg>"
        )
    }
}

/// A coordinate, to a tenth of a pixel.
pub(super) fn px(coordinate: f64) -> f64 {
    (coordinate * 10.0).round() / 10.0
}
