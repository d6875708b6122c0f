//! The import rule of ARCHITECTURE.md, read from there and checked over the source.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates that every module may name: the language that all of them speak.
const FREE: [&str; 8] = ["nalgebra", "rand", "rand_chacha", "rand_distr", "rayon", "serde", "serde_json", "thiserror"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A source file without comments and literals, and the module that it is.
struct Source {
    file: PathBuf,
    /// Path of the module, `["robot", "tree"]` for `src/robot/tree.rs` and `["robot"]` for `src/robot/mod.rs`.
    path: Vec<String>,
    code: String,
}

impl Source {
    /// Name of the module below `parent` that it belongs to, for a source that lies below.
    fn below(&self, parent: &[&str]) -> Option<&str> {
        let below = self.path.iter().zip(parent).all(|(own, other)| own == other) && self.path.len() > parent.len();
        below.then(|| self.path[parent.len()].as_str())
    }
}

fn sources() -> Vec<Source> {
    let folder = root().join("src");
    let mut files = Vec::new();
    collect(&folder, &mut files);
    files.sort();
    let source = |file: PathBuf| {
        let path = file.strip_prefix(&folder).unwrap().with_extension("");
        let mut path: Vec<String> = path.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
        path.pop_if(|last| last == "mod");
        let code = code_of(&fs::read_to_string(&file).unwrap());
        Source { path, code, file }
    };
    files.into_iter().map(source).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The text with its comments and literals blanked.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skip = literal_length(rest, code.chars().last()).unwrap_or(0);
        let length = if skip > 0 { skip } else { first.len_utf8() };
        code.push_str(if skip > 0 { " " } else { &rest[..length] });
        rest = &rest[length..];
    }
    code
}

/// Length of the comment or literal that a text begins with.
fn literal_length(text: &str, before: Option<char>) -> Option<usize> {
    let until = |start: usize, end: &str| text[start..].find(end).map_or(text.len(), |at| start + at + end.len());
    if text.starts_with("//") {
        return Some(text.find('\n').unwrap_or(text.len()));
    }
    if text.starts_with("/*") {
        return Some(until(2, "*/"));
    }
    if text.starts_with('r') && !before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
        let hashes = text[1..].chars().take_while(|&c| c == '#').count();
        if text[1 + hashes..].starts_with('"') {
            return Some(until(2 + hashes, &format!("\"{}", "#".repeat(hashes))));
        }
    }
    if let Some(inside) = text.strip_prefix('"') {
        let mut escaped = false;
        let end = inside.find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        return Some(end.map_or(text.len(), |at| at + 2));
    }
    // A character, not a lifetime: 'x' or '\...'.
    let mut characters = text.strip_prefix('\'')?.chars();
    match characters.next()? {
        '\\' => Some(until(3, "'")),
        c if characters.next() == Some('\'') => Some(2 + c.len_utf8()),
        _ => None,
    }
}

/// Names of the modules below `parent` (none: at the root of the crate) that a source names.
fn named(source: &Source, parent: &[&str]) -> BTreeSet<String> {
    let absolute: String =
        std::iter::once("crate").chain(parent.iter().copied()).map(|name| format!("{name}::")).collect();
    let relative = "super::".repeat(source.path.len() - parent.len());
    [absolute, relative].iter().flat_map(|prefix| after(&source.code, prefix)).collect()
}

/// What follows a prefix: a name, or all names of a group in braces.
fn after(code: &str, prefix: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        if code[..at].chars().last().is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        match rest.strip_prefix('{') {
            None => found.push(name(rest)),
            Some(group) => found.extend(heads(group)),
        }
    }
    found
}

/// First names of the members of a group, up to its closing brace.
fn heads(group: &str) -> Vec<String> {
    let mut found = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                found.push(name(group[start..at].trim_start()));
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    found
}

fn name(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Place of every module in the rule of a section: its group from the left, and its column among siblings.
fn rule(section: &str) -> BTreeMap<String, (usize, usize)> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let section = text.split_once(&format!("## {section}")).unwrap_or_else(|| panic!("no section `{section}`")).1;
    let block = section.split("```").nth(1).expect("the rule in a code block").trim_start_matches("text");
    let mut places = BTreeMap::new();
    for (group, siblings) in block.split('<').enumerate() {
        for (column, names) in siblings.split('|').enumerate() {
            for name in names.split(',') {
                places.insert(name.trim().to_owned(), (group, column));
            }
        }
    }
    places
}

/// Holds the modules below `parent` to the rule of a section.
fn hold_to(section: &str, parent: &[&str]) {
    let rule = rule(section);
    let mut broken = Vec::new();
    let mut seen = BTreeSet::new();
    for source in &sources() {
        let Some(module) = source.below(parent).filter(|module| !["lib", "main"].contains(module)) else { continue };
        let place = rule.get(module).unwrap_or_else(|| panic!("`{module}` is not in the rule"));
        seen.insert(module.to_owned());
        for other in named(source, parent) {
            let Some(there) = rule.get(&other) else { continue };
            if there.0 > place.0 || (there.0 == place.0 && there.1 != place.1) {
                broken.push(format!("{} names `{other}`", source.file.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert_eq!(seen, rule.into_keys().collect(), "the rule and the folders of src differ");
}

#[test]
fn property_modules_import_only_what_stands_to_their_left() {
    hold_to("Import rule", &[]);
}

#[test]
fn property_stages_of_a_diagnosis_import_only_earlier_ones() {
    hold_to("Stages of a diagnosis", &["diagnose"]);
}

#[test]
fn property_every_third_party_crate_has_one_door() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let table = manifest.split_once("[dependencies]").unwrap().1.split("\n[").next().unwrap();
    let dependencies = table.lines().filter_map(|line| line.split_once(" = ")).map(|(name, _)| name.replace('-', "_"));
    let sources = sources();
    for dependency in dependencies.filter(|name| !FREE.contains(&name.as_str())) {
        let names_it = |source: &&Source| {
            let used = |at: usize| !source.code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            source.code.match_indices(&format!("{dependency}::")).any(|(at, _)| used(at))
        };
        let doors: BTreeSet<&str> = sources.iter().filter(names_it).filter_map(|source| source.below(&[])).collect();
        assert!(doors.len() <= 1, "{dependency} is named by {doors:?}");
    }
}

/// rapier3d passes parry3d on under a name of its own: that is no second door.
#[test]
fn property_nobody_reaches_parry_through_rapier() {
    let through: Vec<PathBuf> = sources()
        .into_iter()
        .filter(|source| source.code.contains("::parry::") || source.code.contains("parry::{"))
        .map(|source| source.file)
        .collect();
    assert!(through.is_empty(), "{through:?}");
}

#[test]
fn property_the_check_sees_what_it_should() {
    let code = code_of(
        "use crate::{drive::Motor, error::{Error, Result}, units};\n// crate::cli\nlet x: &'a str = \"crate::report\";\n\
         let c = '\"'; super::super::plant::f(); let r = r#\"crate::scenario \" \"#; /* crate::dataset */",
    );
    let source = Source { file: PathBuf::new(), path: ["robot", "tree"].map(str::to_owned).into(), code };
    assert_eq!(named(&source, &[]), ["drive", "error", "units", "plant"].map(str::to_owned).into());
    assert_eq!(source.below(&["robot"]), Some("tree"));
    assert_eq!(source.below(&["drive"]), None);

    let code = code_of(
        "use crate::diagnose::fit::problem::Problem; use super::super::rows::{kernel::Kernel, zones}; super::own();",
    );
    let source =
        Source { file: PathBuf::new(), path: ["diagnose", "select", "confirm"].map(str::to_owned).into(), code };
    assert_eq!(named(&source, &["diagnose"]), ["fit", "rows"].map(str::to_owned).into());
}
