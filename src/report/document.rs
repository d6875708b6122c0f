//! A result for readers: one content, rendered on the terminal, as HTML and as a recording.

use super::plot::Plot;
use super::table::Table;

/// Title, verdict, and sections of text, tables and plots.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document {
    /// The task and the machine.
    pub title: String,
    /// The result, a sentence in each line.
    pub verdict: String,
    /// Warnings that the reader needs before using the result.
    pub warnings: Vec<String>,
    /// The sections, most important first.
    pub sections: Vec<Section>,
    /// The joint whose curves are in front when a recording is opened; its first one where there is none.
    pub in_front: Option<String>,
}

/// A part of a document.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// Plain paragraphs.
    pub text: Vec<String>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Plots; not on the terminal.
    pub plots: Vec<Plot>,
    /// Whether it contains details: these are not shown on the terminal.
    pub detail: bool,
}

impl Section {
    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Whether it has text or tables.
    fn has_words(&self) -> bool {
        !self.text.is_empty() || !self.tables.is_empty()
    }
}

impl Document {
    /// The text for the terminal: title, verdict, texts and tables.
    pub fn to_text(&self) -> String {
        let mut text = format!("{}\n\n{}\n", self.title, self.verdict);
        for section in self.sections.iter().filter(|section| !section.detail && section.has_words()) {
            text += &format!("\n{}\n", section.title);
            section.text.iter().for_each(|paragraph| text += &format!("{paragraph}\n"));
            section.tables.iter().for_each(|table| text += &format!("\n{}", table.to_text()));
        }
        text
    }

    /// Title, verdict, texts and tables as Markdown.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("# {}\n\n", self.title);
        self.verdict.lines().for_each(|line| text += &format!("**{line}**\n\n"));
        self.warnings.iter().for_each(|warning| text += &format!("> {warning}\n\n"));
        for section in self.sections.iter().filter(|section| section.has_words()) {
            text += &format!("## {}\n\n", section.title);
            section.text.iter().for_each(|paragraph| text += &format!("{paragraph}\n\n"));
            section.tables.iter().for_each(|table| text += &table.to_markdown());
        }
        text
    }

    /// Every plot, with the heading of its section.
    pub fn plots(&self) -> impl Iterator<Item = (&str, &Plot)> {
        self.sections.iter().flat_map(|section| section.plots.iter().map(|plot| (section.title.as_str(), plot)))
    }
}
