//! Points of a collision mesh, STL or OBJ; the collision shape is their convex hull.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use crate::error::Error;
use crate::toml_input::read_bytes;

/// Largest number of points. Meshes with more are made for display, not for collision checks.
const MAX_POINTS: usize = 200_000;

/// [bytes] Longest mesh file; with the largest number of points it has 20 MB.
const LONGEST: u64 = 256 << 20;

/// [m] Largest coordinate; a machine is smaller.
const FARTHEST: f64 = 1e5;

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
    let scaled = |points: Vec<Vector3<f64>>| -> Vec<Vector3<f64>> {
        points.iter().map(|point| point.component_mul(scale)).collect()
    };
    match read(&file).map(scaled) {
        Ok(points) if within(&points) => Ok(points),
        Ok(_) => Err((file, format!("points within {FARTHEST:e} m"))),
        Err(expected) => Err((file, expected)),
    }
}

fn within(points: &[Vector3<f64>]) -> bool {
    points.iter().all(|point| point.iter().all(|x| x.abs() <= FARTHEST))
}

fn read(file: &Path) -> Result<Vec<Vector3<f64>>, String> {
    let bytes = read_bytes(file, LONGEST).map_err(|error| match error {
        Error::Input(fault) => fault.expected,
        other => format!(
            "a file that can be read ({})",
            std::error::Error::source(&other).map_or_else(String::new, ToString::to_string)
        ),
    })?;
    let extension = file.extension().and_then(|extension| extension.to_str()).unwrap_or_default().to_lowercase();
    let points = match extension.as_str() {
        "stl" if !is_text_stl(&bytes) => binary_stl(&bytes),
        "stl" => text_points(&bytes, "vertex"),
        "obj" => text_points(&bytes, "v"),
        _ => return Err("an STL or OBJ mesh".to_owned()),
    };
    let points = points.ok_or("a complete mesh")?;
    match points.len() {
        0..4 => Err(format!("at least 4 points, not {}", points.len())),
        count if count > MAX_POINTS => Err(format!("at most {MAX_POINTS} points for a collision shape, not {count}")),
        _ if points.iter().any(|point| !point.iter().all(|x| x.is_finite())) => {
            Err("points that are numbers".to_owned())
        }
        _ => Ok(points),
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

/// Many binary files begin with "solid" like text files; a binary file is recognised by its size, which follows from
/// the count of triangles.
fn is_text_stl(bytes: &[u8]) -> bool {
    bytes.starts_with(b"solid") && triangles(bytes).is_none()
}

/// The triangles of a binary STL: 80 bytes of header, their count, 50 bytes each.
fn triangles(bytes: &[u8]) -> Option<std::slice::ChunksExact<'_, u8>> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?);
    let body = bytes.get(84..)?;
    (body.len() as u64 == 50 * u64::from(count)).then(|| body.chunks_exact(50))
}

fn binary_stl(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    let float = |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    // 12 bytes of normal, three corners of 12 bytes, 2 bytes of attributes.
    let corners = triangles(bytes)?.flat_map(|triangle| triangle[12..48].chunks_exact(12));
    Some(corners.map(|corner| Vector3::new(float(&corner[..4]), float(&corner[4..8]), float(&corner[8..]))).collect())
}

/// Lines `KEYWORD x y z` of a text file.
fn text_points(bytes: &[u8], keyword: &str) -> Option<Vec<Vector3<f64>>> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut points = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        if words.next() == Some(keyword) {
            let mut number = || words.next()?.parse::<f64>().ok();
            points.push(Vector3::new(number()?, number()?, number()?));
        }
    }
    Some(points)
}
