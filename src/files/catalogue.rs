//! The robots and scenarios that are embedded in the binary, under paths `catalogue:/robots/scara/model.toml`.

use std::path::{Component, Path, PathBuf};

/// First part of every path in the catalogue.
const ROOT: &str = "catalogue:";

/// Project path and content of every file under `robots/` and `scenarios/`.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/catalogue.rs"));

/// Names of the folders of `kind` (`robots`, `scenarios`) that contain a file `file`, in alphabetical order.
pub fn names(kind: &str, file: &str) -> Vec<&'static str> {
    let entry = |path: &'static str| path.strip_prefix(kind)?.strip_prefix('/')?.strip_suffix(file)?.strip_suffix('/');
    FILES.iter().filter_map(|(path, _)| entry(path)).filter(|name| !name.contains('/')).collect()
}

/// The text of a file of the catalogue, `robots/scara/README.md`.
pub fn text(name: &str) -> Option<&'static str> {
    std::str::from_utf8(content(name)?).ok()
}

/// The path under which [`read`](super::read) finds a file of the catalogue.
pub fn path(name: &str) -> PathBuf {
    Path::new(ROOT).join(name)
}

/// The content of a file of the catalogue.
pub(super) fn content(name: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(known, _)| *known == name).map(|&(_, content)| content)
}

/// The catalogue name of a path, with `..` resolved; `None` for paths on disk.
pub(super) fn path_in(path: &Path) -> Option<String> {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.strip_prefix(ROOT).ok()?.components() {
        match part {
            Component::Normal(part) => parts.push(part.to_str().unwrap_or_default()),
            Component::ParentDir => drop(parts.pop()),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    Some(parts.join("/"))
}
