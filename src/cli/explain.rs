//! `lostmotion explain EFFECT`.

use std::fmt::Write as _;

use clap::Args;

use crate::effects::{self, Effect, Kind, Scope};
use crate::error::{Error, Place, Result};
use crate::report::Table;
use crate::report::number::significant;
use crate::toml_input::nearest;

use super::{Outcome, console};

/// Explain an effect: equation, signature, look-alikes, and the experiment that separates them
#[derive(Debug, Args)]
pub struct Explain {
    /// Name of the catalogue: `lostmotion list effects`
    effect: String,
}

impl Explain {
    /// Prints the catalogue's description of the effect.
    pub fn run(self) -> Result<Outcome> {
        let Some(effect) = effects::find(&self.effect) else {
            let near = nearest(&self.effect, effects::CATALOGUE.iter().map(|effect| effect.name()));
            let hint = near.map_or_else(String::new, |near| format!(", such as {near}"));
            let expected = format!("a name of the catalogue{hint} (`lostmotion list effects`)");
            return Err(Error::input("command line".as_ref(), Place::File, "EFFECT", self.effect, expected));
        };
        console::print(&render(effect))?;
        Ok(Outcome::Done)
    }
}

fn render(effect: &dyn Effect) -> String {
    let about = effect.about();
    let kind = match about.kind {
        Kind::Physics => "the machine moves differently",
        Kind::Measurement => "the machine moves in the same way, but its sensors read differently",
        Kind::Simulation => "no machine does so: the data come from a simulator with a simpler law",
    };
    let scope = match about.scope {
        Scope::Joint => "one joint",
        Scope::Machine => "the whole machine",
    };
    let diagnosed = match (effect.can_be_told(), effect.needs_link_encoder()) {
        (true, false) => "yes",
        (true, true) => "only with a second encoder behind the gear",
        (false, _) => "not yet: it can only be simulated",
    };
    let mut text = format!("{}: {}\n\n  {}\n\n", about.name, about.summary, about.equation);
    let mut table = Table::new("", &["parameter", "symbol", "unit", "range", "meaning"]);
    for parameter in about.parameters {
        let range = format!("{} … {}", significant(parameter.min, 3), significant(parameter.max, 3));
        table.row([parameter.name, parameter.symbol, parameter.unit, range.as_str(), parameter.meaning]);
    }
    let _ = writeln!(text, "{}", table.to_text());
    let look_alikes = if about.look_alikes.is_empty() { "none known".to_owned() } else { about.look_alikes.join(", ") };
    for (name, content) in [
        ("kind", kind),
        ("acts on", scope),
        ("diagnosed", diagnosed),
        ("signature", about.signature),
        ("look-alikes", &look_alikes),
        ("told apart by", about.separate_by),
        ("reference", about.reference),
    ] {
        let _ = writeln!(text, "{name:<14} {content}");
    }
    text
}
