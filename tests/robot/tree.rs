//! What a URDF and a model file become.

use std::path::Path;

use lostmotion::dynamics::{Dynamics, MotionCheck};
use lostmotion::robot::{Geometry, Model};
use lostmotion::units::JointKind;

use super::{MODEL, URDF, texts};

fn load(name: &str) -> Model {
    Model::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name).join("model.toml")).unwrap()
}

#[test]
fn published_emps_mass_and_drive_gain_are_those_of_its_paper() {
    let model = load("emps");
    let joint = &model.joints[0];
    assert_eq!(joint.kind, JointKind::Prismatic);
    let mass = joint.reflected_inertia() + model.robot.bodies[0].inertia.mass;
    // The model file gives seven digits of the rotor inertia.
    assert!((mass - 95.1089).abs() < 1e-4, "M = {mass} kg");
    assert!((joint.torque_per_ampere() - 35.150_651_882).abs() < 1e-8, "gtau = {} N/V", joint.torque_per_ampere());
    assert!((joint.encoder_step() - 5e-8).abs() < 1e-15);
    // Friction is left to be identified; the published models have no gap.
    assert!(joint.friction.is_none());
    assert_eq!(joint.backlash, Some(0.0));
}

#[test]
fn analytic_elbow_merges_its_tool_with_steiner() {
    let model = load("elbow");
    let forearm = &model.robot.bodies[1];
    assert_eq!(forearm.parent, Some(0));
    assert_eq!(forearm.inertia.mass, 2.6);
    let com = -(1.8 * 0.15 + 0.8 * 0.35) / 2.6;
    assert!((forearm.inertia.com.z - com).abs() < 1e-15);
    let moment = 0.019 + 1.8 * 0.15 * 0.15 + 0.0006 + 0.8 * 0.35 * 0.35;
    let about_joint = forearm.inertia.tensor_about(&Default::default());
    assert!((about_joint[(1, 1)] - moment).abs() < 1e-15);
    assert_eq!(forearm.shapes.len(), 2);
    assert_eq!(model.held, Vec::<String>::new());
}

#[test]
fn property_what_other_tools_add_to_a_urdf_is_left_alone() {
    let additions = r#"<gazebo reference="tool"><link/><joint name="a"/></gazebo><transmission name="t"/><!-- <link/> -->
      <joint name="tool_mount" "#;
    let urdf = URDF.replacen("<joint name=\"tool_mount\" ", additions, 1).replacen(
        "<link name=\"tool\">",
        "<link name=\"tool\"><sensor a=\"b > c\"><origin xyz=\"none\"/></sensor>",
        1,
    );
    assert_eq!(texts(MODEL, &urdf).unwrap().robot, texts(MODEL, URDF).unwrap().robot);
}

/// Four joints with rolled, pitched and yawed frames and inertial frames; one slides, one branches off.
const TWISTED: &str = r#"<robot name="twisted">
  <link name="base"/>
  <link name="a"><inertial><origin xyz="0.1 -0.2 0.05" rpy="0.3 -0.4 1.1"/><mass value="2"/>
    <inertia ixx="0.03" ixy="0.002" ixz="-0.001" iyy="0.04" iyz="0.003" izz="0.05"/></inertial></link>
  <link name="b"><inertial><origin xyz="0 0.1 0.3" rpy="1.3 0.4 -0.7"/><mass value="1.5"/>
    <inertia ixx="0.02" ixy="-0.002" ixz="0.001" iyy="0.03" iyz="0.001" izz="0.04"/></inertial></link>
  <link name="c"><inertial><origin xyz="0.2 0 0" rpy="0 0.9 0.2"/><mass value="0.7"/>
    <inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.012" iyz="0" izz="0.015"/></inertial></link>
  <link name="d"><inertial><origin xyz="-0.1 0.1 0.2" rpy="0.1 0.2 0.3"/><mass value="0.5"/>
    <inertia ixx="0.005" ixy="0" ixz="0" iyy="0.006" iyz="0.001" izz="0.007"/></inertial></link>
  <joint name="ja" type="continuous"><parent link="base"/><child link="a"/>
    <origin xyz="0 0 0.3" rpy="0.2 0.1 -0.5"/><axis xyz="0 0.6 0.8"/></joint>
  <joint name="jb" type="continuous"><parent link="a"/><child link="b"/>
    <origin xyz="0.3 0.1 0" rpy="1.2 -0.8 0.4"/><axis xyz="1 0 0"/></joint>
  <joint name="jc" type="prismatic"><parent link="b"/><child link="c"/>
    <origin xyz="0 0.2 0.3" rpy="-0.4 0.6 2.0"/><axis xyz="0 1 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="jd" type="continuous"><parent link="b"/><child link="d"/>
    <origin xyz="-0.1 0 0.1" rpy="0.7 0.7 0.7"/><axis xyz="0 -1 0.3"/></joint>
</robot>"#;

fn listing(joints: &[&str]) -> String {
    let start = "schema = 'lostmotion/model/1'\nname = 'm'\nurdf = 'm.urdf'\n".to_owned();
    joints.iter().fold(start, |text, joint| {
        text + &format!("[joints.{joint}]\ngear_ratio = 1\nrotor_inertia = 1\ngear_stiffness = 1\n")
            + "motor = { torque_constant = 1 }\n"
    })
}

#[test]
fn equivalent_a_held_joint_moves_like_one_that_stands_at_zero() {
    let all = ["ja", "jb", "jc", "jd"];
    let whole = texts(&listing(&all), TWISTED).unwrap();
    for held in 0..4 {
        let moving: Vec<usize> = (0..4).filter(|&i| i != held).collect();
        let names: Vec<&str> = moving.iter().map(|&i| all[i]).collect();
        let merged = texts(&listing(&names), TWISTED).unwrap();
        assert_eq!(merged.held, [all[held]]);
        // In the order of the tree, whatever the order of the listing.
        let order: Vec<&str> = merged.robot.bodies.iter().map(|body| body.joint.name.as_str()).collect();
        assert_eq!(order, names);
        let (mut q, mut v) = ([0.4, -1.1, 0.3, 2.0], [1.0, -0.5, 0.7, 0.2]);
        (q[held], v[held]) = (0.0, 0.0);
        let [mut tau, mut less] = [vec![0.0; 4], vec![0.0; 3]];
        Dynamics::new(&whole.robot).inverse(&q, &v, &v, &mut tau);
        let [q, v] = [q, v].map(|all| moving.iter().map(|&i| all[i]).collect::<Vec<f64>>());
        Dynamics::new(&merged.robot).inverse(&q, &v, &v, &mut less);
        for (i, tau_i) in moving.iter().zip(&less) {
            // Rounding of some hundred operations on efforts of some 10 N·m.
            assert!((tau[*i] - tau_i).abs() < 1e-12, "{held} held: {tau:?} against {less:?}");
        }
    }
}

#[test]
fn property_a_joint_that_mimics_is_held_and_said_whatever_it_follows() {
    let urdf = TWISTED.replacen("<axis xyz=\"0 1 1\"/>", "<axis xyz=\"0 1 1\"/><mimic joint=\"jd\"/>", 1);
    for (moving, held) in [(["ja", "jb"], &["jd"][..]), (["ja", "jd"], &["jb"])] {
        let model = texts(&listing(&moving), &urdf).unwrap();
        assert_eq!(model.held, held);
        let remark = model.remarks[0].to_string();
        assert!(
            remark.ends_with("joint jc: it mimics jd; this is not simulated: it is held at its offset, 0 m"),
            "{remark}"
        );
    }
    // Listed as a joint that moves, it is refused.
    let error = texts(&listing(&["ja", "jc"]), &urdf).unwrap_err().to_string();
    assert!(error.contains("joint jc: mimic: expected a joint of its own"), "{error}");
}

#[test]
fn property_meshes_become_hulls_and_unreadable_ones_are_kept_for_the_motion_check() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("twisted/urdf/m.urdf");
    std::fs::create_dir_all(folder.path().join("twisted/urdf")).unwrap();
    std::fs::write(folder.path().join("m.toml"), listing(&["ja"]).replace("m.urdf", "twisted/urdf/m.urdf")).unwrap();
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let obj: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    std::fs::write(folder.path().join("twisted/urdf/a.obj"), obj).unwrap();
    let vertex = |&i: &usize| format!("vertex {} {} {}\n", corners[i][0], corners[i][1], corners[i][2]);
    let text: String = faces.iter().map(|face| face.iter().map(vertex).collect::<String>()).collect();
    std::fs::write(folder.path().join("twisted/a.stl"), format!("solid a\n{text}endsolid\n")).unwrap();
    let mut binary = b"solid but binary".to_vec();
    binary.resize(80, b' ');
    binary.extend(4_u32.to_le_bytes());
    for face in faces {
        let numbers = [0.0; 3].into_iter().chain(face.iter().flat_map(|&i| corners[i]));
        binary.extend(numbers.flat_map(|x| (x as f32).to_le_bytes()).chain([0, 0]));
    }
    std::fs::write(folder.path().join("twisted/urdf/b.stl"), &binary).unwrap();
    std::fs::write(folder.path().join("twisted/urdf/cut.stl"), &binary[..200]).unwrap();
    std::fs::write(folder.path().join("twisted/urdf/flat.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();

    let load = |mesh: &str| {
        let collision = format!("<link name=\"a\"><collision><geometry>{mesh}</geometry></collision>");
        std::fs::write(&urdf, TWISTED.replacen("<link name=\"a\">", &collision, 1)).unwrap();
        Model::load(&folder.path().join("m.toml")).unwrap().robot
    };
    for mesh in ["a.obj", "package://twisted/a.stl", "b.stl"] {
        let robot = load(&format!("<mesh filename=\"{mesh}\" scale=\"0.1 0.1 0.2\"/>"));
        let Geometry::ConvexHull(points) = &robot.bodies[0].shapes[0].geometry else { panic!("{mesh}") };
        let most = points.iter().fold([0.0_f64; 3], |most, p| [0, 1, 2].map(|i| most[i].max(p[i])));
        assert!(most.iter().zip([0.2, 0.3, 0.8]).all(|(a, b)| (a - b).abs() < 1e-12), "{mesh}: {most:?}");
        assert!(MotionCheck::new(&robot).is_ok());
    }
    for (mesh, expected) in [
        ("none.obj", "a file that can be read (No such file or directory (os error 2))"),
        ("m.dae", "a file that can be read (No such file or directory (os error 2))"),
        ("../../m.toml", "an STL, OBJ or MSH mesh"),
        ("cut.stl", "a complete mesh"),
        ("flat.obj", "at least 4 points, not 3"),
        ("package://elsewhere/a.stl", "a package whose folder is above the URDF, or beside a folder above it"),
    ] {
        let robot = load(&format!("<mesh filename=\"{mesh}\"/>"));
        assert_eq!(robot.unread_shapes[0].expected, expected, "{mesh}");
        let error = MotionCheck::new(&robot).err().expect(mesh).to_string();
        assert!(error.ends_with(&format!("collision mesh of link a: expected {expected}")), "{error}");
    }
}

#[test]
fn property_a_link_without_mass_may_be_fixed_but_not_alone_in_moving() {
    let no_tool = URDF.replacen("<mass value=\"0.8\"/>", "<mass value=\"0\"/>", 1).replacen(
        "<inertia ixx=\"0.0006\" ixy=\"0\" ixz=\"0\" iyy=\"0.0006\" iyz=\"0\" izz=\"0.0005\"/>",
        "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>",
        1,
    );
    assert_eq!(texts(MODEL, &no_tool).unwrap().robot.bodies[1].inertia.mass, 1.8);
    // The forearm itself without an inertial, the tool still there: the tool is what moves.
    let inertial = |urdf: &str, link: &str| {
        let start = urdf.find(&format!("<link name=\"{link}\">")).unwrap();
        let from = start + urdf[start..].find("<inertial>").unwrap();
        let to = from + urdf[from..].find("</inertial>").unwrap() + "</inertial>".len();
        format!("{}{}", &urdf[..from], &urdf[to..])
    };
    let light = inertial(URDF, "forearm");
    assert_eq!(texts(MODEL, &light).unwrap().robot.bodies[1].inertia.mass, 0.8);
    let error = texts(MODEL, &inertial(&light, "tool")).unwrap_err().to_string();
    assert_eq!(
        error,
        "elbow/elbow.urdf:21: link forearm: mass = 0: expected a mass ≥ 1e-9 [kg] of the link that moves and all that is fixed to it"
    );
}

#[test]
fn property_joints_that_the_model_does_not_list_are_held_at_zero() {
    let shoulder_only = MODEL.split("[joints.elbow]").next().unwrap();
    let model = texts(shoulder_only, URDF).unwrap();
    assert_eq!(model.held, ["elbow"]);
    assert_eq!(model.robot.dof(), 1);
    let inertia = model.robot.bodies[0].inertia;
    assert!((inertia.mass - 5.8).abs() < 1e-12);
    // Hanging straight: upper arm, forearm and tool below each other.
    let com = -(3.2 * 0.18 + 1.8 * 0.55 + 0.8 * 0.75) / 5.8;
    assert!((inertia.com.z - com).abs() < 1e-12);
    assert_eq!(model.robot.bodies[0].shapes.len(), 3);
}
