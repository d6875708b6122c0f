//! What is asked of the bench.

use std::path::PathBuf;

use super::hidden::{Arm, Field};
use super::strengths::EFFECTS;

pub const USAGE: &str = "usage: cargo bench --bench blind -- generate --out DIR [--effects all|none|pairs|NAME,...] [--machines N] [--skip N] [--strength S] [--seeds FIRST] [--arms NAME,...] [--rough 0,0.5,1]
       cargo bench --bench blind -- judge SET...
       cargo bench --bench blind -- separate SET...
       cargo bench --bench blind -- table [--effects all|NAME,...] [--machines N] [--thorough N] [--clean N] [--pairs N] [--changes N] [--seeds FIRST] [--field N] [--field-clean N] [--arms planar,six_joints] [--rough 0,0.5,1]";

/// What is to be done.
#[derive(Debug)]
pub enum Command {
    Generate,
    Judge(Vec<PathBuf>),
    Separate(Vec<PathBuf>),
    Table,
}

/// The command and its options.
#[derive(Debug)]
pub struct Arguments {
    pub command: Command,
    /// Names of the catalogue, `none` or `pairs`.
    pub effects: Vec<String>,
    /// Of each.
    pub machines: u64,
    /// How many of each are left out before these.
    pub skip: u64,
    pub strength: f64,
    /// How many of each effect and strength are diagnosed without the effect in the catalogue, and without it in the machine, too.
    pub thorough: u64,
    /// Machines that hide nothing.
    pub clean: u64,
    /// Machines that hide two effects.
    pub pairs: u64,
    /// Machines compared with themselves, for each change and without one.
    pub changes: u64,
    /// Of each effect at strength 1, and without an effect, for each arm and accuracy of the nominal model.
    pub field: u64,
    pub field_clean: u64,
    /// Kinds of machines of the field; none where they are not given.
    pub arms: Vec<Arm>,
    /// [1] Errors of their nominal models in units of the default accuracy.
    pub rough: Vec<f64>,
    /// First seed: see [`super::orders`].
    pub seeds: u64,
    pub out: PathBuf,
}

impl Arguments {
    /// From the command line; `None` where nothing is asked.
    pub fn read() -> Result<Option<Self>, String> {
        let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
        let command = match words.next().as_deref() {
            Some("generate") => Command::Generate,
            Some("judge") => Command::Judge(Vec::new()),
            Some("separate") => Command::Separate(Vec::new()),
            Some("table") => Command::Table,
            // `cargo test --benches` passes options of its own.
            Some(word) if !word.starts_with("--") => return Err(format!("unknown command {word}")),
            _ => return Ok(None),
        };
        let mut arguments = Self {
            command,
            effects: all(),
            machines: 4,
            skip: 0,
            strength: 1.0,
            thorough: 5,
            clean: 20,
            pairs: 20,
            changes: 5,
            field: 0,
            field_clean: 0,
            arms: Vec::new(),
            rough: vec![0.0, 0.5, 1.0],
            seeds: 1000,
            out: PathBuf::from("blind"),
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
            match word.as_str() {
                "--effects" => arguments.effects = effects(&value()?)?,
                "--machines" => arguments.machines = number(&value()?)?,
                "--skip" => arguments.skip = number(&value()?)?,
                "--clean" => arguments.clean = number(&value()?)?,
                "--changes" => arguments.changes = number(&value()?)?,
                "--field" => arguments.field = number(&value()?)?,
                "--field-clean" => arguments.field_clean = number(&value()?)?,
                "--arms" => arguments.arms = value()?.split(',').map(arm).collect::<Result<_, _>>()?,
                "--rough" => arguments.rough = value()?.split(',').map(number).collect::<Result<_, _>>()?,
                "--pairs" => arguments.pairs = number(&value()?)?,
                "--thorough" => arguments.thorough = number(&value()?)?,
                "--strength" => arguments.strength = number(&value()?)?,
                "--seeds" => arguments.seeds = number(&value()?)?,
                "--out" => arguments.out = PathBuf::from(value()?),
                _ => match &mut arguments.command {
                    Command::Judge(folders) | Command::Separate(folders) if !word.starts_with("--") => {
                        folders.push(PathBuf::from(word))
                    }
                    _ => return Err(format!("unknown option {word}")),
                },
            }
        }
        Ok(Some(arguments))
    }
}

impl Arguments {
    /// Every arm with every accuracy of its nominal model.
    pub fn fields(&self) -> Vec<Field> {
        let of = |arm: &Arm| self.rough.iter().map(|&rough| Field { arm: *arm, rough }).collect::<Vec<_>>();
        self.arms.iter().flat_map(of).collect()
    }
}

fn arm(name: &str) -> Result<Arm, String> {
    let names = Arm::ALL.map(Arm::name);
    let known = Arm::ALL.into_iter().find(|arm| arm.name() == name);
    known.ok_or_else(|| format!("{name} is none of {}", names.join(", ")))
}

fn all() -> Vec<String> {
    EFFECTS.map(str::to_owned).into()
}

fn number<T: std::str::FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| format!("{text} is not a number that fits"))
}

fn effects(text: &str) -> Result<Vec<String>, String> {
    if text == "all" {
        return Ok(all());
    }
    let names: Vec<String> = text.split(',').map(str::to_owned).collect();
    let known = |name: &&String| EFFECTS.contains(&name.as_str()) || *name == "none" || *name == "pairs";
    match names.iter().find(|name| !known(name)) {
        Some(name) => Err(format!("{name} is none of none, pairs, {}", EFFECTS.join(", "))),
        None => Ok(names),
    }
}
