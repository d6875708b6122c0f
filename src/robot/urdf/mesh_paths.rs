//! Paths of meshes in a URDF that is written to another folder: absolute, since relative ones and packages are found from the URDF's own folder.

use std::ops::Range;
use std::path::Path;

use super::mend::tag;
use super::mesh::resolve;
use super::scan::Element;

/// New texts for the opening tags of `<mesh>` elements whose file exists, with their places in the text. Other names stay as they are.
pub(super) fn edits(file: &Path, text: &str, elements: &[Element<'_>]) -> Vec<(Range<usize>, String)> {
    let edit = |mesh: &Element<'_>| {
        let found = resolve(file, mesh.attribute("filename")?).filter(|found| found.is_file())?;
        let name = format!("file://{}", std::path::absolute(found).ok()?.to_str()?);
        let place = mesh.range.start..mesh.inside;
        let attributes = mesh.attributes.iter().map(|(key, value)| match *key {
            "filename" => (*key, name.clone()),
            _ => (*key, value.to_string()),
        });
        let mut opening = String::new();
        tag(mesh.name, attributes, &mut opening);
        if text[place.clone()].ends_with("/>") {
            opening.insert(opening.len() - 1, '/');
        }
        Some((place, opening))
    };
    elements.iter().filter(|element| element.name == "mesh").filter_map(edit).collect()
}
