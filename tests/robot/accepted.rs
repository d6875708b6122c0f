//! URDFs that tools write and that a strict reader would refuse: each is accepted with a remark that names its line, or refused for a reason.

use lostmotion::dynamics::Dynamics;
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::Model;
use nalgebra::DMatrix;

use super::{MODEL, URDF, texts};

/// A URDF with one change, and the remarks that it is accepted with, without the name of the file.
const ACCEPTED: &[(&str, &str, &[&str])] = &[
    // Numbers.
    (
        "ixy=\"0\" ixz=\"0\" iyy=\"0.0460\" iyz=\"0\"",
        "ixz=\"0\" iyy=\"0.0460\" iyz=\"\"",
        &[
            ":14: link upper_arm: inertia without ixy: taken as 0",
            ":14: link upper_arm: inertia iyz = \"\": taken as not given",
        ],
    ),
    // Name spaces and what they bring.
    ("<robot name=\"elbow\">", "<robot name=\"elbow\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">", &[]),
    ("<link name=\"tool\">", "<!-- <xacro:include filename=\"x\"/> --><link name=\"tool\">", &[]),
    ("<link name=\"tool\">", "<drake:filter><drake:member link=\"tool\"/></drake:filter><link name=\"tool\">", &[]),
    ("effort=\"20\"", "drake:acceleration=\"2.5\" effort=\"20\"", &[]),
    // What only a display needs.
    ("<link name=\"tool\">", "<material name=\"a\"/><material name=\"a\"/><link name=\"tool\">", &[]),
    (
        "<link name=\"tool\">",
        "<link name=\"tool\"><visual><geometry><mesh scale=\"1 1 1 1\"/><material/></geometry></visual><visual/>",
        &[],
    ),
    // Types of other dialects.
    (
        "name=\"tool_mount\" type=\"fixed\"",
        "name=\"tool_mount\" type=\"spherical\"",
        &[":57: joint tool_mount: of type spherical: it is held fixed, as the base of the robot is"],
    ),
    ("<sphere radius=\"0.035\"/>", "<mesh filename=\"a.stl\" scale=\"1 1 1 1\"/>", &[]),
    // Collision shapes; they are noted as shapes that were not read.
    ("<sphere radius=\"0.035\"/>", "<mesh/>", &[]),
    ("<sphere radius=\"0.035\"/>", "<sphere radius=\"0\"/>", &[]),
    ("<sphere radius=\"0.035\"/>", "<cone radius=\"0.035\"/>", &[]),
    ("<geometry><sphere radius=\"0.035\"/></geometry>", "", &[]),
    // Elements and numbers.
    (
        "<axis xyz=\"0 -1 0\"/>",
        "<axis xyz=\"0 -1 0\"/>\n<axis xyz=\"0 0 1\"/>",
        &[":48: joint shoulder: a second <axis> has no effect, the first in line 47 counts"],
    ),
    (
        "    <inertial>\n      <origin xyz=\"0 0 0\"/>",
        "<inertial><mass value=\"0.8\"/><inertia ixx=\"1e-4\" ixy=\"0\" ixz=\"0\" iyy=\"1e-4\" iyz=\"0\" izz=\"1e-4\"/></inertial>
    <inertial>\n      <origin xyz=\"0 0 0\"/>",
        &[":34: link tool: a second <inertial> has no effect, the first in line 33 counts"],
    ),
    (
        "<origin xyz=\"0 0 -0.40\"/>",
        "<origin xyz=\"0, 0, -0.40\"/>",
        &[":53: joint elbow: origin xyz = \"0, 0, -0.40\": the commas are taken as spaces"],
    ),
    ("<link name=\"tool\">", "<link name=\"tool\" info=\"a &lt; b &#38; c\">", &[]),
    // The tree.
    (
        "<link name=\"tool\">",
        "<joint name=\"weld\" type=\"fixed\"><parent link=\"world\"/><child link=\"bracket\"/></joint>\n<link name=\"tool\">",
        &[":32: joint weld: parent world is no link of this file and is taken as the base"],
    ),
    (
        "<link name=\"tool\">",
        "<link name=\"shelf\"/><link name=\"tool\">",
        &[":32: link shelf: no joint attaches it to the robot: it is left out"],
    ),
    (
        "name=\"tool_mount\" type=\"fixed\"",
        "name=\"tool_mount\" type=\"floating\"",
        &[":57: joint tool_mount: of type floating: it is held fixed, as the base of the robot is"],
    ),
    (
        "<parent link=\"forearm\"/>",
        "<parent link=\"forearm\"/><mimic joint=\"elbow\" multiplier=\"-1\" offset=\"0.2\"/>",
        &[],
    ),
    // Limits.
    (
        "<limit lower=\"-2.4\" upper=\"2.4\" effort=\"20\" velocity=\"4.0\"/>",
        "",
        &[":50: joint elbow: no <limit>: its range, effort and velocity are taken as unlimited"],
    ),
    (" velocity=\"4.0\"", "", &[":55: joint elbow: limit without velocity: taken as unlimited"]),
    ("effort=\"20\"", "effort=\"-1\"", &[":55: joint elbow: limit effort below 0 is taken as not given"]),
    ("effort=\"20\"", "effort=\"0\"", &[":55: joint elbow: limit effort of 0 is taken as not given"]),
    // A fixed joint has no limits.
    ("<origin xyz=\"0 0 -0.35\"/>", "<origin xyz=\"0 0 -0.35\"/><limit lower=\"1\" upper=\"-1\"/>", &[]),
    // Inertias.
    (
        "<link name=\"bracket\">",
        "<link name=\"bracket\"><inertial><mass value=\"-1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"-1\"/></inertial>",
        &[],
    ),
    (
        "iyy=\"0.0460\" iyz=\"0\" izz=\"0.0040\"",
        "iyy=\"0.0460\" iyz=\"0\" izz=\"0.1\"",
        &[
            ":14: link upper_arm: no rigid body has the inertia, [ixx 4.6000e-2, ixy 0.0000e0, ixz 0.0000e0, iyy 4.6000e-2, iyz 0.0000e0, izz \
           1.0000e-1] about the centre of mass: principal moments 4.6000e-2, 4.6000e-2, 1.0000e-1 kg·m²; expected none above the sum of \
           the others. The nearest one that a body of this mass has is used: [ixx 5.0000e-2, ixy 0.0000e0, ixz 0.0000e0, iyy 5.0000e-2, \
           iyz 0.0000e0, izz 1.0000e-1] kg·m²",
        ],
    ),
    (
        "iyy=\"0.0190\" iyz=\"0\" izz=\"0.0015\"",
        "iyy=\"0.0190\" iyz=\"0\" izz=\"0.0500\"",
        &[":25: link forearm: no rigid body has its inertia: principal moments 1.9000e-2, 1.9000e-2, 5.0000e-2 kg·m²; expected none above \
           the sum of the others. It is used as it stands, summed with the links fixed to it"],
    ),
    (
        "<mass value=\"0.8\"/>",
        "<mass value=\"0\"/>",
        &[":36: link tool: no rigid body has its inertia: moments of inertia without a mass. It is used as it stands, summed with the links fixed \
           to it"],
    ),
    (
        "<inertia ixx=\"0.0460\" ixy=\"0\" ixz=\"0\" iyy=\"0.0460\" iyz=\"0\" izz=\"0.0040\"/>",
        "",
        &[":11: link upper_arm: no <inertia>: its mass counts as that of a point"],
    ),
    (
        "<mass value=\"3.2\"/>\n      <inertia ixx=\"0.0460\" ixy=\"0\" ixz=\"0\" iyy=\"0.0460\" iyz=\"0\" izz=\"0.0040\"/>",
        "<mass value=\"0\"/>",
        &[":13: link upper_arm: no mass: joint shoulder moves only the links beyond this one"],
    ),
];

#[test]
fn property_what_tools_write_is_accepted_and_said() {
    let mut wrong = Vec::new();
    for &(sound, changed, remarks) in ACCEPTED {
        assert!(URDF.contains(sound), "{sound}");
        let found = texts(MODEL, &URDF.replacen(sound, changed, 1)).map(|model| {
            Plant::new(&model, &Options::default()).unwrap_or_else(|error| panic!("{changed}: {error}"));
            model.remarks.iter().map(ToString::to_string).collect::<Vec<_>>()
        });
        let expected: Vec<String> = remarks.iter().map(|remark| format!("elbow/elbow.urdf{remark}")).collect();
        if found.as_ref().ok() != Some(&expected) {
            wrong.push(format!("{changed}\n  found    {found:?}\n  expected {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A URDF with one change that leaves no meaning to take, and the message that says so.
const REFUSED: &[(&str, &str, &str)] = &[
    (
        "<link name=\"tool\">",
        "<xacro:include filename=\"x\"/><link name=\"tool\">",
        ":32: expected plain URDF, not <xacro:include>; run xacro on this file first",
    ),
    (
        "<origin xyz=\"0 0 -0.40\"/>",
        "<origin xyz=\"${x} 0 0\"/>",
        ":53: joint elbow: origin xyz = \"${x} 0 0\": expected 3 numbers; run xacro on this file first",
    ),
    (
        "<link name=\"tool\">",
        "<link name=\"a\"/><link name=\"b\"/><joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint><link name=\"tool\">",
        ":32: links without a joint = bracket, a: expected one link that no joint moves (the base); attach each of the others to it by a fixed joint",
    ),
    (
        "<parent link=\"bracket\"/>",
        "<parent link=\"earth\"/>",
        ":44: joint shoulder: parent = earth: expected a link of this file",
    ),
    (
        "<origin xyz=\"0 0 -0.40\"/>",
        "<origin xyz=\"0,1 0,2 -0,4\"/>",
        ":53: joint elbow: origin xyz = \"0,1 0,2 -0,4\": expected 3 numbers",
    ),
    (
        "<link name=\"tool\">",
        "<link name=\"tool\" info=\"a & b\">",
        ":32: URDF: expected &amp; for the character `&`, or an entity that XML knows",
    ),
    ("<link name=\"tool\">", "<link name=tool>", ":32: URDF: expected attributes as name=\"value\" in <link>"),
    (
        "lower=\"-2.4\" upper=\"2.4\"",
        "lower=\"2.4\" upper=\"-2.4\"",
        ":55: joint elbow: limit = lower 2.4, upper -2.4: expected lower ≤ upper",
    ),
];

#[test]
fn property_what_has_no_meaning_is_refused_with_its_line() {
    for &(sound, changed, message) in REFUSED {
        assert!(URDF.contains(sound), "{sound}");
        let found = texts(MODEL, &URDF.replacen(sound, changed, 1)).expect_err(changed).to_string();
        assert_eq!(found, format!("elbow/elbow.urdf{message}"), "{changed}");
    }
}

/// The first model of the elbow with some changes.
fn first_model(changes: &[(&str, &str)]) -> lostmotion::error::Result<Model> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("elbow.urdf");
    let change = |text: String, (from, to): &(&str, &str)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    std::fs::write(&file, changes.iter().fold(URDF.to_owned(), change)).unwrap();
    lostmotion::plant::first_model(&file).map(|first| first.model)
}

const ROLL: (&str, &str) = (
    "name=\"tool_mount\" type=\"fixed\">",
    "name=\"tool_mount\" type=\"revolute\"><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
);

#[test]
fn equivalent_a_joint_that_mimics_is_held_at_its_offset() {
    let mimic = "<parent link=\"forearm\"/><mimic joint=\"elbow\" multiplier=\"-1\" offset=\"0.2\"/>";
    let mut model = first_model(&[ROLL, ("<parent link=\"forearm\"/>", mimic)]).unwrap();
    let tilted =
        first_model(&[("<origin xyz=\"0 0 -0.35\"/>", "<origin xyz=\"0 0 -0.35\" rpy=\"0 0.2 0\"/>")]).unwrap();
    // A rotation about y by 0.2 rad, written as an axis or as rpy: rounding of its sines.
    let difference = model.robot.bodies[1].inertia.tensor - tilted.robot.bodies[1].inertia.tensor;
    assert!(difference.amax() < 1e-15, "{difference}");
    let text = model.remarks.remove(0).to_string();
    assert!(
        text.ends_with("joint tool_mount: it mimics elbow; this is not simulated: it is held at its offset, 0.2 rad"),
        "{text}"
    );
    assert!(model.remarks.is_empty() && model.held.is_empty());
}

#[test]
fn property_a_joint_without_anything_to_move_is_held_in_a_first_model() {
    let bare = [
        ("<mass value=\"0.8\"/>", "<mass value=\"0\"/>"),
        (
            "ixx=\"0.0006\" ixy=\"0\" ixz=\"0\" iyy=\"0.0006\" iyz=\"0\" izz=\"0.0005\"",
            "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"",
        ),
    ];
    let model = first_model(&[ROLL, bare[0], bare[1]]).unwrap();
    assert_eq!(model.held, ["tool_mount"]);
    assert!(model.remarks.iter().any(|remark| remark.text.starts_with("it moves no mass and is held at zero")));
    // Asked to move, it is refused.
    let listed = MODEL.to_owned() + "[joints.tool_mount]\ngear_ratio = 1.0\n";
    let urdf = [ROLL, bare[0], bare[1]].iter().fold(URDF.to_owned(), |text, (from, to)| text.replacen(from, to, 1));
    let error = texts(&listed, &urdf).unwrap_err().to_string();
    assert!(
        error.contains(":32: link tool: mass = 0: expected a mass ≥ 1e-9 [kg]")
            || error.contains(":35: link tool: mass = 0"),
        "{error}"
    );
}

#[test]
fn property_a_finger_gets_a_gear_that_a_simulation_can_follow() {
    let small = [
        ("<mass value=\"0.8\"/>", "<mass value=\"0.001\"/>"),
        (
            "ixx=\"0.0006\" ixy=\"0\" ixz=\"0\" iyy=\"0.0006\" iyz=\"0\" izz=\"0.0005\"",
            "ixx=\"1e-8\" ixy=\"0\" ixz=\"0\" iyy=\"1e-8\" iyz=\"0\" izz=\"1e-8\"",
        ),
    ];
    let model = first_model(&[ROLL, small[0], small[1]]).unwrap();
    // Its gear is chosen by its weight, 0.001 kg at 0.35 m at most, and not that of an arm.
    let stiffness = model.joints[2].gear_stiffness.unwrap();
    assert!(stiffness < 1.0, "{stiffness}");
    Plant::new(&model, &Options::default()).unwrap();
}

#[test]
fn property_a_joint_that_no_inertia_resists_is_held_in_a_first_model() {
    // Three axes that meet, and a point mass: a turn about the line from their point through the mass meets no inertia.
    let gimbal = "<link name=\"a\"/><link name=\"b\"/><link name=\"head\"><inertial><origin xyz=\"0.1 0.2 0.3\"/><mass value=\"1\"/>
      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial></link>
    <joint name=\"pitch\" type=\"continuous\"><parent link=\"forearm\"/><child link=\"a\"/><axis xyz=\"0 1 0\"/></joint>
    <joint name=\"roll\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"1 0 0\"/></joint>
    <joint name=\"yaw\" type=\"continuous\"><parent link=\"b\"/><child link=\"head\"/><axis xyz=\"0 0 1\"/></joint>
  <link name=\"tool\">";
    let model = first_model(&[("<link name=\"tool\">", gimbal)]).unwrap();
    assert_eq!(model.held, ["yaw"]);
    let remark = model.remarks.iter().find(|remark| remark.about == "joint yaw").unwrap();
    assert!(remark.text.starts_with("no inertia resists it while the joints before it are free"), "{remark}");
    Plant::new(&model, &Options::default()).unwrap();
    // With a tensor all three move.
    let sound = gimbal
        .replace("ixx=\"0\"", "ixx=\"0.01\"")
        .replace("iyy=\"0\"", "iyy=\"0.01\"")
        .replace("izz=\"0\"", "izz=\"0.01\"");
    let model = first_model(&[("<link name=\"tool\">", &sound)]).unwrap();
    assert!(model.held.is_empty(), "{:?}", model.held);
}

#[test]
fn property_a_massless_link_within_a_chain_leaves_the_mass_matrix_positive() {
    // Shoulder of two joints, pitch and roll, with nothing but a frame between them.
    let frame = "<link name=\"frame\"/><joint name=\"roll\" type=\"continuous\"><parent link=\"frame\"/><child link=\"upper_arm\"/><axis xyz=\"1 0 0\"/></joint>
  <link name=\"tool\">";
    let model = first_model(&[
        ("<link name=\"tool\">", frame),
        ("<child link=\"upper_arm\"/>\n    <origin xyz=\"0 0 0\"/>", "<child link=\"frame\"/>"),
    ])
    .unwrap();
    assert_eq!(model.robot.dof(), 3);
    let mut m = DMatrix::zeros(3, 3);
    Dynamics::new(&model.robot).mass_matrix(&[0.4, -0.3, 0.8], &mut m);
    assert!(m.clone().cholesky().is_some(), "{m}");
    // Both engines have it alike, and it falls.
    let mut plant = Plant::new(&model, &Options::default()).unwrap();
    for _ in 0..50 {
        plant.advance(&[0.0; 3], 0.001).unwrap();
    }
    assert!(
        model
            .remarks
            .iter()
            .any(|remark| remark.text == "no mass: joint shoulder moves only the links beyond this one")
    );
}

#[test]
fn equivalent_links_fixed_to_each_other_have_the_mass_matrix_of_the_body_they_make() {
    let merged = texts(MODEL, URDF).unwrap();
    // The same arm, its tool lumped into the forearm by hand.
    let body = merged.robot.bodies[1].inertia;
    let tensor = body.tensor;
    let lumped = format!(
        "<origin xyz=\"0 0 {}\"/><mass value=\"{}\"/><inertia ixx=\"{}\" ixy=\"0\" ixz=\"0\" iyy=\"{}\" iyz=\"0\" izz=\"{}\"/>",
        -(1.8 * 0.15 + 0.8 * 0.35) / 2.6,
        2.6,
        tensor[(0, 0)],
        tensor[(1, 1)],
        tensor[(2, 2)]
    );
    let inertial = |text: &str, link: &str, content: &str| {
        let start = text.find(&format!("<link name=\"{link}\">")).unwrap();
        let from = start + text[start..].find("<inertial>").unwrap() + "<inertial>".len();
        let to = from + text[from..].find("</inertial>").unwrap();
        format!("{}{content}{}", &text[..from], &text[to..])
    };
    let none = "<mass value=\"0\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>";
    let alone = texts(MODEL, &inertial(&inertial(URDF, "forearm", &lumped), "tool", none)).unwrap();
    for q in [[0.3, -1.1], [-0.7, 0.2]] {
        let [mut a, mut b] = [DMatrix::zeros(2, 2), DMatrix::zeros(2, 2)];
        Dynamics::new(&merged.robot).mass_matrix(&q, &mut a);
        Dynamics::new(&alone.robot).mass_matrix(&q, &mut b);
        // Some ten additions of numbers below 1.
        assert!((&a - &b).amax() < 1e-15, "{a}{b}");
    }
}
