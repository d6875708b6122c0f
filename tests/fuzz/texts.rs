//! URDF and MJCF files, models, scenarios and manifests.

use lostmotion::dataset;
use lostmotion::plant::{Options, Plant, first_model};
use lostmotion::robot::Model;
use lostmotion::scenario::{Limits, Scenario, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::campaign::{Good, Reached, corpus, run};
use super::recordings::check;
use super::support::Folder;
use super::support::recordings::csv;
use super::support::turntable::{MODEL, SCENARIO, URDF};

/// Steps times joints that a case may take: no more than a scenario of a few seconds takes.
const STEPS: f64 = 3e4;

const MANIFEST: &str = r#"schema = "lostmotion/dataset/1"
file = "raw.csv"
[time]
column = "t"
unit = "s"
[joints.turn]
position = { column = "angle", unit = "deg" }
torque = { column = "load", scale = 2.0 }
"#;

/// The turntable, which moves in sessions of every kind.
fn turntable() -> Folder {
    Folder::with(&[("robot.urdf", URDF), ("model.toml", MODEL), ("scenario.toml", SCENARIO)])
}

fn good(folder: &Folder, name: &str) -> Good {
    Good::of_disk(&folder.path(name))
}

/// Moves what a scenario describes, for a moment.
fn carry_out(scenario: Result<Scenario, lostmotion::error::Error>) -> Reached {
    let Ok(mut scenario) = scenario else { return Reached::Refused };
    let Ok(cost) = scenario.cost() else { return Reached::Read };
    assert!(cost.memory.is_finite() && cost.steps.is_finite(), "{cost:?}");
    // The limits of a user are wider and work alike.
    scenario.limits = Limits { memory: 2e8, steps: STEPS };
    if scenario.check().is_err() {
        return Reached::Read;
    }
    simulate(&scenario, 1, &|_, _| {}).ok();
    Reached::Done
}

/// Lets a machine fall for a moment.
fn let_go(model: Result<Model, lostmotion::error::Error>) -> Reached {
    let Ok(model) = model else { return Reached::Refused };
    model.notes();
    let most_steps = (STEPS / model.joints.len().max(1) as f64) as usize;
    let Ok(mut plant) = Plant::new(&model, &Options { most_steps, ..Options::default() }) else {
        return Reached::Read;
    };
    let currents = vec![0.0; model.joints.len()];
    let fell = (0..20).all(|_| plant.advance(&currents, 0.001).is_ok());
    if fell { Reached::Done } else { Reached::Read }
}

#[test]
fn property_no_broken_urdf_panics_hangs_or_swells() {
    let own = turntable();
    let mut all = vec![good(&own, "robot.urdf")];
    all.extend(corpus("robots", ".urdf"));
    // Each robot in a folder of its own, with its model.
    let folders: Vec<Folder> = all[1..]
        .iter()
        .map(|urdf| {
            let model = std::fs::read_to_string(urdf.path.with_file_name("model.toml")).expect("a model");
            Folder::with(&[("model.toml", &model)])
        })
        .collect();
    run("urdf", true, &all, |at, bytes| {
        if at == 0 {
            own.put("robot.urdf", bytes);
            return carry_out(Scenario::load(&own.path("scenario.toml"), &[]));
        }
        let folder = &folders[at - 1];
        folder.put(&all[at].path.file_name().expect("a name").to_string_lossy(), bytes);
        let_go(Model::load(&folder.path("model.toml")))
    });
}

#[test]
fn property_no_broken_mjcf_panics_hangs_or_swells() {
    let all = corpus("tests/mjcf", ".xml");
    assert_eq!(all.len(), 4);
    let gripper = all.iter().find(|good| good.path.ends_with("gripper.xml")).expect("the file that is included");
    let arm = all.iter().find(|good| good.path.ends_with("arm.xml")).expect("the file that includes it");
    let folder = Folder::with(&[]);
    let meshes = corpus("tests/mjcf/meshes", "");
    let put_mesh = |mesh: &super::campaign::Good, bytes: &[u8]| {
        folder.put(&format!("meshes/{}", mesh.path.file_name().expect("a name").to_string_lossy()), bytes);
    };
    meshes.iter().for_each(|mesh| put_mesh(mesh, &mesh.bytes));
    run("mjcf", true, &all, |at, bytes| {
        folder.put("arm.xml", &arm.bytes);
        folder.put("gripper.xml", &gripper.bytes);
        let name = all[at].path.file_name().expect("a name").to_string_lossy().into_owned();
        folder.put(&name, bytes);
        let read = if all[at].path == gripper.path { "arm.xml" } else { &name };
        let_go(first_model(&folder.path(read)).map(|first| first.model))
    });
    // A model all of whose masses follow from meshes, and one mesh that is broken.
    run("mesh", false, &meshes, |at, bytes| {
        let name = meshes[at].path.file_name().expect("a name").to_string_lossy().into_owned();
        put_mesh(&meshes[at], bytes);
        folder.put(
            "meshes.xml",
            format!(
                "<mujoco><asset><mesh name=\"m\" file=\"meshes/{name}\"/></asset><worldbody><body><joint/><geom type=\"mesh\" mesh=\"m\"/>\
                 </body></worldbody></mujoco>"
            ),
        );
        let_go(first_model(&folder.path("meshes.xml")).map(|first| first.model))
    });
}

#[test]
fn property_no_broken_model_panics_hangs_or_swells() {
    let own = turntable();
    let mut all = vec![good(&own, "model.toml")];
    all.extend(corpus("robots", "model.toml"));
    all.extend(corpus("robots", "model_two_lines.toml"));
    let folders: Vec<Folder> = all[1..]
        .iter()
        .map(|model| {
            let folder = Folder::with(&[]);
            for urdf in corpus("robots", ".urdf").iter().filter(|urdf| urdf.path.parent() == model.path.parent()) {
                folder.put(&urdf.path.file_name().expect("a name").to_string_lossy(), &urdf.bytes);
            }
            folder
        })
        .collect();
    run("model", true, &all, |at, bytes| {
        if at == 0 {
            own.put("model.toml", bytes);
            return carry_out(Scenario::load(&own.path("scenario.toml"), &[]));
        }
        let folder = &folders[at - 1];
        let_go(Model::load(&folder.put("model.toml", bytes)))
    });
}

#[test]
fn property_no_broken_scenario_panics_hangs_or_swells() {
    let own = turntable();
    let mut all = vec![good(&own, "scenario.toml")];
    all.extend(corpus("scenarios", "scenario.toml"));
    run("scenario", true, &all, |at, bytes| {
        if at == 0 {
            return carry_out(Scenario::load(&own.put("scenario.toml", bytes), &[]));
        }
        // Read as if it stood in its folder, beside the files that it names.
        carry_out(Scenario::from_text(&String::from_utf8_lossy(bytes), &all[at].path, &[]))
    });
}

#[test]
fn property_no_broken_manifest_panics_hangs_or_swells() {
    let own = turntable();
    own.put("raw.csv", csv("t,angle,load"));
    own.put("manifest.toml", MANIFEST);
    let mut all = vec![good(&own, "manifest.toml")];
    all.extend(
        corpus("robots/emps", ".toml").into_iter().filter(|good| good.path.to_string_lossy().contains("datasets")),
    );
    all.extend(corpus("robots/kr300/datasets", ".toml"));
    let joints = [("turn".to_owned(), lostmotion::units::JointKind::Revolute)];
    run("manifest", true, &all, |_, bytes| {
        let path = own.put("manifest.toml", bytes);
        let alone = dataset::load_alone(&path);
        let session = dataset::load(&path, &joints);
        alone.iter().chain(&session).for_each(check);
        if session.is_ok() { Reached::Done } else { Reached::Refused }
    });
}

/// Meshes of points that span nothing, lie on each other or far apart: a hull, or an error.
#[test]
fn property_no_mesh_of_odd_points_panics() {
    let files = turntable();
    files.put("robot.urdf", URDF.replace("<box size=\"0.2 0.1 0.1\"/>", "<mesh filename=\"part.obj\"/>"));
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    let mut read = 0;
    for _ in 0..200 {
        let count = rng.random_range(0..40);
        let sizes = [0, 1, 2].map(|_| [0.0, 1e-300, 1e-12, 1e-6, 0.1, 1e4][rng.random_range(0..6)]);
        let steps = [2.0, 3.0, 1e9][rng.random_range(0..3)];
        let mut text = String::new();
        for _ in 0..count {
            let [x, y, z] = sizes.map(|size| size * (rng.random::<f64>() * steps).floor() / steps);
            text += &format!("v {x} {y} {z}\n");
        }
        files.put("part.obj", text);
        // Refused where the mesh was not read: then the arm has nothing that the obstacle could be touched with.
        let scenario = Scenario::load(&files.path("scenario.toml"), &[]);
        read += usize::from(scenario.is_ok_and(|scenario| scenario.check().is_ok()));
    }
    assert!(read > 5, "{read}");
}
