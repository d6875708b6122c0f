//! Masses that follow from meshes, against MuJoCo's numbers (`meshes.json`, written by `meshes.py`).

use std::fs;

use lostmotion::plant::first_model;
use lostmotion::robot::{Inertia, Model};
use nalgebra::{Matrix3, Vector3};

use super::{folder, numbers};

fn body<'m>(model: &'m Model, name: &str) -> &'m Inertia {
    let body = model.robot.bodies.iter().find(|body| body.name == name);
    &body.unwrap_or_else(|| panic!("no body {name}")).inertia
}

/// A copy of the model and its meshes with one text replaced.
fn changed(from: &str, to: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::create_dir(place.path().join("meshes")).unwrap();
    for file in ["l.stl", "l.obj", "l.msh"] {
        fs::copy(folder().join("meshes").join(file), place.path().join("meshes").join(file)).unwrap();
    }
    let text = fs::read_to_string(folder().join("meshes.xml")).unwrap();
    assert!(text.contains(from), "{from}");
    fs::write(place.path().join("meshes.xml"), text.replacen(from, to, 1)).unwrap();
    place
}

#[test]
fn equivalent_masses_of_meshes_are_those_of_mujoco() {
    let model = first_model(&folder().join("meshes.xml")).unwrap().model;
    let text = fs::read_to_string(folder().join("meshes.json")).unwrap();
    let known = serde_json::from_str::<serde_json::Value>(&text).unwrap();
    let known = known["bodies"].as_object().unwrap();
    assert_eq!(known.len(), model.robot.bodies.len());
    for (name, known) in known {
        let own = body(&model, name);
        // MuJoCo keeps coordinates in single precision: 6e-8 of each, some 1e-6 of a product of three.
        let mass = known["mass"].as_f64().unwrap();
        assert!((own.mass - mass).abs() < 1e-6 * mass, "{name}: {} kg, MuJoCo {mass}", own.mass);
        let com = Vector3::from_vec(numbers(&known["com"]));
        assert!((own.com - com).norm() < 1e-6, "{name}: {}, MuJoCo {com}", own.com);
        let rows: Vec<f64> = known["tensor"].as_array().unwrap().iter().flat_map(numbers).collect();
        let tensor = Matrix3::from_row_slice(&rows);
        assert!((own.tensor - tensor).norm() < 3e-6 * tensor.norm(), "{name}: {}, MuJoCo {tensor}", own.tensor);
    }
}

/// An L of two boxes, 0.2 × 0.1 × 0.1 and 0.1 × 0.2 × 0.1 m.
#[test]
fn analytic_the_exact_mass_of_a_mesh_is_that_of_its_boxes() {
    let model = first_model(&folder().join("meshes.xml")).unwrap().model;
    let [exact, legacy] = ["exact", "stl"].map(|name| *body(&model, name));
    let of_box = |[a, b, c]: [f64; 3], com: [f64; 3]| {
        let mass = 1000.0 * a * b * c;
        let tensor = Matrix3::from_diagonal(&Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b)) * (mass / 12.0);
        Inertia { mass, com: com.into(), tensor }
    };
    let known = of_box([0.2, 0.1, 0.1], [0.1, 0.05, 0.05]).joined(&of_box([0.1, 0.2, 0.1], [0.05, 0.2, 0.05]));
    assert!((exact.mass - known.mass).abs() < 1e-9 && (exact.com - known.com).norm() < 1e-9, "{exact:?}");
    assert!((exact.tensor - known.tensor).norm() < 1e-9, "{}, {}", exact.tensor, known.tensor);
    // The negative control: the default counts the folded part twice.
    assert!(legacy.mass > 1.03 * exact.mass, "{} kg", legacy.mass);
}

/// Triangles that are turned inwards, or a mirrored scale, leave the mass as it is.
#[test]
fn property_the_mass_of_a_mesh_does_not_depend_on_its_orientation() {
    let sound = first_model(&folder().join("meshes.xml")).unwrap().model;
    let place = changed("scale=\"0.5 -1 2\"", "scale=\"0.5 1 2\"");
    let mirrored = first_model(&place.path().join("meshes.xml")).unwrap().model;
    let [a, b] = [&sound, &mirrored].map(|model| *body(model, "scaled"));
    assert!((a.mass - b.mass).abs() < 1e-12 * a.mass && a.mass > 0.0);
    // Mirroring at y and turning by 15° about z: the centre lies elsewhere.
    assert!((a.com - b.com).norm() > 0.1, "{} {}", a.com, b.com);
    let place = changed("", "");
    let file = place.path().join("meshes/l.stl");
    let mut bytes = fs::read(&file).unwrap();
    for triangle in bytes[84..].chunks_exact_mut(50) {
        let (first, second) = triangle[12..36].split_at_mut(12);
        first.swap_with_slice(second);
    }
    fs::write(&file, bytes).unwrap();
    let turned = first_model(&place.path().join("meshes.xml")).unwrap().model;
    for name in ["stl", "shell"] {
        let [a, b] = [&sound, &turned].map(|model| *body(model, name));
        assert!((a.mass - b.mass).abs() < 1e-12 * a.mass && (a.tensor - b.tensor).norm() < 1e-12, "{name}");
    }
}

/// What the file says of `msh`, with the fault as it is remarked.
const UNREAD: [(&str, &str, &str); 5] = [
    ("file=\"l.msh\"/>", "file=\"gone.msh\"/>", "expected a file that can be read"),
    ("file=\"l.msh\"/>", "file=\"l.dae\"/>", "expected a file that can be read"),
    ("mesh=\"msh\"", "mesh=\"none\"", "expected a mesh of this file"),
    ("file=\"l.msh\"/>", "file=\"l.msh\" scale=\"0 1 1\"/>", "expected a mesh with a volume of "),
    ("file=\"l.msh\"/>", "file=\"l.msh\" scale=\"1e9 1 1\"/>", "expected points within 1e5 m of "),
];

/// A joint that moves nothing is held; where nothing moves, the file is refused for the mesh.
#[test]
fn property_a_mesh_that_cannot_be_read_is_named_with_its_line() {
    for (from, to, part) in UNREAD {
        let place = changed(from, to);
        let file = place.path().join("meshes.xml");
        let model = first_model(&file).unwrap().model;
        let remarks: Vec<String> = model.remarks.iter().map(ToString::to_string).collect();
        let said = |parts: &[&str]| remarks.iter().any(|remark| parts.iter().all(|part| remark.contains(part)));
        assert!(said(&[":14: geom: its mass is not read: ", part]), "{to}: {remarks:?}");
        assert!(said(&["msh_joint: it moves no mass and is held"]), "{to}: {remarks:?}");
        assert!(!model.robot.bodies.iter().any(|body| body.name == "msh"));

        let text = fs::read_to_string(&file).unwrap();
        let alone = |line: &str| !line.contains("<body") || line.contains("name=\"msh\"");
        fs::write(&file, text.lines().filter(|line| alone(line)).collect::<Vec<_>>().join("\n")).unwrap();
        let error = first_model(&file).expect_err(to).to_string();
        let parts = [":12: geom: mesh = ", part, "or an <inertial> of its body: no body that moves has a mass"];
        assert!(parts.iter().all(|part| error.contains(part)), "{to}: {error}");
    }
    let place = changed("inertia=\"shell\"", "inertia=\"hollow\"");
    let error = first_model(&place.path().join("meshes.xml")).expect_err("hollow").to_string();
    assert!(error.contains(":8: mesh shell: inertia = hollow: expected one of legacy"), "{error}");
}

#[test]
fn property_damaged_mesh_files_are_named() {
    for (name, content) in [
        ("l.msh", &[0xff; 40][..]),
        ("l.msh", &[9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 7]),
        ("l.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        ("l.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 2 1\n"),
        ("l.obj", b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n"),
        ("l.stl", b"solid\nvertex 0 0\n"),
    ] {
        let place = changed("", "");
        fs::write(place.path().join("meshes").join(name), content).unwrap();
        let model = first_model(&place.path().join("meshes.xml")).unwrap().model;
        let named = |remark: &str| remark.contains("its mass is not read: expected") && remark.contains(name);
        assert!(model.remarks.iter().any(|remark| named(&remark.to_string())), "{name}: {:?}", model.remarks);
    }
}

/// Words of other simulators, and numbers that hold a joint.
#[test]
fn property_fixed_joints_and_endless_damping_are_taken_with_a_remark() {
    let place = changed(
        "<body name=\"obj\"><joint axis=\"0 1 0\"/>",
        "<body name=\"obj\"><joint type=\"fixed\" pos=\"1 0 0\"/>",
    );
    let model = first_model(&place.path().join("meshes.xml")).unwrap().model;
    assert!(!model.robot.bodies.iter().any(|body| body.name == "obj"));
    let remarks: Vec<String> = model.remarks.iter().map(ToString::to_string).collect();
    assert!(
        remarks.iter().any(|remark| remark.contains(":13: joint: of type fixed, which MuJoCo does not have")),
        "{remarks:?}"
    );

    let place = changed("<body name=\"obj\"><joint", "<body name=\"obj\"><joint damping=\"1e11\"");
    let model = first_model(&place.path().join("meshes.xml")).unwrap().model;
    assert!(!model.robot.bodies.iter().any(|body| body.name == "obj"));
    let remarks: Vec<String> = model.remarks.iter().map(ToString::to_string).collect();
    assert!(remarks.iter().any(|remark| remark.contains("its damping of 1e11 holds it")), "{remarks:?}");
    // The largest damping that is simulated.
    let place = changed("<body name=\"obj\"><joint", "<body name=\"obj\"><joint damping=\"1e10\"");
    let model = first_model(&place.path().join("meshes.xml")).unwrap().model;
    let own = model.robot.bodies.iter().find(|body| body.name == "obj").unwrap();
    assert_eq!(own.joint.damping, 1e10);
}
