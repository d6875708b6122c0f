//! How well nominal values are known: the table `[accuracy]`, and models that deviate within it.

use std::path::Path;

use lostmotion::robot::{Accuracy, Inertia, Masses, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{MODEL, URDF, texts};

/// The elbow's model file with this text instead of its own table.
fn stated(table: &str) -> lostmotion::error::Result<Model> {
    texts(&format!("{}{table}", &MODEL[..MODEL.find("[accuracy]").expect("the table")]), URDF)
}

fn refused(table: &str) -> String {
    stated(table).expect_err(table).to_string()
}

/// Line of a key that follows the head of the table at once.
fn first_line() -> usize {
    MODEL[..MODEL.find("[accuracy]").expect("the table")].lines().count() + 2
}

#[test]
fn property_what_a_model_file_leaves_out_of_its_accuracy_has_the_default() {
    let without = stated("").expect("a model without the table");
    assert_eq!((without.accuracy, without.masses), (Accuracy::default(), Masses::Known));
    assert_eq!(stated("[accuracy]\n").expect("an empty table").accuracy, Accuracy::default());
    let found = stated("[accuracy]\nmasses = 0\ncentres = 0.002\n").expect("part of the table").accuracy;
    assert_eq!(found, Accuracy { masses: 0.0, centres: 0.002, ..Accuracy::default() });
    assert_eq!(texts(MODEL, URDF).expect("the elbow").accuracy, Accuracy::EXACT);
}

#[test]
fn property_unknown_masses_are_guesses_with_all_inertial_values() {
    let found = stated("[accuracy]\nmasses = \"unknown\"\n").expect("unknown masses");
    assert_eq!((found.accuracy, found.masses), (Accuracy::of_guesses(), Masses::Estimated));
    let found = stated("[accuracy]\nmasses = \"unknown\"\ncentres = 0.01\n").expect("known centres");
    assert_eq!(found.accuracy, Accuracy { centres: 0.01, ..Accuracy::of_guesses() });
    // The older key says the same.
    let head = stated("").expect("a model").to_toml(Path::new("elbow.urdf")).replace("[accuracy]", "[rest]");
    let (head, _) = head.split_once("[rest]").expect("a table at the end");
    let older = texts(&head.replacen("urdf =", "masses = \"estimated\"\nurdf =", 1), URDF).expect("estimated masses");
    assert_eq!((older.accuracy, older.masses), (Accuracy::of_guesses(), Masses::Estimated));
}

#[test]
fn regress_a_broken_accuracy_is_refused_with_its_line() {
    let line = first_line();
    let at = |rest: &str| format!("elbow/model.toml:{line}: accuracy.{rest}");
    for (table, message) in [
        ("[accuracy]\nmasses = -0.1\n", "masses = -0.1: expected a number from 0 to 10 [1], or \"unknown\""),
        ("[accuracy]\nmasses = 11\n", "masses = 11: expected a number from 0 to 10 [1], or \"unknown\""),
        ("[accuracy]\nmasses = \"about\"\n", "masses = \"about\": expected a number from 0 to 10 [1], or \"unknown\""),
        ("[accuracy]\ncentres = 10.5\n", "centres = 10.5: expected a number from 0 to 10 [m]"),
        ("[accuracy]\ncentres = \"unknown\"\n", "centres = \"unknown\": expected a number from 0 to 10 [m]"),
        ("[accuracy]\ninertias = nan\n", "inertias = nan: expected a number from 0 to 10 [1]"),
        ("[accuracy]\ntorque_constants = -1e-9\n", "torque_constants = -1e-9: expected a number from 0 to 10 [1]"),
        ("[accuracy]\nrotor_inertias = inf\n", "rotor_inertias = inf: expected a number from 0 to 10 [1]"),
        ("[accuracy]\nstiffness = true\n", "stiffness = true: expected a number from 0 to 10 [1]"),
        ("[accuracy]\nmases = 0.1\n", "mases = 0.1: expected the key `masses` (unknown key)"),
    ] {
        assert_eq!(refused(table), at(message));
    }
}

#[test]
fn equivalent_a_written_accuracy_reads_back() {
    let stated = [
        Accuracy::default(),
        Accuracy::EXACT,
        Accuracy::of_guesses(),
        Accuracy { masses: 1.0 / 3.0, centres: 1e-7, stiffness: 10.0, ..Accuracy::default() },
    ];
    for (accuracy, masses) in stated.into_iter().zip([Masses::Known, Masses::Known, Masses::Estimated, Masses::Known]) {
        let model = Model { accuracy, masses, ..texts(MODEL, URDF).expect("the elbow") };
        let again = texts(&model.to_toml(Path::new("elbow.urdf")), URDF).expect("what was written");
        assert_eq!((again.accuracy, again.masses), (accuracy, masses));
    }
}

/// Standard deviations of all nominal values.
fn drawn(model: &Model, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = 10 * model.robot.bodies.len() + 2 * model.joints.len();
    (0..count).map(|_| StandardNormal.sample(&mut rng)).collect()
}

/// Writes a model and its URDF, reads both again, and compares.
fn reads_back(model: &Model) -> Model {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("model.toml");
    model.save(&file).expect("files");
    let again = Model::load(&file).expect("what was written");
    assert_eq!(again.urdf.parent(), Some(folder.path()), "the URDF is a file of this model's own");
    assert_eq!(again.joints, model.joints);
    for (found, own) in again.robot.bodies.iter().zip(&model.robot.bodies) {
        same_inertia(&found.inertia, &own.inertia);
        assert_eq!((&found.joint, found.parent, &found.shapes), (&own.joint, own.parent, &own.shapes), "{}", own.name);
    }
    again
}

/// Numbers are written to the last digit; reading turns them into the frame of the link, by an identity that rounds to 1e-16.
fn same_inertia(found: &Inertia, own: &Inertia) {
    let size = own.tensor.amax();
    assert!((found.mass - own.mass).abs() <= 1e-15 * own.mass, "{found:?} {own:?}");
    assert!((found.com - own.com).amax() <= 1e-15 * own.com.amax(), "{found:?} {own:?}");
    assert!((found.tensor - own.tensor).amax() <= 1e-14 * size, "{found:?} {own:?}");
}

#[test]
fn equivalent_a_deviating_model_reads_back_with_its_inertias() {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    for (seed, robot) in ["elbow", "scara", "sixaxis", "chain12"].into_iter().enumerate() {
        let exact = Model::load(&robots.join(robot).join("model.toml")).expect("a robot");
        let nominal = Model { accuracy: Accuracy::default(), ..exact };
        let moved = nominal.deviating(&drawn(&nominal, seed as u64));
        for (body, old) in moved.robot.bodies.iter().zip(&nominal.robot.bodies) {
            assert!(body.inertia.fault().is_none() && body.inertia != old.inertia, "{robot}: {}", body.name);
        }
        let again = reads_back(&moved);
        // All but the inertias is as it was: links, joints, shapes, what is held.
        assert_eq!((&again.held, again.accuracy), (&nominal.held, nominal.accuracy));
        assert_eq!(again.robot.gravity, nominal.robot.gravity);
    }
}

#[test]
fn property_a_model_that_does_not_deviate_keeps_its_files() {
    let exact = texts(MODEL, URDF).expect("the elbow");
    assert_eq!(exact.deviating(&drawn(&exact, 1)), exact, "an exact model has nothing to deviate");
    let nominal = Model { accuracy: Accuracy::default(), ..exact };
    let still = vec![0.0; drawn(&nominal, 1).len()];
    assert_eq!(nominal.deviating(&still), nominal);
}

#[test]
fn analytic_a_mass_that_deviates_scales_its_body() {
    let nominal = Model { accuracy: Accuracy::default(), ..texts(MODEL, URDF).expect("the elbow") };
    let mut u = vec![0.0; drawn(&nominal, 1).len()];
    // The mass of the forearm, the rotor of the shoulder, and the torque constant of the elbow.
    (u[10], u[20], u[23]) = (2.0, -1.0, 1.0);
    let moved = nominal.deviating(&u);
    let (new, old) = (&moved.robot.bodies[1].inertia, &nominal.robot.bodies[1].inertia);
    assert!((new.mass / old.mass - 1.2).abs() < 1e-12);
    assert!((new.com - old.com).amax() < 1e-12 && (new.tensor - old.tensor).amax() < 1e-12, "only the mass is larger");
    assert_eq!(moved.robot.bodies[0], nominal.robot.bodies[0]);
    let rotor = |model: &Model| model.joints[0].rotor_inertia.expect("a rotor");
    let constant = |model: &Model| model.joints[1].motor.expect("a motor").torque_constant;
    assert!((rotor(&moved) / rotor(&nominal) - 0.9).abs() < 1e-12);
    assert!((constant(&nominal) / constant(&moved) - 0.95).abs() < 1e-12, "a torque needs a twentieth less current");
    // The text of an unchanged link stays to the letter.
    let upper_arm = "<mass value=\"3.2\"/>";
    assert!(URDF.contains(upper_arm) && moved.urdf_text.contains(upper_arm) && !moved.urdf_text.contains("\"1.8\""));
    reads_back(&moved);
}

/// Links without an element `inertial`, with a self-closing tag, with single quotes, and with masses only on what is fixed to them.
const SPARSE: &str = r#"<?xml version="1.0"?>
<!-- <link name="turn"/> is no link here -->
<robot name="sparse">
  <link name="base"/>
  <link name="plate"><inertial><mass value="5"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link  name='turn' />
  <link name="a&gt;b > c"><inertial><origin xyz="0 0 0.1" rpy="0.3 0 0"/><mass value="2"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial></link>
  <link name="slide"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <link name="cup"><inertial><mass value="0.5"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <link name="rim"/>
  <joint name="bolts" type="fixed"><parent link="base"/><child link="plate"/></joint>
  <joint name="j1" type="revolute"><parent link="plate"/><child link="turn"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="3"/></joint>
  <joint name="weld" type="fixed"><parent link="turn"/><child link="a&gt;b > c"/><origin xyz="0.1 0.2 0.3" rpy="0 0.4 0"/></joint>
  <joint name="j2" type="prismatic"><parent link="a&gt;b > c"/><child link="slide"/><origin xyz="0 0.1 0"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="5" velocity="3"/></joint>
  <joint name="glue" type="fixed"><parent link="slide"/><child link="cup"/><origin xyz="0 0 0.05"/></joint>
  <joint name="edge" type="fixed"><parent link="cup"/><child link="rim"/><origin xyz="0 0 0.05"/></joint>
</robot>
"#;
const SPARSE_MODEL: &str = "schema = \"lostmotion/model/1\"\nname = \"sparse\"\nurdf = \"sparse.urdf\"\n[joints.j1]\ngear_ratio = 5.0\n\
    [joints.j2]\ngear_ratio = 5.0\n";

#[test]
fn equivalent_links_that_are_fixed_to_a_body_give_it_their_mass() {
    let nominal = texts(SPARSE_MODEL, SPARSE).expect("a sparse model");
    assert_eq!(nominal.robot.bodies.iter().map(|body| body.inertia.mass).collect::<Vec<_>>(), [2.0, 0.5]);
    let moved = nominal.deviating(&drawn(&nominal, 3));
    let text = &moved.urdf_text;
    reads_back(&moved);
    // One mass for each body that moves, and the plate's on the base.
    assert_eq!(text.matches("<mass").count(), 3, "{text}");
    assert!(
        text.contains("<link  name='turn' ><inertial>") && text.contains("<link name=\"slide\"><inertial>"),
        "{text}"
    );
    assert!(text.contains("<link name=\"plate\"><inertial><mass value=\"5\"/>"), "what does not move stays: {text}");
    assert!(text.contains("<link name=\"rim\"/>") && text.contains("<!-- <link name=\"turn\"/> is no link here -->"));
}

#[test]
fn equivalent_a_joint_that_is_held_leaves_its_mass_to_the_body_before_it() {
    let one = SPARSE_MODEL.replace("[joints.j2]\ngear_ratio = 5.0\n", "");
    let nominal = texts(&one, SPARSE).expect("a model with a held joint");
    assert_eq!(nominal.held, ["j2"]);
    assert_eq!(nominal.robot.bodies[0].inertia.mass, 2.5);
    let moved = nominal.deviating(&drawn(&nominal, 4));
    reads_back(&moved);
    assert_eq!(moved.urdf_text.matches("<mass").count(), 2, "{}", moved.urdf_text);
}

/// The arm as vendors publish it: a mesh of a package, and one beside the URDF.
#[test]
fn regress_meshes_are_found_from_the_folder_of_a_deviating_model() {
    let place = tempfile::tempdir().expect("a folder");
    let (urdf, meshes) = (place.path().join("arm/urdf"), place.path().join("arm/meshes"));
    [&urdf, &meshes].into_iter().for_each(|folder| std::fs::create_dir_all(folder).expect("a folder"));
    let tetrahedron = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    [meshes.join("a&b.obj"), urdf.join("beside.obj")]
        .iter()
        .for_each(|file| std::fs::write(file, tetrahedron).expect("a mesh"));
    let shape = |name: &str| {
        format!("<collision><geometry><mesh filename=\"{name}\" scale=\"2 2 2\"/></geometry></collision></link>")
    };
    let text = URDF.replacen("</link>", &shape("package://arm/meshes/a&amp;b.obj"), 1);
    let (first, last) = text.rsplit_once("</link>").expect("a link");
    let text = format!("{first}{}{last}", shape("beside.obj"));
    std::fs::write(urdf.join("elbow.urdf"), text).expect("the URDF");
    std::fs::write(urdf.join("model.toml"), MODEL).expect("the model");
    let exact = Model::load(&urdf.join("model.toml")).expect("the elbow with meshes");
    let nominal = Model { accuracy: Accuracy::default(), ..exact };
    let moved = nominal.deviating(&drawn(&nominal, 5));
    assert!(nominal.robot.bodies.iter().any(|body| !body.shapes.is_empty()), "meshes are read");
    reads_back(&moved);
}
