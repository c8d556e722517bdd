//! One self-contained HTML page: no network, nothing from outside, readable in a light and a dark theme, on a phone and on paper.

use std::fmt::Write as _;

use crate::chart::{Picture, STYLE};

/// A page, from its summary line down.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Title.
    pub title: String,
    /// What came out, in one sentence.
    pub summary: String,
    /// The sections, in order.
    pub sections: Vec<Section>,
    /// Version and configuration, at the foot.
    pub footer: String,
}

/// A section of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// What it holds.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// Text.
    Paragraph(String),
    /// A table.
    Table {
        /// What it shows.
        caption: String,
        /// Names of the columns.
        header: Vec<String>,
        /// Its cells. The first cell of a row names it.
        rows: Vec<Vec<String>>,
        /// When what its rows tell of began, s, which the page's pictures over time can show; none if it has no time.
        instants: Vec<f64>,
    },
    /// Pictures over the same time axis, one under the other.
    Figure {
        /// What they show.
        caption: String,
        /// The pictures.
        pictures: Vec<Picture>,
    },
    /// Text as it is, such as a configuration.
    Verbatim {
        /// What it is.
        caption: String,
        /// The text.
        text: String,
    },
}

/// Zooms all pictures over time together and reads their values. What they draw, where, in which unit and by which scale, they
/// say themselves; without the script they stand as drawn.
const SCRIPT: &str = concat!(
    "(() => {\n",
    include_str!("page/signal.js"),
    include_str!("page/picture.js"),
    include_str!("page/view.js"),
    "})();"
);

/// How the pictures over time are used; the script shows it, as it needs it.
const KEYS: &str = "Pictures over time share one view. Drag over a stretch, or turn the wheel with Shift, to zoom; double-click to \
                    see all. With a figure in focus: plus and minus zoom, the arrows move, 0 shows all; comma and full stop move \
                    the cross-hair, Shift and the arrows faster; Escape hides it. By touch: one finger moves, two stretch.";

const LAYOUT: &str = r#"
*{box-sizing:border-box}
:root{color-scheme:light dark;--page:#fff;--soft:#f4f6f8;--muted:#51606f;--link:#005a9c;--more:#51606f66}
@media(prefers-color-scheme:dark){:root{--page:#12181f;--soft:#1b242d;--muted:#a4b2c0;--link:#7cc4ff;--more:#a4b2c066}}
body{overflow-wrap:anywhere;margin:0 auto;padding:1.5rem clamp(1rem,4vw,3rem) 3rem;max-width:82rem;background:var(--page);color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
h1{font-size:1.6rem;line-height:1.25;margin:0 0 .5rem}h2{font-size:1.2rem;margin:2.5rem 0 .75rem;padding-top:.5rem;border-top:1px solid var(--grid)}
.summary{font-size:1.1rem;margin:.25rem 0 1rem}
nav ul{display:flex;flex-wrap:wrap;gap:.25rem 1.25rem;list-style:none;margin:0;padding:0}
a{color:var(--link)}a:focus-visible,summary:focus-visible,.scroll:focus-visible,th button:focus-visible{outline:3px solid var(--link);outline-offset:2px}
figure{margin:1.25rem 0}figcaption,.caption{color:var(--muted);margin:1.5rem 0 .3rem;font-size:.95rem}
.scroll{overflow-x:auto;background:linear-gradient(90deg,var(--page) 40%,transparent) left/2.5rem,linear-gradient(270deg,var(--page) 40%,transparent) right/2.5rem,linear-gradient(90deg,var(--more),transparent) left/1rem,linear-gradient(270deg,var(--more),transparent) right/1rem;background-repeat:no-repeat;background-attachment:local,local,scroll,scroll}
svg:not(.time)>.plot{overflow:visible}.pictures>svg{display:block;width:100%;min-width:800px;height:auto}.fits>svg.time{min-width:0}
svg text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1.25rem;list-style:none;margin:.2rem 0;padding:0;font-size:.9rem}
.legend i{display:inline-block;width:1.4rem;height:.7rem;margin-right:.45rem;vertical-align:baseline;border-radius:2px}
.legend i.limit{height:0;border-top:3px dashed var(--limit);background:none;vertical-align:middle}.legend i.band{opacity:.35}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.95rem}
th,td{padding:.35rem .8rem;text-align:right;border-bottom:1px solid var(--grid);white-space:nowrap}
th:first-child,td:first-child{text-align:left}thead th{border-bottom:2px solid var(--muted)}
pre{background:var(--soft);padding:1rem;overflow-x:auto;font-size:.85rem;line-height:1.4}
footer{margin-top:3rem;color:var(--muted);font-size:.9rem}
.keys{color:var(--muted);font-size:.9rem;margin:.75rem 0 0}.pictures{touch-action:pan-x pan-y}.pictures.zoomed{touch-action:pan-y}
.cross{stroke:var(--ink);stroke-opacity:.6;pointer-events:none}.picked{fill:var(--link);fill-opacity:.2;pointer-events:none}
.read{position:fixed;inset:auto 0 0 0;display:flex;flex-wrap:wrap;justify-content:center;gap:0 1.25rem;padding:.4rem 1rem;background:var(--soft);border-top:1px solid var(--grid);font-size:.9rem;font-variant-numeric:tabular-nums}.read[hidden]{display:none}
@media(max-width:40rem){tbody th{white-space:normal;min-width:9rem}}
th button{font:inherit;color:var(--link);background:none;border:0;padding:0;cursor:pointer;text-decoration:underline}
@media print{body{max-width:none;padding:0;font-size:11pt}nav,.keys,.read{display:none}h2,.caption,figcaption,.legend{break-after:avoid}figure,table,.caption,.pictures>svg{break-inside:avoid}table{font-size:8pt;overflow-wrap:normal}th,td{white-space:normal;padding:.25rem .4rem}.legend i{print-color-adjust:exact;-webkit-print-color-adjust:exact}.scroll{overflow:visible;background:none}.pictures>svg{min-width:0}}
"#;

impl Section {
    /// A section.
    #[must_use]
    pub fn new(heading: &str, blocks: Vec<Block>) -> Self {
        Section { heading: heading.to_owned(), blocks }
    }
}

impl Page {
    /// The page as HTML.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut html = String::with_capacity(1 << 20);
        let title = escaped(&self.title);
        let _ = write!(
            html,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
             <style>{STYLE}{LAYOUT}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<p class=\"summary\">{}</p>\n",
            escaped(&self.summary)
        );
        html.push_str("<nav aria-label=\"Sections\"><ul>\n");
        for (k, section) in self.sections.iter().enumerate() {
            let _ = writeln!(html, "<li><a href=\"#s{k}\">{}</a></li>", escaped(&section.heading));
        }
        html.push_str("</ul></nav>\n");
        let _ = write!(html, "<p id=\"keys\" class=\"keys\" hidden>{KEYS}</p>\n</header>\n<main>\n");
        for (k, section) in self.sections.iter().enumerate() {
            let _ = writeln!(html, "<section id=\"s{k}\">\n<h2>{}</h2>", escaped(&section.heading));
            section.blocks.iter().for_each(|block| block.write(&mut html));
            html.push_str("</section>\n");
        }
        let _ = write!(
            html,
            "</main>\n<footer>{}</footer>\n<script>{SCRIPT}</script>\n</body>\n</html>\n",
            escaped(&self.footer)
        );
        html
    }
}

impl Block {
    fn write(&self, html: &mut String) {
        match self {
            Block::Paragraph(text) => {
                let _ = writeln!(html, "<p>{}</p>", escaped(text));
            }
            Block::Table { caption, header, rows, instants } => write_table(html, caption, header, rows, instants),
            Block::Figure { caption, pictures } => write_figure(html, caption, pictures),
            Block::Verbatim { caption, text } => {
                let (caption, text) = (escaped(caption), escaped(text));
                let _ = writeln!(html, "<details><summary>{caption}</summary><pre>{text}</pre></details>");
            }
        }
    }
}

fn write_table(html: &mut String, caption: &str, header: &[String], rows: &[Vec<String>], instants: &[f64]) {
    let caption = escaped(caption);
    let _ = write!(
        html,
        "<p class=\"caption\">{caption}</p>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n<thead><tr>"
    );
    for cell in header {
        let _ = write!(html, "<th scope=\"col\">{}</th>", escaped(cell));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for (n, row) in rows.iter().enumerate() {
        html.push_str("<tr>");
        let at = instants.get(n).map(|t_s| format!(" data-at=\"{t_s}\"")).unwrap_or_default();
        for (k, cell) in row.iter().enumerate() {
            let cell = escaped(cell);
            let _ = match k {
                0 => write!(html, "<th scope=\"row\"{at}>{cell}</th>"),
                _ => write!(html, "<td>{cell}</td>"),
            };
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table>\n</div>\n");
}

fn write_figure(html: &mut String, caption: &str, pictures: &[Picture]) {
    let caption = escaped(caption);
    let _ = writeln!(html, "<figure>\n<figcaption>{caption}</figcaption>");
    let legend = pictures.iter().flat_map(|p| &p.legend);
    let mut seen = Vec::new();
    html.push_str("<ul class=\"legend\">");
    for (swatch, name) in legend {
        if seen.contains(&(*swatch, name)) {
            continue;
        }
        seen.push((*swatch, name));
        let class = match swatch {
            crate::chart::Swatch::Limit => " class=\"limit\"",
            crate::chart::Swatch::Band => " class=\"band\"",
            crate::chart::Swatch::Series(_) => "",
        };
        let _ = write!(html, "<li><i{class} style=\"background:{}\"></i>{}</li>", swatch.colour(), escaped(name));
    }
    html.push_str("</ul>\n");
    let _ = writeln!(html, "<div class=\"scroll pictures\" tabindex=\"0\" role=\"group\" aria-label=\"{caption}\">");
    for picture in pictures {
        html.push_str(&picture.svg);
        html.push('\n');
    }
    html.push_str("</div>\n</figure>\n");
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Swatch;

    fn page() -> String {
        let picture = Picture { svg: "<svg></svg>".to_owned(), legend: vec![(Swatch::Limit, "threshold".to_owned())] };
        let table = Block::Table {
            caption: "Table 1".to_owned(),
            header: vec!["fault".to_owned(), "at, s".to_owned()],
            rows: vec![vec!["<F1>".to_owned(), "20.02".to_owned()]],
            instants: vec![20.02],
        };
        let figure = Block::Figure { caption: "Figure 6".to_owned(), pictures: vec![picture.clone(), picture] };
        let section = Section { heading: "Results & tables".to_owned(), blocks: vec![table, figure] };
        Page { title: "Mission \"x\"".to_owned(), sections: vec![section], ..Page::default() }.to_html()
    }

    #[test]
    fn text_is_escaped_wherever_it_stands() {
        let html = page();
        assert!(
            html.contains("&lt;F1&gt;")
                && html.contains("Results &amp; tables")
                && html.contains("Mission &quot;x&quot;")
        );
        assert!(!html.contains("<F1>"));
    }

    #[test]
    fn the_page_needs_nothing_from_outside() {
        let html = page();
        for outside in ["http:/", "https", "src=", "<link", "import", "fetch", "XMLHttp"] {
            assert!(!html.contains(outside), "{outside}");
        }
    }

    #[test]
    fn a_legend_names_each_entry_once_for_all_pictures_of_a_figure() {
        assert_eq!(page().matches("threshold").count(), 1);
    }

    #[test]
    fn a_row_of_a_table_says_when_it_was() {
        assert!(page().contains("<th scope=\"row\" data-at=\"20.02\">&lt;F1&gt;</th>"));
    }

    #[test]
    fn sections_can_be_reached_from_the_top() {
        let html = page();
        assert!(html.contains("href=\"#s0\"") && html.contains("id=\"s0\""));
    }
}
