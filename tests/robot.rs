//! Model files and URDF files: what they become, and how broken ones are refused.

mod support;

use std::path::Path;

use lostmotion::toml_input::{Document, Range};

const FILE: &str = "model.toml";

fn parse(text: &str) -> Document {
    Document::parse(Path::new(FILE), text).expect("valid TOML")
}

/// The message of an error must be this, to the letter.
#[track_caller]
fn refused<T: std::fmt::Debug>(result: lostmotion::error::Result<T>, message: &str) {
    assert_eq!(result.expect_err("must be refused").to_string(), message);
}

#[test]
fn property_toml_errors_name_file_line_key_value_and_expectation() {
    let document = parse("a = -1\n\n[b.c]\nname = 3\nlist = [1, 2.5]\nsize = inf\n\n[[d]]\n[[d]]\nx = 'y'\n");
    let root = document.root();
    refused(root.number("a", &Range::positive("kg")), "model.toml:1: a = -1: expected a number > 0 [kg]");
    refused(root.number("z", &Range::any("kg")), "model.toml:1: z: expected a finite number [kg] (missing)");
    let c = root.table("b").unwrap().table("c").unwrap();
    refused(c.text("name"), "model.toml:4: b.c.name = 3: expected text in quotes");
    refused(c.text("nome"), "model.toml:3: b.c.nome: expected text in quotes (missing)");
    refused(
        c.optional_vector::<3>("list", &Range::any("m")),
        "model.toml:5: b.c.list = [1, 2.5]: expected a list of 3, each a finite number [m]",
    );
    refused(c.number("size", &Range::any("m")), "model.toml:6: b.c.size = inf: expected a finite number [m]");
    refused(
        c.optional_choice("name", &[("signed", 1), ("absolute", 2)]),
        "model.toml:4: b.c.name = 3: expected \"signed\" or \"absolute\"",
    );
    let d = root.tables("d").unwrap();
    refused(d[1].remaining_numbers(), "model.toml:10: d[2].x = 'y': expected a finite number [SI]");
}

#[test]
fn property_toml_unknown_keys_are_refused_with_the_nearest_known_one() {
    let document = parse("gear_ratoi = 1\n");
    let root = document.root();
    root.optional_number("gear_ratio", &Range::any("1")).unwrap();
    root.optional_text("name").unwrap();
    refused(root.finish(), "model.toml:1: gear_ratoi = 1: expected the key `gear_ratio` (unknown key)");
    let document = parse("\ncolour = 1\n");
    let root = document.root();
    root.optional_text("name").unwrap();
    refused(root.finish(), "model.toml:2: colour = 1: expected one of the keys `name` (unknown key)");
}

#[test]
fn property_toml_broken_syntax_names_its_line() {
    let error = Document::parse(Path::new(FILE), "a = 1\nb = = 2\n").unwrap_err().to_string();
    assert!(error.starts_with("model.toml:2: expected TOML: "), "{error}");
}

#[test]
fn property_toml_values_set_by_assignment_replace_those_of_the_file() {
    let mut document = parse("[control]\nkp = 1\n");
    document.set("control.kp = 2.5").unwrap();
    document.set("name=arm two").unwrap();
    let root = document.root();
    assert_eq!(root.table("control").unwrap().number("kp", &Range::any("1")).unwrap(), 2.5);
    assert_eq!(root.text("name").unwrap(), "arm two");
    document.set("control.kp = -3").unwrap();
    let root = document.root();
    refused(
        root.table("control").unwrap().number("kp", &Range::positive("1")),
        "model.toml: control.kp = -3: expected a number > 0 [1]",
    );
    refused(parse("").set("kp"), "model.toml: kp: expected an assignment KEY=VALUE");
}

mod machines {
    use super::*;
    use lostmotion::robot::Model;
    use lostmotion::units::JointKind;

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
        assert!(joint.friction.is_none() && joint.backlash.is_none());
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
}

mod files {
    use std::path::Path;

    use lostmotion::drive::{CurrentSensor, Sensing, VelocitySensor};
    use lostmotion::dynamics::{Dynamics, MotionCheck};
    use lostmotion::gearhead::{FrictionLaw, Lines};
    use lostmotion::robot::{EffectEntry, Geometry, Model};
    use rand::RngExt;

    use super::support::random;

    const MODEL: &str = include_str!("../robots/elbow/model.toml");
    const URDF: &str = include_str!("../robots/elbow/elbow.urdf");

    fn texts(model: &str, urdf: &str) -> Result<Model, lostmotion::error::Error> {
        Model::from_texts(model, urdf, Path::new("elbow/model.toml"))
    }

    /// Every change of a table must be refused with its message, to the letter; all that differ are shown.
    fn all_refused(text: &str, table: &[(&str, &str, &str)], read: impl Fn(&str) -> lostmotion::error::Result<Model>) {
        let mut wrong = Vec::new();
        for &(sound, broken, message) in table {
            assert!(text.contains(sound), "{sound}");
            let found = read(&text.replacen(sound, broken, 1)).expect_err(broken).to_string();
            if found != message {
                wrong.push(format!("{broken}\n  found    {found}\n  expected {message}"));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    /// A model file with one change, and the message that it must be refused with.
    const BROKEN_MODELS: &[(&str, &str, &str)] = &[
        (
            "lostmotion/model/1",
            "lostmotion/model/9",
            "elbow/model.toml:2: schema = \"lostmotion/model/9\": expected \"lostmotion/model/1\"",
        ),
        (
            "schema = \"lostmotion/model/1\"\n",
            "",
            "elbow/model.toml:1: schema: expected \"lostmotion/model/1\" (missing)",
        ),
        (
            "gear_ratio = 100.0",
            "gear_ratio = -100.0",
            "elbow/model.toml:7: joints.shoulder.gear_ratio = -100.0: expected a number > 0 [rad/rad]",
        ),
        (
            "gear_ratio = 100.0\n",
            "",
            "elbow/model.toml:6: joints.shoulder.gear_ratio: expected a number > 0 [rad/rad] (missing)",
        ),
        (
            "gear_stiffness = 15000.0 ",
            "gear_stifness = 15000.0 ",
            "elbow/model.toml:6: joints.shoulder.gear_stiffness: expected a number > 0 [N·m/rad] (missing)",
        ),
        (
            "gear_damping = 25.0 ",
            "gear_dampin = 25.0 ",
            "elbow/model.toml:10: joints.shoulder.gear_dampin = 25.0: expected the key `gear_damping` (unknown key)",
        ),
        (
            "resistance = 0.9 ",
            "resistance = nan ",
            "elbow/model.toml:15: joints.shoulder.motor.resistance = nan: expected a number > 0 [Ω]",
        ),
        (
            "resistance = 0.9                    # [Ω]\n",
            "",
            "elbow/model.toml:15: joints.shoulder.motor.inductance = 0.0008: expected a `resistance` beside it",
        ),
        (
            "counts_per_turn = 2000 ",
            "counts_per_turn = \"2000\" ",
            "elbow/model.toml:23: joints.shoulder.encoder.counts_per_turn = \"2000\": expected a number > 0 [1/turn]",
        ),
        (
            "method = \"pulse_period\"",
            "method = \"pulses\"",
            "elbow/model.toml:26: joints.shoulder.velocity_sensor.method = \"pulses\": expected \"pulse_period\" or \"low_pass\"",
        ),
        (
            "coulomb = [2.0, 2.2]",
            "coulomb = [2.0, -2.2]",
            "elbow/model.toml:33: joints.shoulder.friction.coulomb = [2.0, -2.2]: expected a number ≥ 0 [N·m], or two of them, [positive, negative]",
        ),
        (
            "stribeck_velocity = [0.030, 0.028]\n",
            "",
            "elbow/model.toml:32: joints.shoulder.friction.stribeck_velocity: expected a number > 0 [rad/s], or two of them, [positive, negative] (missing)",
        ),
        (
            "link_share = 0.1",
            "link_share = 1.1",
            "elbow/model.toml:37: joints.shoulder.friction.link_share = 1.1: expected a number from 0 to 1 [1]",
        ),
        (
            "[joints.elbow]",
            "[joints.elbw]",
            "elbow/model.toml:39: joints.elbw: expected a joint of elbow/elbow.urdf: a movable joint of it, such as elbow",
        ),
        (
            "[joints.elbow]",
            "[joints.tool_mount]",
            "elbow/model.toml:39: joints.tool_mount: expected a joint of elbow/elbow.urdf: one of its movable joints shoulder, elbow",
        ),
        ("urdf = \"elbow.urdf\"", "urdf = 3", "elbow/model.toml:4: urdf = 3: expected text in quotes"),
        (
            "urdf = \"elbow.urdf\"",
            "urdf = \"elbow.urdf\"\ngravity = [0, 0]",
            "elbow/model.toml:5: gravity = [0, 0]: expected a list of 3, each a finite number [m/s²]",
        ),
        (
            "urdf = \"elbow.urdf\"",
            "urdf = \"elbow.urdf\"\n[[effects]]\neffect = \"payload\"\njoint = \"elow\"",
            "elbow/model.toml:7: effects[1].joint = \"elow\": expected a joint of this model: elbow",
        ),
        (
            "urdf = \"elbow.urdf\"",
            "urdf = \"elbow.urdf\"\n[[effects]]\neffect = \"payload\"\nmass = \"1 kg\"",
            "elbow/model.toml:7: effects[1].mass = \"1 kg\": expected a finite number [SI]",
        ),
        (
            "coulomb = [2.0, 2.2]",
            "law = \"two_lines\"\na1 = 3\nb1 = 2\na2 = 2\nb2 = 3.0",
            "elbow/model.toml:38: joints.shoulder.friction.breakaway = [2.9, 3.1]: expected one of the keys \
             `a1`, `a2`, `b1`, `b2`, `law`, `link_share` (unknown key)",
        ),
        (
            "coulomb = [2.0, 2.2]",
            "law = \"two_lines\"\na1 = 3\nb1 = 2\na2 = 2\nb2 = 1.0",
            "elbow/model.toml:37: joints.shoulder.friction.b2 = 1.0: expected lines that meet at a speed > 0: (a1 − a2)/(b2 − b1) > 0",
        ),
    ];

    #[test]
    fn property_broken_model_files_are_refused_with_place_and_expectation() {
        all_refused(MODEL, BROKEN_MODELS, |text| texts(text, URDF));
    }

    /// A URDF with one change, and the message that it must be refused with.
    const BROKEN_URDFS: &[(&str, &str, &str)] = &[
        (
            "<mass value=\"1.8\"/>",
            "<mass value=\"-1.8\"/>",
            "elbow/elbow.urdf:24: link forearm: mass = -1.8: expected a mass ≥ 0 [kg]",
        ),
        (
            "<mass value=\"1.8\"/>",
            "<mass value=\"1.8 kg\"/>",
            "elbow/elbow.urdf:24: link forearm: mass value = \"1.8 kg\": expected a number",
        ),
        (
            "<mass value=\"1.8\"/>",
            "<mass/>",
            "elbow/elbow.urdf:24: link forearm: mass value: expected a number (missing)",
        ),
        (
            "iyy=\"0.0190\" iyz=\"0\" izz=\"0.0015\"",
            "iyy=\"0.0190\" iyz=\"0\" izz=\"0.0500\"",
            "elbow/elbow.urdf:25: link forearm: inertia = [ixx 0.019, ixy 0, ixz 0, iyy 0.019, iyz 0, izz 0.05]: expected \
             a tensor that a rigid body can have: principal moments 1.9000e-2, 1.9000e-2, 5.0000e-2 kg·m²; \
             expected none above the sum of the others",
        ),
        (
            "ixx=\"0.0190\" ixy=\"0\"",
            "ixx=\"0.0190\" ixy=\"0.03\"",
            "elbow/elbow.urdf:25: link forearm: inertia = [ixx 0.019, ixy 0.03, ixz 0, iyy 0.019, iyz 0, izz 0.0015]: expected \
             a tensor that a rigid body can have: principal moments -1.1000e-2, 1.5000e-3, 4.9000e-2 kg·m²; expected all ≥ 0",
        ),
        (
            "<origin xyz=\"0 0 -0.40\"/>",
            "<origin xyz=\"0 0 x -0.40\"/>",
            "elbow/elbow.urdf:53: joint elbow: origin xyz = \"0 0 x -0.40\": expected 3 numbers",
        ),
        (
            "<axis xyz=\"0 -1 0\"/>",
            "<axis xyz=\"0 0 0\"/>",
            "elbow/elbow.urdf:47: joint shoulder: axis = 0 0 0: expected an axis that is not zero",
        ),
        (
            "lower=\"-2.4\" upper=\"2.4\"",
            "lower=\"2.4\" upper=\"-2.4\"",
            "elbow/elbow.urdf:55: joint elbow: limit = lower 2.4, upper -2.4: expected lower ≤ upper",
        ),
        (
            "name=\"elbow\" type=\"revolute\"",
            "name=\"elbow\" type=\"floating\"",
            "elbow/elbow.urdf:50: joint elbow: type = floating: expected revolute or continuous or prismatic or fixed",
        ),
        (
            "<child link=\"tool\"/>",
            "<child link=\"tol\"/>",
            "elbow/elbow.urdf:59: joint tool_mount: child = tol: expected a link of this file, such as tool",
        ),
        (
            "<child link=\"tool\"/>",
            "<child link=\"forearm\"/>",
            "elbow/elbow.urdf:59: joint tool_mount: child = forearm: expected a link that no other joint moves",
        ),
        (
            "<child link=\"tool\"/>",
            "<child link=\"bracket\"/>",
            "elbow/elbow.urdf:4: link bracket: expected a link that hangs from the base, not from itself",
        ),
        (
            "<link name=\"tool\">",
            "<link name=\"forearm\">",
            "elbow/elbow.urdf:21: link forearm: expected a name that no other link has",
        ),
        ("<link name=\"tool\">", "<link>", "elbow/elbow.urdf:32: link ?: name: expected a name (missing)"),
        (
            "<sphere radius=\"0.035\"/>",
            "<sphere radius=\"-1\"/>",
            "elbow/elbow.urdf:38: link tool: collision = [-1.0]: expected sizes > 0 [m]",
        ),
        ("</robot>", "", "elbow/elbow.urdf:3: URDF: expected a closing </robot>"),
        (
            "<robot name=\"elbow\">",
            "<model name=\"elbow\">",
            "elbow/elbow.urdf:62: URDF: expected </model> for the tag of line 3, not </robot>",
        ),
        ("</joint>", "</joints>", "elbow/elbow.urdf:49: URDF: expected </joint> for the tag of line 43, not </joints>"),
        (
            "<axis xyz=\"0 -1 0\"/>",
            "<axis xyz=\"0 -1 0\"/><mimic joint=\"elbow\"/>",
            "elbow/elbow.urdf:47: joint shoulder: mimic: expected a joint of its own; one that mimics another cannot be listed in the model file",
        ),
        (
            "\"revolute\"",
            "\"hinge\"",
            "elbow/elbow.urdf:43: joint shoulder: type = hinge: expected revolute or continuous or prismatic or fixed",
        ),
        (" velocity=\"3.0\"", "", "elbow/elbow.urdf:48: joint shoulder: limit velocity: expected a number (missing)"),
        ("<limit lower", "<limits lower", "elbow/elbow.urdf:48: URDF: expected the element <limit>, not <limits>"),
        ("<parent link=\"bracket\"/>", "", "elbow/elbow.urdf:43: URDF: expected an element <parent> in joint shoulder"),
        ("<mass value=\"1.8\"/>", "", "elbow/elbow.urdf:22: URDF: expected an element <mass> in link forearm"),
        (
            "<mass value=\"1.8\"/>",
            "<mass value=\"1.8\"/>\n<mass value=\"1.8\"/>",
            "elbow/elbow.urdf:25: URDF: expected one element <mass> in link forearm",
        ),
        (
            "<sphere radius=\"0.035\"/>",
            "<cone radius=\"0.035\"/><sphere radius=\"0.035\"/>",
            "elbow/elbow.urdf:40: URDF: expected one box, cylinder, capsule, sphere or mesh in link tool",
        ),
        (
            "<link name=\"tool\">",
            "<xacro:include filename=\"x\"/><link name=\"tool\">",
            "elbow/elbow.urdf: expected plain URDF; run xacro on this file first",
        ),
    ];

    #[test]
    fn property_broken_urdfs_are_refused_with_place_and_expectation() {
        all_refused(URDF, BROKEN_URDFS, |text| texts(MODEL, text));
        for text in ["", "no tag", "<sdf version='1.9'/>"] {
            let error = texts(MODEL, text).unwrap_err().to_string();
            assert_eq!(error, "elbow/elbow.urdf:1: URDF: expected one <robot> around everything");
        }
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
    fn property_a_joint_that_mimics_is_held_only_where_what_it_follows_is_held() {
        let urdf = TWISTED.replacen("<axis xyz=\"0 1 1\"/>", "<axis xyz=\"0 1 1\"/><mimic joint=\"jd\"/>", 1);
        assert_eq!(texts(&listing(&["ja", "jb"]), &urdf).unwrap().held, ["jc", "jd"]);
        let error = texts(&listing(&["ja", "jd"]), &urdf).unwrap_err().to_string();
        let expected = "a joint of its own; one that mimics a moving joint is not supported";
        assert!(error.ends_with(expected) && error.contains("joint jc: mimic = jd"), "{error}");
    }

    #[test]
    fn property_meshes_become_hulls_and_unreadable_ones_are_kept_for_the_motion_check() {
        let folder = tempfile::tempdir().unwrap();
        let urdf = folder.path().join("twisted/urdf/m.urdf");
        std::fs::create_dir_all(folder.path().join("twisted/urdf")).unwrap();
        std::fs::write(folder.path().join("m.toml"), listing(&["ja"]).replace("m.urdf", "twisted/urdf/m.urdf"))
            .unwrap();
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
            ("../../m.toml", "an STL or OBJ mesh"),
            ("cut.stl", "a whole mesh"),
            ("flat.obj", "at least 4 points, not 3"),
            ("package://elsewhere/a.stl", "a package whose folder is above the URDF"),
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
            "elbow/elbow.urdf:21: link forearm: mass = 0: expected a mass > 0 [kg] of the link that moves and all that is fixed to it"
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

    #[test]
    fn property_missing_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("model.toml");
        let error = Model::load(&file).unwrap_err().to_string();
        assert_eq!(error, format!("{}: cannot read", file.display()));
        std::fs::write(&file, MODEL).unwrap();
        let error = Model::load(&file).unwrap_err().to_string();
        assert_eq!(error, format!("{}:4: urdf = \"elbow.urdf\": expected a file that exists", file.display()));
    }

    #[test]
    fn equivalent_saved_models_load_as_they_were() {
        let mut rng = random(11);
        let mut number = |size: f64| 10_f64.powf(rng.random_range(-4.0..4.0)) * size;
        for case in 0..20 {
            let mut model = texts(MODEL, URDF).unwrap();
            for joint in &mut model.joints {
                joint.gear_ratio = number(1.0);
                joint.rotor_inertia = number(1e-5);
                joint.backlash = (case % 3 != 0).then(|| number(1e-3));
                joint.motor.resistance = (case % 2 == 0).then(|| number(1.0));
                joint.motor.inductance = (case % 4 == 0).then(|| number(1e-3));
                joint.amplifier.voltage_limit = if case % 5 == 0 { f64::INFINITY } else { number(10.0) };
                joint.velocity_sensor =
                    [None, Some(VelocitySensor::PulsePeriod), Some(VelocitySensor::LowPass(0.02))][case % 3];
                let sensing = if case % 2 == 0 { Sensing::Absolute } else { Sensing::Signed };
                joint.current_sensor = Some(CurrentSensor { noise: number(0.01), resolution: 0.0, sensing });
                if let (1, Some(friction)) = (case % 2, &mut joint.friction) {
                    let lines = [0, 1].map(|_| {
                        let (a2, b2) = (number(1.0), number(1.0));
                        Lines { a1: a2 + number(1.0), b1: b2 - number(1.0), a2, b2 }
                    });
                    friction.law = FrictionLaw::TwoLines(lines);
                }
            }
            model.robot.gravity =
                nalgebra::Vector3::new(number(1.0), -number(1.0), if case % 2 == 0 { 0.0 } else { -9.81 });
            model.effects = vec![
                EffectEntry {
                    effect: "payload".into(),
                    joint: None,
                    parameters: [("mass".into(), number(1.0))].into(),
                },
                EffectEntry { effect: "cogging".into(), joint: Some("elbow".into()), parameters: [].into() },
            ];
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("model.toml");
            model.save(&file).unwrap();
            let again = Model::load(&file).unwrap();
            // The URDF was embedded, so it was written beside the model.
            assert_eq!(again.urdf, folder.path().join("elbow.urdf"));
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing half-written is left");
            assert_eq!(again, Model { source: file.clone(), urdf: again.urdf.clone(), ..model });
        }
    }

    #[test]
    fn property_saved_models_find_their_urdf_again() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let model = Model::load(&root.join("robots/emps/model.toml")).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("out/model.toml");
        assert!(model.save(&file).is_err(), "the folder is not there");
        std::fs::create_dir(folder.path().join("out")).unwrap();
        model.save(&file).unwrap();
        let again = Model::load(&file).unwrap();
        assert_eq!(again.urdf, root.join("robots/emps/emps.urdf").canonicalize().unwrap());
        assert_eq!(again.robot, model.robot);
        // Beside its URDF the path is relative, so that the folder can move.
        let urdf = folder.path().join("out/emps.urdf");
        std::fs::write(&urdf, &model.urdf_text).unwrap();
        Model { urdf, ..model }.save(&file).unwrap();
        assert_eq!(Model::load(&file).unwrap().urdf, folder.path().join("out/emps.urdf"));
        assert!(std::fs::read_to_string(&file).unwrap().contains("urdf = \"emps.urdf\""));
    }

    #[test]
    fn property_a_first_model_of_a_urdf_is_complete() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for urdf in ["robots/elbow/elbow.urdf", "robots/emps/emps.urdf"] {
            let model = Model::from_urdf(&root.join(urdf)).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("model.toml");
            model.save(&file).unwrap();
            let again = Model::load(&file).unwrap();
            assert_eq!(again.joints, model.joints);
            assert!(again.joints.iter().all(|joint| joint.friction.is_none() && joint.backlash.is_none()));
        }
    }

    /// Cuts, bytes replaced, lines doubled and dropped: an answer or an error, never a panic.
    fn damaged(text: &str, seed: u64) -> String {
        let mut rng = random(seed);
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..rng.random_range(1..4) {
            let (at, to) = (rng.random_range(0..bytes.len()), rng.random_range(0..bytes.len()));
            match rng.random_range(0..5) {
                0 => bytes.truncate(at.max(1)),
                1 => bytes[at] = b"<>/\"'=[]{}.,-+e0 9\n&#\\:"[rng.random_range(0..23)],
                2 => drop(bytes.drain(at.min(to)..at.max(to).min(at.min(to) + 40))),
                3 => {
                    let piece = bytes[at.min(to)..at.max(to).min(at.min(to) + 60)].to_vec();
                    bytes.splice(at..at, piece);
                }
                _ => bytes[at] = rng.random(),
            }
            if bytes.is_empty() {
                break;
            }
        }
        String::from_utf8_lossy(&bytes).into_owned()
    }

    #[test]
    fn property_deep_nesting_is_refused_before_the_stack_ends() {
        let deep = format!("<robot>{}{}</robot>", "<a>".repeat(200_000), "</a>".repeat(200_000));
        let error = texts(MODEL, &deep).unwrap_err().to_string();
        assert_eq!(error, "elbow/elbow.urdf:1: URDF: expected at most 64 elements within each other");
        assert!(texts(&"[".repeat(200_000), URDF).is_err());
        assert!(texts(&format!("a = {}", "[".repeat(200_000)), URDF).is_err());
    }

    #[test]
    fn property_damaged_files_never_panic() {
        let runs = std::env::var("LOSTMOTION_FUZZ").ok().and_then(|runs| runs.parse().ok()).unwrap_or(3000);
        for seed in 0..runs {
            let _ = texts(&damaged(MODEL, seed), URDF);
            if let Ok(model) = texts(MODEL, &damaged(URDF, seed)) {
                // Whatever is accepted has dynamics.
                let n = model.robot.dof();
                let mut h = nalgebra::DMatrix::zeros(n, n);
                lostmotion::dynamics::Dynamics::new(&model.robot).mass_matrix(&vec![0.3; n], &mut h);
                assert!(h.iter().all(|x| x.is_finite()) && (0..n).all(|i| h[(i, i)] > 0.0), "seed {seed}: {h}");
            }
        }
    }
}
