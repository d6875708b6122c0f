//! A document as one self-contained HTML file, suitable for printing.

use std::fmt::Write as _;

use super::document::{Document, Section};
use super::markup::escape;
use super::svg;

const STYLE: &str = "\
body{font:15px/1.5 Helvetica,Arial,sans-serif;color:#1a1a1a;max-width:1440px;margin:2rem auto;padding:0 1.5rem}\
h1{font-size:1.5rem;margin-bottom:.3rem}h2{font-size:1.15rem;margin-top:2rem;border-bottom:1px solid #ddd}\
.verdict{font-size:1.1rem;border-left:5px solid #0072b2;padding:.5rem 1rem;background:#f3f8fb;white-space:pre-line}\
.warning{border-left:5px solid #d55e00;padding:.3rem 1rem;background:#fdf4ee}\
table{border-collapse:collapse;margin:1rem 0;font-variant-numeric:tabular-nums}\
caption{text-align:left;font-weight:600;padding:.2rem 0}\
th,td{padding:.2rem .8rem;text-align:right;border-bottom:1px solid #e4e4e4}.word{text-align:left}th:first-child,td:first-child{padding-left:0}\
th{border-bottom:2px solid #333}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,560px),1fr));gap:1rem}\
.small{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,400px),1fr));gap:1rem;margin:1rem 0}\
figure{margin:0;break-inside:avoid}svg{width:100%;height:auto}footer{margin-top:3rem;color:#666;font-size:.85rem}\
@media print{body{margin:0;max-width:none;font-size:11px}.plots{grid-template-columns:1fr 1fr}.small{grid-template-columns:1fr 1fr 1fr}}";

/// The page.
pub fn page(document: &Document, footer: &str) -> String {
    let title = escape(&document.title);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p class=\"verdict\">{}</p>\n",
        escape(&document.verdict)
    );
    for warning in &document.warnings {
        let _ = writeln!(html, "<p class=\"warning\">{}</p>", escape(warning));
    }
    document.sections.iter().for_each(|part| html += &section(part));
    let _ = writeln!(html, "<footer>{}</footer>\n</body>\n</html>", escape(footer));
    html
}

fn section(section: &Section) -> String {
    let mut html = format!("<section>\n<h2>{}</h2>\n", escape(&section.title));
    for paragraph in &section.text {
        let _ = writeln!(html, "<p>{}</p>", escape(paragraph));
    }
    section.tables.iter().for_each(|table| html += &table.to_html());
    for (class, small) in [("small", true), ("plots", false)] {
        let plots = section.plots.iter().filter(|plot| plot.small == small && !plot.is_empty());
        let figures = plots.fold(String::new(), |all, plot| all + "<figure>\n" + &svg::draw(plot) + "</figure>\n");
        if !figures.is_empty() {
            let _ = writeln!(html, "<div class=\"{class}\">\n{figures}</div>");
        }
    }
    html + "</section>\n"
}
