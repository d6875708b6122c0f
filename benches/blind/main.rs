//! Blind tests at length: sets of data with effects hidden by seed, and what the program makes of them.
//!
//! ```text
//! cargo bench --bench blind -- generate --out DIR [--effects all|NAME,...] [--machines N] [--skip N] [--strength 1|0.5] [--seeds FIRST] [--arms NAME,...] [--rough 0,0.5,1]
//! cargo bench --bench blind -- judge SET...
//! cargo bench --bench blind -- separate SET...
//! cargo bench --bench blind -- table [--effects ...] [--machines N] [--thorough N] [--clean N] [--pairs N] [--changes N] [--seeds FIRST]
//!                                          [--field N] [--field-clean N] [--arms planar,six_joints] [--rough 0,0.5,1]
//! ```
//! A set is a folder with `model.toml`, `robot.urdf` and four recordings; what was hidden stands in `truth/<set>.json` beside it.
//! It is drawn by the same modules as the sets of `benches/hidden_effects`. `table` keeps no data; see `docs/blind.md`. Seeds below 100000 are for tuning, those from 900000 for reports.

#[path = "../../tests/support/drawn/arm.rs"]
mod arm;
#[path = "../../tests/support/drawn/drawn.rs"]
mod drawn;
#[path = "../../tests/support/drawn/generate.rs"]
mod generate;
#[path = "../../tests/support/drawn/hidden.rs"]
mod hidden;
#[path = "../../tests/support/drawn/machine.rs"]
mod machine;
#[path = "../../tests/support/drawn/motion.rs"]
mod motion;
#[path = "../../tests/support/drawn/record.rs"]
mod record;
#[path = "../../tests/support/rough.rs"]
mod rough;
#[path = "../../tests/support/drawn/sampling.rs"]
mod sampling;
#[path = "../../tests/support/six_joints.rs"]
mod six_joints;
#[path = "../../tests/support/drawn/strengths.rs"]
mod strengths;
#[path = "../../tests/support/drawn/verdict.rs"]
mod verdict;

mod arguments;
mod calibration;
mod case;
mod comparison;
mod field;
mod orders;
mod separate;
mod share;
mod side_by_side;
mod table;

use std::path::{Path, PathBuf};

use arguments::{Arguments, Command};
use case::Case;
use comparison::Comparison;
use field::FieldTable;
use generate::Set;
use hidden::Field;
use lostmotion::diagnose::Options;
use orders::Plan;
use side_by_side::side_by_side;
use table::Table;
use verdict::Truth;

fn main() {
    // What the generating process is started for.
    if std::env::args().nth(1).as_deref() == Some(GENERATE_ONE) {
        return generate::as_told();
    }
    let arguments = match Arguments::read() {
        Ok(Some(arguments)) => arguments,
        Ok(None) => return println!("{}", arguments::USAGE),
        Err(message) => {
            eprintln!("{message}\n{}", arguments::USAGE);
            std::process::exit(2);
        }
    };
    match &arguments.command {
        Command::Generate => generate(&arguments),
        Command::Judge(folders) => judge(folders),
        Command::Separate(folders) => separate(folders),
        Command::Table => table(&arguments),
    }
}

/// Argument of the process that makes one set.
const GENERATE_ONE: &str = "generate-one";

fn generate(arguments: &Arguments) {
    let fields = arguments.fields();
    let of_field = fields.iter().flat_map(|field| Plan::of(arguments, Some(*field)).orders());
    let orders = if fields.is_empty() { Plan::of(arguments, None).orders() } else { of_field.collect() };
    side_by_side(
        &orders,
        |order| generate::in_own_process(&[GENERATE_ONE], &arguments.out, order),
        |order, _| {
            println!("{}", order.name());
        },
    );
}

fn judge(folders: &[PathBuf]) {
    let judged = |folder: &PathBuf| {
        let (name, set) = set_of(folder);
        verdict::verdict(&name, &set, &Options::default())
    };
    side_by_side(folders, judged, |_, verdict| println!("{}", verdict.line()));
}

fn separate(folders: &[PathBuf]) {
    let separated = |folder: &PathBuf| {
        let (name, set) = set_of(folder);
        let Truth { effects, hidden, .. } = verdict::truth(&set.truth);
        separate::line(&name, &effects, &separate::separabilities(&set, &effects, &hidden))
    };
    side_by_side(folders, separated, |_, line| println!("{line}"));
}

fn table(arguments: &Arguments) {
    let seeds = arguments.seeds;
    let plan = |effects: &[String], machines: u64, strength: f64, field: Option<Field>| {
        Plan { effects, machines: 0..machines, strength, seeds, field }.orders()
    };
    let Arguments { effects, machines, .. } = arguments;
    let (none, pairs) = (["none".to_owned()], ["pairs".to_owned()]);
    let laboratory = [
        plan(effects, *machines, 1.0, None),
        plan(effects, *machines, 0.5, None),
        plan(&none, arguments.clean, 0.0, None),
        plan(&pairs, arguments.pairs, 1.0, None),
    ]
    .concat();
    let of_field = |field: Field| {
        let healthy = plan(&none, arguments.field_clean, 0.0, Some(field));
        [healthy, plan(effects, arguments.field, 1.0, Some(field))].concat()
    };
    let in_field = arguments.fields().into_iter().flat_map(of_field).collect();
    let orders = [laboratory, in_field].concat();
    let thorough = |order: &hidden::Order| order.field.is_none() && Plan::number(order) < arguments.thorough;
    let cases = side_by_side(&orders, |order| Case::new(order, thorough(order)), |_, case| log(case));
    let later = orders::later(seeds, arguments.changes);
    let comparisons = side_by_side(&later, Comparison::new, |_, comparison| eprintln!("{}", comparison.line()));
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    println!("`cargo bench --bench blind -- {}`\n", words.join(" "));
    let nats = Options::default().rules.nats;
    if cases.iter().any(|case| case.order.field.is_none()) || !comparisons.is_empty() {
        println!("{}", Table { cases: &cases, comparisons: &comparisons, nats }.text());
    }
    println!("{}", FieldTable { cases: &cases, nats }.text());
}

fn log(case: &Case) {
    eprintln!("{}", case.verdict.line());
    eprintln!("      {}", separate::line("told", &case.order.effects, &case.told));
    if let Some(left_out) = &case.left_out {
        let named: Vec<&str> = left_out.found.iter().map(|found| found.effect.as_str()).collect();
        let unexplained = if left_out.unexplained.is_empty() { "" } else { "; something unexplained" };
        eprintln!("      out of the catalogue: named {}{unexplained}", named.join(", "));
    }
}

fn set_of(folder: &Path) -> (String, Set) {
    let name = folder.file_name().expect("a set").to_string_lossy().into_owned();
    let set = Set::at(folder.parent().unwrap_or(Path::new(".")), &name);
    (name, set)
}
