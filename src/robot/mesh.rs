//! Mesh files: STL, OBJ, and the MSH of MuJoCo.

use std::path::Path;

use nalgebra::Vector3;

use crate::error::Error;
use crate::toml_input::read_bytes;

/// [bytes] Longest mesh file: five million triangles.
const LONGEST: u64 = 256 << 20;

/// [m] Largest coordinate; a machine is smaller.
const FARTHEST: f64 = 1e5;

/// A surface of triangles.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Mesh {
    /// [m] after scaling.
    pub points: Vec<Vector3<f64>>,
    /// Indices of the corners. A file may have points alone.
    pub triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// Reads a file and multiplies its coordinates by `scale`; the error is what was expected of it.
    pub fn read(file: &Path, scale: &Vector3<f64>) -> Result<Self, String> {
        let bytes = read_bytes(file, LONGEST).map_err(|error| match error {
            Error::Input(fault) => fault.expected,
            other => format!(
                "a file that can be read ({})",
                std::error::Error::source(&other).map_or_else(String::new, ToString::to_string)
            ),
        })?;
        let extension = file.extension().and_then(|extension| extension.to_str()).unwrap_or_default().to_lowercase();
        let mesh = match extension.as_str() {
            "stl" if !is_text_stl(&bytes) => binary_stl(&bytes),
            "stl" => text_stl(&bytes),
            "obj" => obj(&bytes),
            "msh" => msh(&bytes),
            _ => return Err("an STL, OBJ or MSH mesh".to_owned()),
        };
        let mut mesh = mesh.ok_or("a complete mesh")?;
        if mesh.points.iter().any(|point| !point.iter().all(|x| x.is_finite())) {
            return Err("points that are numbers".to_owned());
        }
        mesh.points.iter_mut().for_each(|point| point.component_mul_assign(scale));
        if !mesh.points.iter().all(|point| point.iter().all(|x| x.abs() <= FARTHEST)) {
            return Err(format!("points within {FARTHEST:e} m"));
        }
        if mesh.triangles.iter().flatten().any(|corner| *corner >= mesh.points.len()) {
            return Err("triangles whose corners are points of the file".to_owned());
        }
        Ok(mesh)
    }

    /// Every three points are a triangle.
    fn of_corners(points: Vec<Vector3<f64>>) -> Self {
        let triangles = (0..points.len() / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Self { points, triangles }
    }
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

/// A point of three single floats, least byte first.
fn point(bytes: &[u8]) -> Vector3<f64> {
    let float = |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    Vector3::new(float(&bytes[..4]), float(&bytes[4..8]), float(&bytes[8..12]))
}

fn binary_stl(bytes: &[u8]) -> Option<Mesh> {
    // 12 bytes of normal, three corners of 12 bytes, 2 bytes of attributes.
    let corners = triangles(bytes)?.flat_map(|triangle| triangle[12..48].chunks_exact(12));
    Some(Mesh::of_corners(corners.map(point).collect()))
}

/// Three numbers of a line.
fn three<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Vector3<f64>> {
    let mut number = || words.next()?.parse::<f64>().ok();
    Some(Vector3::new(number()?, number()?, number()?))
}

/// Lines `vertex x y z`, three of them for each triangle.
fn text_stl(bytes: &[u8]) -> Option<Mesh> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut points = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        if words.next() == Some("vertex") {
            points.push(three(&mut words)?);
        }
    }
    Some(Mesh::of_corners(points))
}

/// Lines `v x y z`, and `f a b c …` with the numbers of points from 1, or from the last point backwards if negative.
fn obj(bytes: &[u8]) -> Option<Mesh> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => mesh.points.push(three(&mut words)?),
            Some("f") => {
                let count = mesh.points.len();
                // `a/b/c`: point, texture and normal.
                let corner = |word: &str| {
                    let number: isize = word.split('/').next()?.parse().ok()?;
                    if number > 0 { usize::try_from(number - 1).ok() } else { count.checked_add_signed(number) }
                };
                let corners: Vec<usize> = words.map(corner).collect::<Option<_>>()?;
                let (first, rest) = corners.split_first()?;
                mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Some(mesh)
}

/// Counts of points, normals, textures and triangles as i32, then points and normals of three floats, textures of two, triangles of three
/// i32.
fn msh(bytes: &[u8]) -> Option<Mesh> {
    let whole = |bytes: &[u8]| usize::try_from(i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])).ok();
    let (head, body) = bytes.split_at_checked(16)?;
    let counts: Vec<usize> = head.chunks_exact(4).map(whole).collect::<Option<_>>()?;
    let sizes = [12, 12, 8, 12];
    let ends: Vec<usize> = counts
        .iter()
        .zip(sizes)
        .scan(0_usize, |end, (count, size)| {
            *end = end.checked_add(count.checked_mul(size)?)?;
            Some(*end)
        })
        .collect();
    let &[points, _, textures, end] = ends.as_slice() else { return None };
    let corners = body.get(textures..end)?.chunks_exact(12);
    let triangle = |bytes: &[u8]| Some([whole(&bytes[..4])?, whole(&bytes[4..8])?, whole(&bytes[8..])?]);
    Some(Mesh {
        points: body.get(..points)?.chunks_exact(12).map(point).collect(),
        triangles: corners.map(triangle).collect::<Option<_>>()?,
    })
}
