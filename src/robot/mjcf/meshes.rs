//! The meshes of a file: where they are, and the mass of a body of their shape.
//!
//! ```text
//!   legacy   m = ρ Σ |V_t|     the default
//!   exact    m = ρ |Σ V_t|     a closed surface, all triangles turned alike
//!   shell    m = ρ Σ A_t       ρ in kg/m²
//!   V_t = (a−o)·((b−o)×(c−o))/6        tetrahedron of a triangle and o: its signed volume
//!   c = Σ V_t (3 c_t + o)/4 / Σ V_t    centre, o = Σ A_t c_t / Σ A_t;  c_t, A_t: centre and area of a triangle
//!   P = Σ V_t/20 (s sᵀ + Σ_k d_k d_kᵀ), o = c,  d_k = corner_k − c,  s = Σ_k d_k;  A_t/12 for a shell
//!   I = tr(P) E − P
//! ```
//! `legacy` counts what a surface folds over more than once, so that it gives a body that is not convex too much mass. MuJoCo computes so
//! unless the mesh says otherwise, and users have tuned their models to it. `o` of the mass is `c` too.
//! Left out: the convex hull (`inertia="convex"`), for which the mesh's own volume is taken; meshes without a file; meshes to which a
//! primitive is fitted.
//! References: MuJoCo documentation, XML reference, `asset/mesh`, version 4.0. B. Mirtich (1996), Fast and accurate computation of polyhedral
//! mass properties.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Vector3};

use super::classes::Classes;
use super::compiler::Compiler;
use super::document::Node;
use super::written::escaped;
use crate::error::Result;
use crate::robot::mesh::Mesh;
use crate::robot::remark::Remark;
use crate::robot::tree::Inertia;

/// Values of `inertia`.
const MODES: [&str; 4] = ["legacy", "convex", "exact", "shell"];

/// [m³ or m²] Least volume or area: a millionth of a cubic millimetre.
const LEAST: f64 = 1e-15;

/// The meshes of a file, by name.
#[derive(Default)]
pub(super) struct Meshes {
    /// The folder of the main file.
    folder: PathBuf,
    assets: BTreeMap<String, Asset>,
    /// What was computed of them.
    known: BTreeMap<String, Result<Inertia, String>>,
}

struct Asset {
    /// Relative to the folder of the main file.
    file: String,
    scale: [f64; 3],
    mode: &'static str,
}

impl Meshes {
    /// Reads the elements `<mesh>` of all assets.
    ///
    /// # Errors
    /// A value is not of the expected form.
    pub fn read(
        main: &Path,
        root: &Node,
        classes: &Classes,
        compiler: &Compiler,
        remarks: &mut Vec<Remark>,
    ) -> Result<Self> {
        let folder = main.parent().unwrap_or(Path::new("")).to_owned();
        let mut meshes = Self { folder, ..Self::default() };
        for node in root.all("asset").flat_map(|asset| asset.all("mesh")) {
            let item = classes.with(node, None)?;
            let Some(file) = item.text("file") else { continue };
            let stem = Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned());
            let name = item.text("name").map_or(stem.unwrap_or_default(), str::to_owned);
            let scale = item.array::<3>("scale")?.unwrap_or([1.0; 3]);
            for moved in ["refpos", "refquat"] {
                if item.text(moved).is_some() {
                    remarks.push(node.remark(&format!("{moved} is not taken: the coordinates of the file are used")));
                }
            }
            let usual = if compiler.exact_meshes { "exact" } else { "legacy" };
            let mode = node.word("inertia", item.text("inertia").unwrap_or(usual), &MODES)?;
            if mode == "convex" {
                remarks.push(node.remark("inertia = convex is not taken: the volume of the mesh itself is used"));
            }
            let file = format!("{}{file}", compiler.mesh_folder);
            meshes.assets.insert(name, Asset { file, scale, mode });
        }
        Ok(meshes)
    }

    /// The mesh as a URDF element.
    pub fn element(&self, name: &str) -> Option<String> {
        let Asset { file, scale: [x, y, z], .. } = self.assets.get(name)?;
        Some(format!("<mesh filename=\"{}\" scale=\"{x} {y} {z}\"/>", escaped(file)))
    }

    /// A body of the shape of a mesh with a density of 1 kg/m³, or 1 kg/m² for a shell; the error is what was expected of the file.
    pub fn inertia(&mut self, name: &str) -> Result<Inertia, String> {
        let Some(asset) = self.assets.get(name) else {
            return Err("a mesh of this file, with a file of its own".to_owned());
        };
        if let Some(known) = self.known.get(name) {
            return known.clone();
        }
        let file = self.folder.join(&asset.file);
        let found = Mesh::read(&file, &asset.scale.into())
            .and_then(|mesh| inertia(&mesh, asset.mode).ok_or_else(|| "a mesh with a volume".to_owned()))
            .map_err(|expected| format!("{expected} of {}", file.display()));
        self.known.insert(name.to_owned(), found.clone());
        found
    }
}

/// The inertia of a mesh; `None` for one without a volume, or without an area for a shell.
fn inertia(mesh: &Mesh, mode: &str) -> Option<Inertia> {
    let corners = |triangle: &[usize; 3]| triangle.map(|corner| mesh.points[corner]);
    let triangles: Vec<[Vector3<f64>; 3]> = mesh.triangles.iter().map(corners).collect();
    let area = |[a, b, c]: &[Vector3<f64>; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
    let volume = |[a, b, c]: &[Vector3<f64>; 3], o: &Vector3<f64>| (a - o).dot(&(b - o).cross(&(c - o))) / 6.0;
    let centre = |[a, b, c]: &[Vector3<f64>; 3]| (a + b + c) / 3.0;

    let total: f64 = triangles.iter().map(area).sum();
    let middle = triangles.iter().map(|t| centre(t) * area(t)).sum::<Vector3<f64>>() / total;
    // Triangles that are turned inwards give a negative volume.
    let turned = triangles.iter().map(|t| volume(t, &middle)).sum::<f64>().signum();
    let part = |t: &[Vector3<f64>; 3], o: &Vector3<f64>| match mode {
        "shell" => area(t),
        "legacy" => volume(t, o).abs(),
        _ => turned * volume(t, o),
    };
    let (of_middle, over) = if mode == "shell" { (0.0, 12.0) } else { (0.25, 20.0) };
    let sum: f64 = triangles.iter().map(|t| part(t, &middle)).sum();
    let weighted = |t| (centre(t) * (1.0 - of_middle) + middle * of_middle) * part(t, &middle);
    let com = triangles.iter().map(weighted).sum::<Vector3<f64>>() / sum;

    let mass: f64 = triangles.iter().map(|t| part(t, &com)).sum();
    let mut p = Matrix3::zeros();
    for t in &triangles {
        let d = t.map(|corner| corner - com);
        let s = d[0] + d[1] + d[2];
        p += (s * s.transpose() + d.iter().map(|d| d * d.transpose()).sum::<Matrix3<f64>>()) * (part(t, &com) / over);
    }
    let tensor = Matrix3::identity() * p.trace() - p;
    (mass > LEAST && tensor.iter().all(|value| value.is_finite())).then_some(Inertia { mass, com, tensor })
}
