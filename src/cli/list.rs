//! `lostmotion list robots|scenarios|effects`.

use clap::{Args, ValueEnum};

use crate::effects;
use crate::error::Result;
use crate::files::catalogue;

use super::{Outcome, console};

/// List the robots, scenarios or effects that the program knows
#[derive(Debug, Args)]
pub struct List {
    /// What to list
    what: What,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum What {
    Robots,
    Scenarios,
    Effects,
}

impl List {
    /// Prints one line per entry, with its name.
    pub fn run(self) -> Result<Outcome> {
        let lines = match self.what {
            What::Robots => described("robots", "model.toml"),
            What::Scenarios => described("scenarios", "scenario.toml"),
            What::Effects => effects::CATALOGUE
                .iter()
                .map(|effect| {
                    let note = match (effect.can_be_told(), effect.needs_link_encoder()) {
                        (true, false) => "",
                        (true, true) => " (diagnosed only with a second encoder behind the gear)",
                        (false, _) => " (simulated, not yet diagnosed)",
                    };
                    (effect.name().to_owned(), format!("{}{note}", effect.about().summary))
                })
                .collect(),
        };
        console::print(&render(&lines))?;
        Ok(Outcome::Done)
    }
}

/// Name and first heading of the README of every entry of a kind.
fn described(kind: &str, file: &str) -> Vec<(String, String)> {
    let heading = |name: &str| {
        let readme = catalogue::text(&format!("{kind}/{name}/README.md")).unwrap_or_default();
        readme.lines().next().unwrap_or_default().trim_start_matches("# ").to_owned()
    };
    catalogue::names(kind, file).into_iter().map(|name| (name.to_owned(), heading(name))).collect()
}

/// Two aligned columns.
fn render(lines: &[(String, String)]) -> String {
    let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    lines.iter().map(|(name, about)| format!("{name:<width$}  {about}").trim_end().to_owned() + "\n").collect()
}
