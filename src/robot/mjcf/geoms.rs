//! Geoms: their mass, and the shapes with which they collide.
//!
//! ```text
//!   sphere      m = ρ 4/3 π r³          I = 2/5 m r²
//!   box         m = ρ 8 a b c           I_x = m (b² + c²)/3, half sides a b c
//!   cylinder    m = ρ 2 π r² h          I_z = m r²/2,  I_x = m (3 r² + 4 h²)/12, half length h
//!   capsule     cylinder and two half spheres: I_z = m_c r²/2 + 2/5 m_s r²
//!                                              I_x = m_c (3 r² + 4 h²)/12 + m_s (2/5 r² + h² + 3/4 h r)
//!   ellipsoid   m = ρ 4/3 π a b c       I_x = m (b² + c²)/5
//!   mesh        `meshes`
//! ```
//! Left out: primitives that are fitted to a mesh.
//! Reference: MuJoCo documentation, XML reference, `body/geom`.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};

use super::classes::Item;
use super::compiler::{Compiler, turned_onto, unit};
use crate::error::Result;
use crate::robot::tree::Inertia;

/// [kg/m³] Density if none is given.
const DENSITY: f64 = 1000.0;

/// Types of geoms.
const TYPES: [&str; 9] = ["sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "plane", "hfield", "sdf"];

/// A geom: a primitive solid or a mesh.
pub(super) struct Geom<'n> {
    pub kind: &'static str,
    /// [m] Radius, or half sides; for a capsule or a cylinder, radius and half length.
    pub size: [f64; 3],
    /// Pose in the frame of its body.
    pub pose: Isometry3<f64>,
    /// Name of its mesh.
    pub mesh: Option<&'n str>,
    /// Whether it collides with anything.
    pub collides: bool,
    item: Item<'n>,
}

impl<'n> Geom<'n> {
    /// Reads a geom.
    ///
    /// # Errors
    /// A value is not of the expected form, or a size is missing.
    pub fn read(item: Item<'n>, compiler: &Compiler, frame: &Isometry3<f64>) -> Result<Self> {
        let node = item.node;
        let mesh = item.text("mesh");
        let default = if mesh.is_some() { "mesh" } else { "sphere" };
        let kind = node.word("type", item.text("type").unwrap_or(default), &TYPES)?;
        let mut size = [0.0; 3];
        for (own, given) in size.iter_mut().zip(item.numbers("size", 1, 3)?.unwrap_or_default()) {
            *own = given;
        }
        let mut pose = compiler.pose(&item)?;
        let (last, of_radius) = match kind {
            "capsule" | "cylinder" => (1, 1),
            "box" | "ellipsoid" => (2, 2),
            _ => (0, 1),
        };
        if let Some([ax, ay, az, bx, by, bz]) = item.array::<6>("fromto")?.filter(|_| last > 0) {
            let (a, b) = (Vector3::new(ax, ay, az), Vector3::new(bx, by, bz));
            // The geom's z axis points from the second end to the first.
            let along = unit(a - b).ok_or_else(|| node.error("fromto", "", "two points that differ"))?;
            pose = Isometry3::from_parts(Translation3::from((a + b) / 2.0), turned_onto(&along));
            if of_radius == 2 {
                size[1] = size[0];
            }
            size[last] = 0.5 * (a - b).norm();
        }
        let needed = match kind {
            "sphere" => 1,
            "capsule" | "cylinder" => 2,
            "box" | "ellipsoid" => 3,
            _ => 0,
        };
        if mesh.is_none() && size[..needed].iter().any(|size| *size <= 0.0) {
            let shown = item.text("size").unwrap_or_default();
            return Err(node.error("size", shown, format!("{needed} numbers > 0 [m] of a {kind}")));
        }
        let bits = |name: &str| item.number_or(name, 1.0).map(|bits| bits != 0.0);
        let collides = bits("contype")? || bits("conaffinity")?;
        Ok(Self { kind, size, pose: frame * pose, mesh, collides, item })
    }

    /// Inertia in the frame of its body; `None` for a geom whose mass is not read. `mesh` gives the inertia of a mesh by its name, for a density
    /// of one.
    ///
    /// # Errors
    /// Mass or density is not a number, or is negative.
    pub fn inertia(&self, mesh: impl FnOnce(&str) -> Option<Inertia>) -> Result<Option<Inertia>> {
        let given = self.item.array::<1>("mass")?.map(|_| self.item.magnitude_or("mass", 0.0)).transpose()?;
        let density = self.item.magnitude_or("density", DENSITY)?;
        if given.unwrap_or(density) == 0.0 {
            return Ok(Some(Inertia::zero()));
        }
        let Some(unit) = self.unit_inertia(mesh) else { return Ok(None) };
        let factor = given.map_or(density, |mass| mass / unit.mass);
        let scaled = Inertia { mass: unit.mass * factor, com: unit.com, tensor: unit.tensor * factor };
        Ok(Some(scaled.seen_from(&self.pose)))
    }

    /// Whether the geom is solid: a plane and a height field have no mass.
    pub fn is_solid(&self) -> bool {
        !["plane", "hfield"].contains(&self.kind)
    }

    /// The inertia for a density of one.
    fn unit_inertia(&self, mesh: impl FnOnce(&str) -> Option<Inertia>) -> Option<Inertia> {
        if let (Some(name), "mesh") = (self.mesh, self.kind) {
            return mesh(name);
        }
        let (volume, moments) = self.unit_moments()?;
        Some(Inertia { mass: volume, com: Vector3::zeros(), tensor: Matrix3::from_diagonal(&(moments * volume)) })
    }

    /// Volume [m³], and moments of inertia of a unit mass [m²].
    fn unit_moments(&self) -> Option<(f64, Vector3<f64>)> {
        let [a, b, c] = self.size;
        if self.mesh.is_some() {
            return None;
        }
        Some(match self.kind {
            "sphere" => (4.0 / 3.0 * PI * a.powi(3), Vector3::repeat(0.4 * a * a)),
            "box" => (8.0 * a * b * c, Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) / 3.0),
            "ellipsoid" => {
                (4.0 / 3.0 * PI * a * b * c, Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) / 5.0)
            }
            "cylinder" => {
                let across = (3.0 * a * a + 4.0 * b * b) / 12.0;
                (2.0 * PI * a * a * b, Vector3::new(across, across, 0.5 * a * a))
            }
            "capsule" => {
                let (middle, ends) = (2.0 * PI * a * a * b, 4.0 / 3.0 * PI * a.powi(3));
                let volume = middle + ends;
                let (m, s) = (middle / volume, ends / volume);
                let across = m * (3.0 * a * a + 4.0 * b * b) / 12.0 + s * (0.4 * a * a + b * b + 0.75 * a * b);
                (volume, Vector3::new(across, across, 0.5 * m * a * a + 0.4 * s * a * a))
            }
            _ => return None,
        })
    }

    /// The shape as a URDF element; `None` for a shape that URDF does not have.
    pub fn urdf(&self, mesh: impl Fn(&str) -> Option<String>) -> Option<String> {
        let [a, b, c] = self.size;
        match (self.mesh, self.kind) {
            (Some(name), "mesh") => mesh(name),
            (None, "sphere") => Some(format!("<sphere radius=\"{a}\"/>")),
            (None, "box") => Some(format!("<box size=\"{} {} {}\"/>", 2.0 * a, 2.0 * b, 2.0 * c)),
            (None, "cylinder") => Some(format!("<cylinder radius=\"{a}\" length=\"{}\"/>", 2.0 * b)),
            (None, "capsule") => Some(format!("<capsule radius=\"{a}\" length=\"{}\"/>", 2.0 * b)),
            _ => None,
        }
    }
}
