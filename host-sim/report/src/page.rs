//! The page and its blocks.

use crate::escape::{html, json};
use crate::figure::Figure;
use crate::table::Table;
use serde_json::Value;
use std::fmt::Write as _;

/// A page: a title, a few sentences with the most important results, and blocks from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// Sentences under the title.
    pub lead: Vec<String>,
    /// Blocks below the sentences.
    pub blocks: Vec<Block>,
}

/// A part of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Words(String),
    /// A list.
    List(Vec<String>),
    /// Moments in the viewer: an address within the page, such as `#t=0.4&joint=2`, and a description.
    Moments(Vec<(String, String)>),
    /// Names with their descriptions.
    Facts(Vec<(String, String)>),
    /// Preformatted terminal output.
    Terminal(String),
    /// A table.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// One or two runs on a time axis, with their arms. `host-sim/report/web/src/runs.js` documents the value.
    Viewer(Value),
    /// A session while it runs, with the stop button; the page's server sends the state. `host-sim/report/web/src/live.js` documents the value.
    Live(Value),
    /// A JSON text that other programs can read from the page by its HTML id.
    Data {
        /// HTML id.
        id: &'static str,
        /// JSON text.
        json: String,
    },
}

/// Style sheet of every page.
const STYLE: &str = include_str!("../assets/report.css");
/// Script of every page: copies a point's command.
const POINTS: &str = include_str!("../assets/points.js");
/// Script of pages with a viewer.
const VIEWER: &str = include_str!("../assets/viewer.js");
/// Style sheet of uPlot.
const CHARTS: &str = include_str!("../assets/uplot.css");
/// Licences of third-party code in the scripts.
const LICENCES: &str = include_str!("../assets/LICENCES.txt");

/// Id of the viewer's data, which `newtau report` reads back.
pub const VIEWER_DATA: &str = "viewer-data";

/// Id of a live page's data.
const LIVE_DATA: &str = "live-data";

impl Page {
    /// Returns the whole file. It loads nothing from outside, and its content security policy forbids that.
    #[must_use]
    pub fn html(&self) -> String {
        let viewer = self.blocks.iter().any(|block| matches!(block, Block::Viewer(_) | Block::Live(_)));
        // A live page asks the server that it came from, and nobody else.
        let connects = match self.blocks.iter().any(|block| matches!(block, Block::Live(_))) {
            true => "; connect-src 'self'",
            false => "",
        };
        let title = html(&self.title);
        let mut out = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:{connects}\">\n\
             <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{STYLE}"
        );
        if viewer {
            out.push_str(CHARTS);
        }
        let _ = write!(out, "</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n");
        for sentence in &self.lead {
            let _ = writeln!(out, "<p class=\"lead\">{}</p>", html(sentence));
        }
        out.push_str("</header>\n<main>\n");
        for block in &self.blocks {
            block.write(&mut out);
        }
        out.push_str("</main>\n<footer>");
        if viewer {
            let _ = write!(
                out,
                "<details><summary>Licences of parts of this page</summary><pre>{}</pre></details>",
                html(LICENCES)
            );
        }
        let _ = write!(out, "</footer>\n<script>{POINTS}</script>\n");
        if viewer {
            let _ = writeln!(out, "<script>{VIEWER}</script>");
        }
        out.push_str("</body>\n</html>\n");
        out
    }
}

impl Block {
    fn write(&self, out: &mut String) {
        let _ = match self {
            Self::Heading(text) => writeln!(out, "<h2>{}</h2>", html(text)),
            Self::Words(text) => writeln!(out, "<p>{}</p>", html(text)),
            Self::Terminal(text) => writeln!(out, "<pre class=\"terminal\" tabindex=\"0\">{}</pre>", html(text)),
            Self::List(lines) => {
                let lines: String = lines.iter().map(|line| format!("<li>{}</li>", html(line))).collect();
                writeln!(out, "<ul>{lines}</ul>")
            }
            Self::Moments(moments) => {
                let moment =
                    |(to, text): &(String, String)| format!("<li><a href=\"{}\">{}</a></li>", html(to), html(text));
                writeln!(out, "<ul>{}</ul>", moments.iter().map(moment).collect::<String>())
            }
            Self::Facts(facts) => {
                let fact = |(name, text): &(String, String)| format!("<dt>{}</dt><dd>{}</dd>", html(name), html(text));
                writeln!(out, "<dl>{}</dl>", facts.iter().map(fact).collect::<String>())
            }
            Self::Table(table) => return table.write(out),
            Self::Figure(figure) => return figure.write(out),
            Self::Viewer(value) => {
                out.push_str("<section id=\"viewer\" aria-label=\"Motion and curves\"><noscript>The arm and its curves need scripts; the tables do not.</noscript></section>\n");
                return data(out, VIEWER_DATA, &value.to_string());
            }
            Self::Live(value) => {
                out.push_str("<section id=\"live\" aria-label=\"The session\"><noscript>This page needs scripts.</noscript></section>\n");
                return data(out, LIVE_DATA, &value.to_string());
            }
            Self::Data { id, json } => return data(out, id, json),
        };
    }
}

fn data(out: &mut String, id: &str, text: &str) {
    let _ = writeln!(out, "<script type=\"application/json\" id=\"{id}\">{}</script>", json(text));
}

/// Returns the JSON text with this id in a page; `None` if there is none.
#[must_use]
pub fn data_in<'a>(page: &'a str, id: &str) -> Option<&'a str> {
    let open = format!("<script type=\"application/json\" id=\"{id}\">");
    let from = page.find(&open)? + open.len();
    let length = page[from..].find("</script>")?;
    Some(&page[from..from + length])
}

#[cfg(test)]
mod tests {
    use super::{Block, Page, VIEWER_DATA, data_in};
    use serde_json::{Value, json};

    fn page(blocks: Vec<Block>) -> String {
        Page { title: "<b> & co".to_owned(), lead: vec!["All is well.".to_owned()], blocks }.html()
    }

    #[test]
    fn data_can_be_read_back_and_cannot_end_its_script() {
        let value = json!({ "name": "</script><script>alert(1)</script>" });
        let text = page(vec![Block::Viewer(value.clone())]);
        assert!(!text.contains("<script>alert"));
        let found: Value = serde_json::from_str(data_in(&text, VIEWER_DATA).unwrap()).unwrap();
        assert_eq!(found, value);
        assert_eq!(data_in(&text, "another"), None);
    }

    #[test]
    fn a_page_asks_for_nothing_from_outside_and_only_a_viewer_brings_its_scripts() {
        let plain = page(vec![Block::Words("x".to_owned())]);
        assert!(plain.len() < 40_000, "{}", plain.len());
        assert!(plain.contains("<title>&lt;b&gt; &amp; co</title>") && plain.contains("default-src 'none'"));
        let viewer = page(vec![Block::Viewer(json!({}))]);
        assert!(viewer.len() > plain.len() + 100_000);
        for text in [&plain, &viewer] {
            for asks in [" src=\"http", " href=\"http", "@import", "url(http"] {
                assert!(!text.contains(asks), "{asks}");
            }
        }
    }
}
