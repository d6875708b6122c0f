//! Meshes by which links are drawn.
//!
//! They enter no computation, so a `<visual>` that cannot be understood is passed over without a word.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::grammar::parsed;
use super::mesh::resolve;
use super::scan::Element;
use super::text::UrdfText;
use crate::robot::tree::DrawnMesh;

/// The meshes of a link, which belongs to a body, or to the base; `pose` is that of the link in the body. URDF: `rpy` are turns about the fixed axes x, y and z, in this order.
pub(super) fn of_link<'t>(
    urdf: &'t Path,
    text: &'t UrdfText<'_>,
    link: &'t Element<'_>,
    body: Option<usize>,
    pose: &'t Isometry3<f64>,
) -> impl Iterator<Item = DrawnMesh> + 't {
    text.children(link, "visual").filter_map(move |visual| {
        let mesh = text.child(text.child(visual, "geometry")?, "mesh")?;
        let three = |element: Option<&Element<'_>>, name: &str, default: f64| match element?.attribute(name) {
            Some(numbers) => parsed(numbers, 3, false).map(|n| Vector3::new(n[0], n[1], n[2])),
            None => Some(Vector3::repeat(default)),
        };
        let origin = text.child(visual, "origin");
        let of_origin = |name: &str| origin.map_or(Some(Vector3::zeros()), |origin| three(Some(origin), name, 0.0));
        let [roll, pitch, yaw] = of_origin("rpy")?.into();
        let turned = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        Some(DrawnMesh {
            body,
            file: resolve(urdf, mesh.attribute("filename").filter(|name| !name.is_empty())?)?,
            pose: pose * Isometry3::from_parts(Translation3::from(of_origin("xyz")?), turned),
            scale: three(Some(mesh), "scale", 1.0)?,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_a_mesh_is_where_its_visual_says_and_others_are_passed_over() {
        let text = r#"<robot name="a"><link name="arm">
            <visual><origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/><geometry><mesh filename="meshes/arm.dae" scale="0.001 0.001 0.002"/></geometry></visual>
            <visual><geometry><mesh filename="package://nowhere/arm.stl"/></geometry></visual>
            <visual><geometry><mesh filename="arm.stl" scale="large"/></geometry></visual>
            <visual><geometry><mesh/></geometry></visual>
            <visual><geometry><box size="1 1 1"/></geometry></visual>
            <visual/>
        </link></robot>"#;
        let urdf = Path::new("/robots/arm.urdf");
        let text = UrdfText::scan(urdf, text, None).unwrap();
        let link = text.owner("link", "arm").unwrap();
        let at = Isometry3::translation(0.0, 0.0, 2.0);
        let drawn: Vec<DrawnMesh> = of_link(urdf, &text, link, Some(0), &at).collect();
        let [arm] = drawn.as_slice() else { panic!("{} meshes", drawn.len()) };
        assert_eq!(arm.file, Path::new("/robots/meshes/arm.dae"));
        assert_eq!(arm.scale, Vector3::new(0.001, 0.001, 0.002));
        // A point at x of the mesh lies at y of the link, because it is turned by 90° about z.
        let point = arm.pose * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((point - nalgebra::Point3::new(0.1, 1.0, 2.0)).norm() < 1e-12, "{point}");
    }
}
