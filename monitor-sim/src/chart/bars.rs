//! Bars in percent.

use super::drawing::{Drawing, PLOT_HEIGHT, PLOT_WIDTH, px};
use super::scale::Scale;
use super::{BarGroup, Picture, Swatch, series_class};

/// Draws groups of bars in percent; `bars` are the names of those in each group. `criterion` is drawn as a dashed line.
#[must_use]
pub fn bar_chart(groups: &[BarGroup], bars: &[String], name: &str, criterion: Option<(&str, f64)>) -> Picture {
    // A little room for the number over a full bar.
    let percent = Scale::linear(0.0, 108.0);
    let mut drawing = Drawing::new(PLOT_HEIGHT);
    drawing.ordinate(percent, &format!("{name}, %"));
    // Bars share four fifths of the group's room, but are no wider than tall numbers over them ask for.
    let room = PLOT_WIDTH / groups.len().max(1) as f64;
    let width = (0.8 * room / bars.len().max(1) as f64).min(80.0);
    for (g, group) in groups.iter().enumerate() {
        let middle = room * (g as f64 + 0.5);
        let first = middle - 0.5 * width * bars.len() as f64;
        for (k, value) in group.values.iter().enumerate() {
            let (x, y) = (first + width * k as f64, drawing.y(percent, *value));
            let (left, wide, high) = (px(x + 0.05 * width), px(0.9 * width), px(PLOT_HEIGHT - y));
            let (class, y) = (series_class(k), px(y));
            drawing.draw(&format!(
                "<rect class=\"solid {class}\" x=\"{left}\" y=\"{y}\" width=\"{wide}\" height=\"{high}\"/>\
                 <text class=\"mid\" x=\"{}\" y=\"{}\">{value:.1}</text>",
                px(x + 0.5 * width),
                px(y - 4.0)
            ));
        }
        drawing.name_under(middle, &group.name);
    }
    criterion.iter().for_each(|(_, level)| drawing.limit(drawing.y(percent, *level)));
    let of_group = |group: &BarGroup| {
        let values = bars.iter().zip(&group.values).map(|(bar, value)| format!("{bar} {value:.1}"));
        format!("{}: {}", group.name, values.collect::<Vec<_>>().join(", "))
    };
    let alternative = format!("{name}, %. {}", groups.iter().map(of_group).collect::<Vec<_>>().join("; "));
    let legend = bars.iter().enumerate().map(|(k, bar)| (Swatch::Series(k), bar.clone()));
    let limit = criterion.map(|(name, _)| (Swatch::Limit, name.to_owned()));
    Picture { svg: drawing.finish(&alternative, "", ""), legend: legend.chain(limit).collect() }
}
