//! Shares in a grid: rows and columns of cells, in each how something is shared out.

use std::fmt::Write as _;

use super::drawing::{Drawing, PLOT_WIDTH, px};
use super::{Picture, Swatch};
use crate::page::escaped;

/// Height of a row, and of what is drawn in it.
const ROW: f64 = 30.0;
const BAR: f64 = 22.0;
/// Room between columns.
const BETWEEN: f64 = 8.0;
/// A number is written where it has this much room.
const NUMBER: f64 = 26.0;
/// How opaque the least share is and a whole: the one can be seen, and numbers be read on the other.
const SHADE: [f64; 2] = [0.1, 0.5];

/// A share in percent, and which part of the legend it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The part.
    pub part: usize,
    /// Percent.
    pub percent: f64,
}

/// A row of a grid.
#[derive(Clone, Debug)]
pub struct GridRow {
    /// What it is of.
    pub name: String,
    /// How each cell is shared out; of what is missing from a whole nothing is drawn.
    pub cells: Vec<Vec<Share>>,
}

/// What the cells of a grid are.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// What is shared out.
    pub name: &'a str,
    /// The columns.
    pub columns: &'a [String],
    /// What the columns are.
    pub across: &'a str,
    /// How parts are marked, and what they are.
    pub parts: &'a [(Swatch, &'a str)],
}

/// Draws a bar in each cell, whose parts are as long as their shares.
#[must_use]
pub fn bar_grid(grid: Grid, rows: &[GridRow]) -> Picture {
    drawn(grid, rows, |cell, room| {
        let mut left = 0.0;
        let mut bar = String::new();
        for Share { part, percent } in cell {
            let wide = room * percent / 100.0;
            let class = grid.class(*part);
            let _ = write!(bar, "<rect class=\"{class}\" x=\"{}\" width=\"{}\" height=\"{BAR}\"/>", px(left), px(wide));
            if wide >= NUMBER {
                let ground = if class.starts_with("band") { "mid" } else { "mid on" };
                bar += &number(ground, left + 0.5 * wide, *percent);
            }
            left += wide;
        }
        bar
    })
}

/// Draws the share of each cell, of which it has one at most, as its shade.
#[must_use]
pub fn shade_grid(grid: Grid, rows: &[GridRow]) -> Picture {
    drawn(grid, rows, |cell, room| {
        let shade = |Share { part, percent }: &Share| {
            let [least, whole] = SHADE;
            let (class, shade) = (grid.class(*part), least + (whole - least) * percent / 100.0);
            let rect = format!(
                "<rect class=\"{class}\" style=\"fill-opacity:{shade:.2}\" width=\"{}\" height=\"{BAR}\"/>",
                px(room)
            );
            rect + &number("mid", 0.5 * room, *percent)
        };
        cell.iter().map(shade).collect()
    })
}

impl Grid<'_> {
    fn class(&self, part: usize) -> String {
        self.parts.get(part).map(|(swatch, _)| swatch.class()).unwrap_or_default()
    }
}

fn drawn(grid: Grid, rows: &[GridRow], draw: impl Fn(&[Share], f64) -> String) -> Picture {
    let mut drawing = Drawing::new(ROW * rows.len().max(1) as f64);
    let column = PLOT_WIDTH / grid.columns.len().max(1) as f64;
    let mut told = Vec::new();
    for (row, k) in rows.iter().zip(0..) {
        let top = ROW * f64::from(k) + 0.5 * (ROW - BAR);
        for ((cell, name), n) in row.cells.iter().zip(grid.columns).zip(0..) {
            let parts = cell.iter().filter_map(|share| Some((grid.parts.get(share.part)?.1, share.percent)));
            let parts = parts.map(|(part, percent)| format!("{part} {percent:.1} %")).collect::<Vec<_>>().join(", ");
            let words = format!("{}, {name}: {parts}", row.name);
            let (left, room) = (px(column * f64::from(n) + 0.5 * BETWEEN), column - BETWEEN);
            drawing.draw(&format!(
                "<g transform=\"translate({left} {top})\"><title>{}</title>\
                 <rect class=\"empty\" width=\"{}\" height=\"{BAR}\"/>{}</g>",
                escaped(&words),
                px(room),
                draw(cell, room)
            ));
            told.push(words);
        }
        drawing.name_before(top + 0.5 * BAR, &row.name);
    }
    drawing.names_under(grid.columns, grid.across);
    let alternative = format!("{} by {}. {}", grid.name, grid.across, told.join("; "));
    let legend = grid.parts.iter().map(|(swatch, name)| (*swatch, (*name).to_owned())).collect();
    Picture { svg: drawing.finish(&alternative, "", ""), legend }
}

fn number(class: &str, x: f64, percent: f64) -> String {
    format!("<text class=\"{class}\" x=\"{}\" y=\"16\">{percent:.0}</text>", px(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARTS: [(Swatch, &str); 2] = [(Swatch::Series(2), "right"), (Swatch::Band, "missed")];

    fn rows() -> [GridRow; 1] {
        let cell = |right, missed| vec![Share { part: 0, percent: right }, Share { part: 1, percent: missed }];
        [GridRow { name: "F1 <load>".to_owned(), cells: vec![cell(75.0, 25.0), cell(97.0, 3.0)] }]
    }

    fn grid(columns: &[String]) -> Grid<'_> {
        Grid { name: "share of flights", columns, across: "size", parts: &PARTS }
    }

    #[test]
    fn parts_of_a_bar_are_as_long_as_their_shares_and_say_them_where_they_have_room_and_to_who_points_at_them() {
        let columns = ["1", "2"].map(str::to_owned);
        let Picture { svg, legend } = bar_grid(grid(&columns), &rows());
        // 832 pixels are two columns of 408 and the room between them.
        assert!(svg.contains("<rect class=\"solid s2\" x=\"0\" width=\"306\""), "{svg}");
        assert!(svg.contains("<rect class=\"band\" x=\"306\" width=\"102\""), "{svg}");
        assert!(svg.contains("<title>F1 &lt;load&gt;, 2: right 97.0 %, missed 3.0 %</title>"), "{svg}");
        assert!(svg.contains(">75</text>") && svg.contains(">97</text>") && !svg.contains(">3</text>"), "{svg}");
        assert!(svg.contains("aria-label=\"share of flights by size. F1 &lt;load&gt;, 1: right 75.0 %, missed"));
        assert_eq!(legend[1], (Swatch::Band, "missed".to_owned()));
    }

    #[test]
    fn a_shade_is_as_deep_as_its_share_and_a_cell_without_one_is_empty() {
        let columns = ["right", "no name"].map(str::to_owned);
        let row = GridRow { name: "F1".to_owned(), cells: vec![vec![Share { part: 0, percent: 50.0 }], vec![]] };
        let svg = shade_grid(grid(&columns), &[row]).svg;
        assert!(svg.contains("fill-opacity:0.30") && svg.contains(">50</text>"), "{svg}");
        assert_eq!((svg.matches("class=\"solid s2\"").count(), svg.matches("class=\"empty\"").count()), (1, 2));
    }

    #[test]
    fn without_rows_and_columns_there_is_still_a_picture() {
        let svg = bar_grid(grid(&[]), &[]).svg;
        assert!(svg.starts_with("<svg") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
