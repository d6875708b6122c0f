//! The import rule of ARCHITECTURE.md, read from there and checked over the source.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates that every module may name: the language that all of them speak.
const FREE: [&str; 8] = ["nalgebra", "rand", "rand_chacha", "rand_distr", "rayon", "serde", "serde_json", "thiserror"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A source file without comments and literals, and the module that it belongs to.
struct Source {
    file: PathBuf,
    /// Top-level module, `robot` for `src/robot/tree.rs`.
    module: String,
    /// How many modules deep it is: 1 for `src/units.rs` and `src/robot/mod.rs`.
    depth: usize,
    code: String,
}

fn sources() -> Vec<Source> {
    let folder = root().join("src");
    let mut files = Vec::new();
    collect(&folder, &mut files);
    files.sort();
    let source = |file: PathBuf| {
        let path = file.strip_prefix(&folder).unwrap().with_extension("");
        let names: Vec<&str> = path.iter().map(|part| part.to_str().unwrap()).collect();
        let depth = names.len() - usize::from(names.last() == Some(&"mod"));
        let code = code_of(&fs::read_to_string(&file).unwrap());
        Source { module: names[0].to_owned(), depth, code, file: file.clone() }
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

/// Names of the modules at the root of the crate that a source names.
fn named(source: &Source) -> BTreeSet<String> {
    let supers = "super::".repeat(source.depth);
    ["crate::", &supers].iter().flat_map(|prefix| after(&source.code, prefix)).collect()
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

/// Place of every module in the rule: its group from the left, and its column among siblings.
fn rule() -> BTreeMap<String, (usize, usize)> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let section = text.split_once("## Import rule").expect("a section on the import rule").1;
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

#[test]
fn property_modules_import_only_what_stands_to_their_left() {
    let rule = rule();
    let mut broken = Vec::new();
    let mut seen = BTreeSet::new();
    for source in sources().iter().filter(|source| !["lib", "main"].contains(&source.module.as_str())) {
        let place = rule.get(&source.module).unwrap_or_else(|| panic!("`{}` is not in the rule", source.module));
        seen.insert(source.module.clone());
        for other in named(source) {
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
        let doors: BTreeSet<&str> = sources.iter().filter(names_it).map(|source| source.module.as_str()).collect();
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
    let source = Source { file: PathBuf::new(), module: "robot".to_owned(), depth: 2, code };
    assert_eq!(named(&source), ["drive", "error", "units", "plant"].map(str::to_owned).into());
}
