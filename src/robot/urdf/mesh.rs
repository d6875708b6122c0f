//! Points of a collision mesh; the collision shape is their convex hull.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use crate::robot::mesh::Mesh;

/// Largest number of points. Meshes with more are made for display, not for collision checks.
const MAX_POINTS: usize = 200_000;

/// A mesh file, and what was expected of it.
pub(super) type Unread = (PathBuf, String);

/// The points of a mesh file that a URDF names, scaled.
pub(super) fn points(urdf: &Path, name: &str, scale: &Vector3<f64>) -> Result<Vec<Vector3<f64>>, Unread> {
    let Some(file) = resolve(urdf, name) else {
        return Err((
            PathBuf::from(name),
            "a package whose folder is above the URDF, or beside a folder above it".to_owned(),
        ));
    };
    match Mesh::read(&file, scale).map(|mesh| mesh.points) {
        Ok(points) if points.len() < 4 => Err((file, format!("at least 4 points, not {}", points.len()))),
        Ok(points) if points.len() > MAX_POINTS => {
            Err((file, format!("at most {MAX_POINTS} points for a collision shape, not {}", points.len())))
        }
        Ok(points) => Ok(points),
        Err(expected) => Err((file, expected)),
    }
}

/// The file: absolute, beside the URDF, or `package://NAME/...` with a folder NAME above the URDF, or beside a folder above it as in a workspace.
pub(super) fn resolve(urdf: &Path, name: &str) -> Option<PathBuf> {
    let folder = urdf.parent().unwrap_or(Path::new(""));
    let Some(path) = name.strip_prefix("package://") else {
        return Some(folder.join(name.strip_prefix("file://").unwrap_or(name)));
    };
    let (package, rest) = path.split_once('/')?;
    // A path relative to the working folder does not name the folders above that.
    let folder = std::path::absolute(folder.join(".")).ok()?;
    let above = folder.ancestors().find(|folder| folder.file_name().is_some_and(|name| name == package));
    let beside = || folder.ancestors().map(|folder| folder.join(package)).find(|folder| folder.is_dir());
    Some(above.map(Path::to_owned).or_else(beside)?.join(rest))
}
