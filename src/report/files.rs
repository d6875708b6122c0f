//! The files of a report.

use std::fmt;
use std::io;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::document::Document;
use super::html;
use super::recording::{self, Motion};
use crate::error::Result;
use crate::files::is_fit_name;
use crate::plant::RAPIER_VERSION;
use crate::robot::Model;

/// Writes content piece by piece.
type Written<'a> = dyn Fn(&mut dyn io::Write) -> io::Result<()> + 'a;

/// The content of a file.
pub enum Content<'a> {
    /// Bytes in memory.
    Bytes(Vec<u8>),
    /// Written piece by piece by this function: a recording of half an hour as text is larger than everything else
    /// together.
    Stream(Box<Written<'a>>),
}

impl Content<'_> {
    /// Writes it.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write(&self, out: &mut dyn io::Write) -> io::Result<()> {
        match self {
            Self::Bytes(bytes) => out.write_all(bytes),
            Self::Stream(write) => write(out),
        }
    }
}

impl From<String> for Content<'_> {
    fn from(text: String) -> Self {
        Self::Bytes(text.into_bytes())
    }
}

impl fmt::Debug for Content<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bytes(bytes) => write!(f, "{} bytes", bytes.len()),
            Self::Stream(_) => f.write_str("a stream"),
        }
    }
}

/// A file's name and content.
pub type File<'a> = (String, Content<'a>);

/// The complete result of a command.
#[derive(Debug)]
pub struct Report<'a> {
    /// The document for readers.
    pub document: Document,
    /// The data for programs: the content of `report.json`.
    pub json: Value,
    /// The motions in the viewer's recording.
    pub motions: Vec<Motion<'a>>,
    /// The content of `model.toml`.
    pub model: Option<Model>,
    /// Further files: name and content.
    pub extra: Vec<File<'a>>,
}

/// Versions of the program and of its engine.
pub fn versions() -> Value {
    json!({ "lostmotion": env!("CARGO_PKG_VERSION"), "rapier3d": RAPIER_VERSION })
}

/// `content` with a head of schema, versions and the machine's name.
pub fn envelope(schema: &str, name: &str, content: Value) -> Value {
    let mut all = Map::new();
    all.insert("schema".into(), schema.into());
    all.insert("versions".into(), versions());
    all.insert("name".into(), name.into());
    if let Value::Object(content) = content {
        all.extend(content);
    }
    Value::Object(all)
}

impl Report<'_> {
    /// Name and content of each file.
    ///
    /// # Errors
    /// The recording cannot be made.
    pub fn files(&self) -> Result<Vec<File<'_>>> {
        let mut files: Vec<File<'_>> = vec![
            ("report.json".to_owned(), format!("{:#}\n", self.json).into()),
            ("report.html".to_owned(), html::page(&self.document, &footer()).into()),
        ];
        if let Some(recording) = recording::encode(&self.document, &self.motions)? {
            files.push(("trace.rrd".to_owned(), Content::Bytes(recording)));
        }
        if let Some(model) = &self.model {
            files.extend(model_files(model));
        }
        files.extend(self.extra.iter().map(|(name, content)| {
            let stream: Content<'_> = Content::Stream(Box::new(|out| content.write(out)));
            (name.clone(), stream)
        }));
        Ok(files)
    }
}

fn footer() -> String {
    format!(
        "lostmotion {}, rapier {RAPIER_VERSION}. Files hold SI units and radians; this page shows degrees and millimetres.",
        env!("CARGO_PKG_VERSION")
    )
}

/// Names of the files that a report may contain, for a report with this model and these further files.
pub fn planned(model: Option<&Model>, extra: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut names = vec!["report.json".to_owned(), "report.html".to_owned()];
    if cfg!(feature = "rerun") {
        names.push("trace.rrd".to_owned());
    }
    if let Some(model) = model {
        names.extend(model_files(model).into_iter().map(|(name, _)| name));
    }
    names.extend(extra);
    names
}

/// Name of the copy of a URDF: always with the ending `.urdf`, which no other file of a report has.
fn urdf_name(model: &Model) -> String {
    let stem = model.urdf.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let name = format!("{stem}.urdf");
    if is_fit_name(&name) { name } else { "robot.urdf".to_owned() }
}

/// The model, with a copy of its URDF, so that the folder can be moved. A URDF on disk with meshes stays where these are found.
fn model_files(model: &Model) -> Vec<File<'static>> {
    if model.urdf_text.contains("<mesh")
        && let Ok(urdf) = model.urdf.canonicalize()
    {
        return vec![("model.toml".to_owned(), model.to_toml(&urdf).into())];
    }
    let urdf = urdf_name(model);
    vec![("model.toml".to_owned(), model.to_toml(Path::new(&urdf)).into()), (urdf, model.urdf_text.clone().into())]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its text exists only in memory, so that a model file without it could not be read again.
    #[test]
    fn property_a_urdf_that_is_not_on_disk_is_written_whatever_meshes_it_names() {
        let (model, urdf) =
            (include_str!("../../robots/elbow/model.toml"), include_str!("../../robots/elbow/elbow.urdf"));
        let model = Model::from_texts(model, urdf, Path::new("elbow/model.toml")).expect("the elbow");
        let text = "<robot><mesh filename=\"file:///arm.stl\"/></robot>".to_owned();
        let names: Vec<String> =
            model_files(&Model { urdf_text: text, ..model }).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["model.toml", "elbow.urdf"]);
    }
}
