//! Tables: one content, rendered as aligned text, HTML and Markdown.

use std::fmt::Write as _;

use super::markup::escape;

/// A table of text cells. The first column and columns of words are aligned left, columns of numbers right.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Its caption; may be empty.
    pub title: String,
    /// Heads of the columns.
    pub heads: Vec<String>,
    /// Rows, each as long as the heads.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(title: impl Into<String>, heads: &[&str]) -> Self {
        Self { title: title.into(), heads: heads.iter().map(|&head| head.to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells stay empty, surplus ones are dropped.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        let mut row: Vec<String> = cells.into_iter().map(Into::into).collect();
        row.resize(self.heads.len(), String::new());
        self.rows.push(row);
    }

    /// Without the columns that are empty in every row.
    #[must_use]
    pub fn trimmed(mut self) -> Self {
        let used: Vec<bool> =
            (0..self.heads.len()).map(|column| self.rows.iter().any(|row| !row[column].is_empty())).collect();
        let keep = |cells: &mut Vec<String>| {
            let mut used = used.iter();
            cells.retain(|_| *used.next().unwrap_or(&true));
        };
        keep(&mut self.heads);
        self.rows.iter_mut().for_each(keep);
        self
    }

    /// Whether a column holds words.
    fn is_left(&self, column: usize) -> bool {
        let word = |cell: &str| cell.starts_with(|first: char| first.is_alphabetic());
        column == 0 || self.rows.iter().any(|row| word(&row[column]))
    }

    /// Aligned plain text with a rule below the heads.
    pub fn to_text(&self) -> String {
        let widths: Vec<usize> = (0..self.heads.len())
            .map(|column| {
                let cells = self.rows.iter().map(|row| &row[column]).chain([&self.heads[column]]);
                cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        let line = |cells: &[String]| {
            let mut text = String::new();
            for (column, (cell, &width)) in cells.iter().zip(&widths).enumerate() {
                let gap = if column == 0 { "" } else { "  " };
                let _ = if self.is_left(column) {
                    write!(text, "{gap}{cell:<width$}")
                } else {
                    write!(text, "{gap}{cell:>width$}")
                };
            }
            text.trim_end().to_owned() + "\n"
        };
        let mut text = if self.title.is_empty() { String::new() } else { format!("{}\n", self.title) };
        text += &line(&self.heads);
        let rule = widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1);
        text += &("─".repeat(rule) + "\n");
        self.rows.iter().for_each(|row| text += &line(row));
        text
    }

    /// An HTML table.
    pub fn to_html(&self) -> String {
        let cells = |tag: &str, cells: &[String]| {
            cells.iter().enumerate().fold(String::new(), |row, (column, cell)| {
                let class = if self.is_left(column) { " class=\"word\"" } else { "" };
                row + &format!("<{tag}{class}>{}</{tag}>", escape(cell))
            })
        };
        let mut html = String::from("<table>\n");
        if !self.title.is_empty() {
            let _ = writeln!(html, "<caption>{}</caption>", escape(&self.title));
        }
        let _ = writeln!(html, "<thead><tr>{}</tr></thead>\n<tbody>", cells("th", &self.heads));
        for row in &self.rows {
            let _ = writeln!(html, "<tr>{}</tr>", cells("td", row));
        }
        html + "</tbody>\n</table>\n"
    }

    /// A Markdown table.
    pub fn to_markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | ").replace('\n', " "));
        let mut text = if self.title.is_empty() { String::new() } else { format!("**{}**\n\n", self.title) };
        text += &line(&self.heads);
        (0..self.heads.len()).for_each(|column| text += if self.is_left(column) { "|:--" } else { "|--:" });
        text += "|\n";
        self.rows.iter().for_each(|row| text += &line(row));
        text + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_text_columns_line_up() {
        let mut table = Table::new("", &["name", "injected", "unused", "value"]);
        table.row(["F_C", "0.2718", "", "1"]);
        table.row(["backlash", "0.0082", "", "12"]);
        let text = table.trimmed().to_text();
        assert_eq!(
            text,
            "name      injected  value\n─────────────────────────\nF_C         0.2718      1\nbacklash    0.0082     12\n"
        );
    }
}
