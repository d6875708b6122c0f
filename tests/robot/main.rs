//! Model files and URDF files: what they become, and how broken ones are refused.

#[path = "../support/mod.rs"]
mod support;

mod accepted;
mod accuracy;
mod broken;
mod physical;
mod saved;
mod toml_input;
mod tree;

use std::path::Path;

use lostmotion::error::Result;
use lostmotion::robot::Model;

const MODEL: &str = include_str!("../../robots/elbow/model.toml");
const URDF: &str = include_str!("../../robots/elbow/elbow.urdf");

fn texts(model: &str, urdf: &str) -> Result<Model> {
    Model::from_texts(model, urdf, Path::new("elbow/model.toml"))
}
