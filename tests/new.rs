//! `lostmotion new`: first models that simulate, what a URDF says of its drives, and first experiments that run as they are written.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use lostmotion::dynamics::Dynamics;
use lostmotion::plant::{Options, Plant, first_model};
use lostmotion::robot::{First, Model, marked_lines};
use nalgebra::DMatrix;
use serde_json::Value;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn lostmotion(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lostmotion")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// A robot of the catalogue alone in a folder, without its model.
fn alone(robot: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("{robot}.urdf"));
    fs::copy(Path::new(ROOT).join(format!("robots/{robot}/{robot}.urdf")), &file).unwrap();
    (folder, file)
}

/// The first model of the elbow with something more in its URDF.
fn with(more: &str) -> First {
    let (_folder, file) = alone("elbow");
    let urdf = fs::read_to_string(&file).unwrap();
    fs::write(&file, urdf.replace("</robot>", &format!("{more}</robot>"))).unwrap();
    first_model(&file).unwrap()
}

#[test]
fn property_every_value_that_the_urdf_does_not_have_is_marked() {
    let (folder, file) = alone("elbow");
    let made = lostmotion(&["new", file.to_str().unwrap()]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let model = fs::read_to_string(folder.path().join("model.toml")).unwrap();
    let of_joints = model.lines().take_while(|line| *line != "[accuracy]");
    let (guesses, values): (Vec<&str>, Vec<&str>) =
        of_joints.skip(3).filter(|line| line.contains(" = ")).partition(|line| line.starts_with('#'));
    assert_eq!(values.len(), 8, "{model}");
    for value in &values {
        assert!(value.contains("# placeholder"), "{value}");
    }
    // Rotor, stiffness, damping and encoder of each joint: a diagnosis estimates what the file does not state.
    assert_eq!(guesses.len(), 8, "{model}");
    assert!(guesses.iter().all(|guess| guess.contains("# guess; state it where it is known")), "{guesses:?}");
    let read = Model::load(&folder.path().join("model.toml")).unwrap();
    assert!(
        read.joints
            .iter()
            .all(|joint| joint.rotor_inertia.or(joint.gear_stiffness).is_none() && joint.encoder.is_none())
    );
    // And how well torque constants are known.
    assert_eq!(marked_lines(&model).len(), values.len() + 1);
    assert!(model.contains("\ntorque_constants = 1.0  # placeholder"), "{model}");
    let checked = lostmotion(&["check", folder.path().join("model.toml").to_str().unwrap()]);
    assert_eq!(checked.status.code(), Some(0), "{}", text(&checked.stderr));
    for part in
        ["simulated: all 2 joints to and fro within 1 s, each follows its reference", "9 values are placeholders"]
    {
        assert!(text(&checked.stdout).contains(part), "{part} is missing in {}", text(&checked.stdout));
    }
}

#[test]
fn property_gears_have_the_resonance_of_real_ones() {
    for robot in ["elbow", "sixaxis", "scara", "chain12"] {
        let (_folder, file) = alone(robot);
        let model = first_model(&file).unwrap().model;
        let n = model.joints.len();
        let mut mass = DMatrix::zeros(n, n);
        Dynamics::new(&model.robot).mass_matrix(&vec![0.0; n], &mut mass);
        for (i, joint) in model.joints.iter().enumerate() {
            let hertz = (joint.gear_stiffness.unwrap() / mass[(i, i)]).sqrt() / std::f64::consts::TAU;
            // 15 Hz at the largest inertia, written with two digits; a folded arm has a tenth of the inertia and thrice the frequency, and a gear
            // chosen by weight more: a link whose centre is at l from the axis has √(g/(l θ)) = 16 Hz for l = 0.1 m, 50 Hz for a hundredth.
            assert!((14.5..60.0).contains(&hertz), "{robot}, {}: {hertz} Hz", joint.name);
        }
        Plant::new(&model, &Options::default()).unwrap();
    }
}

#[test]
fn property_the_effort_limit_of_the_urdf_is_that_of_the_drive() {
    let (_folder, file) = alone("elbow");
    let model = first_model(&file).unwrap().model;
    for (joint, body) in model.joints.iter().zip(&model.robot.bodies) {
        let effort = joint.torque_per_ampere() * joint.amplifier.current_limit;
        // Three multiplications and divisions round by 1e-16 each.
        assert!((effort / body.joint.limits.effort - 1.0).abs() < 1e-14, "{}: {effort}", joint.name);
    }
}

#[test]
fn property_transmissions_are_read() {
    let ros = "<transmission name=\"t\"><joint name=\"elbow\"/><actuator name=\"m\"><mechanicalReduction>-160</mechanicalReduction>\
               <motorTorqueConstant>0.07</motorTorqueConstant></actuator></transmission>";
    let ros_2 = "<ros2_control name=\"c\" type=\"system\"><transmission name=\"t\"><actuator name=\"m\"/><joint name=\"elbow\">\
                 <mechanical_reduction>160.0</mechanical_reduction></joint></transmission></ros2_control>";
    let drake = "<transmission><joint name=\"elbow\"/><actuator name=\"m\"><drake:gear_ratio value=\"160\"/>\
                 <drake:rotor_inertia value=\"2e-5\"/></actuator></transmission>";
    for (more, known) in [
        (ros, &["gear_ratio", "motor.torque_constant"][..]),
        (ros_2, &["gear_ratio"]),
        (drake, &["gear_ratio", "rotor_inertia"]),
    ] {
        let First { model, placeholders } = with(more);
        let elbow = &model.joints[1];
        assert_eq!(elbow.gear_ratio, 160.0);
        for key in ["gear_ratio", "motor.torque_constant", "rotor_inertia"] {
            let open = |joint: &str| placeholders.marks(joint, key) || placeholders.is_guess(joint, key);
            assert_eq!(open("elbow"), !known.contains(&key), "{key} of {more}");
            assert!(open("shoulder"), "{key}");
        }
        assert!(model.remarks.is_empty(), "{:?}", model.remarks);
    }
    assert_eq!(with(ros).model.joints[1].motor.unwrap().torque_constant, 0.07);
    assert_eq!(with(drake).model.joints[1].rotor_inertia, Some(2e-5));
}

#[test]
fn property_a_reduction_without_a_meaning_is_remarked_and_that_of_a_template_is_none() {
    let of = |reduction: &str| {
        with(&format!(
            "\n<transmission name=\"t\"><joint name=\"elbow\"/><actuator name=\"m\"><mechanicalReduction>{reduction}</mechanicalReduction>\
             </actuator></transmission>"
        ))
    };
    for reduction in ["1", "1.0", "-1"] {
        let First { model, placeholders } = of(reduction);
        assert!(model.remarks.is_empty() && placeholders.marks("elbow", "gear_ratio"), "{reduction}");
    }
    for reduction in ["reduction", "0.07", "nan", "inf", "", "1e300"] {
        let First { model, placeholders } = of(reduction);
        assert!(placeholders.marks("elbow", "gear_ratio"), "{reduction}");
        let [remark] = &model.remarks[..] else { panic!("{reduction}: {:?}", model.remarks) };
        assert!(remark.text.contains("is not taken, expected a number from 1.01 to 1e6"), "{remark}");
    }
    let several = "<transmission><joint name=\"shoulder\"/><joint name=\"elbow\"/></transmission>";
    assert!(with(several).model.remarks[0].text.contains("[coupling]"));
}

#[test]
fn recover_the_friction_of_a_rehearsal_on_robots_with_and_without_gravity() {
    for (robot, joints) in [("elbow", 2), ("scara", 4), ("emps", 1)] {
        let (folder, file) = alone(robot);
        let made = lostmotion(&["new", file.to_str().unwrap(), "--staircase"]);
        assert_eq!(made.status.code(), Some(0), "{robot}: {}", text(&made.stderr));
        let out = folder.path().join("out");
        let scenario = folder.path().join("first_experiment.toml");
        let run = lostmotion(&["run", scenario.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap()]);
        // 3: a first model has no gap, and the report says that none could be measured.
        assert!(matches!(run.status.code(), Some(0 | 3)), "{robot}: {}", text(&run.stderr));
        let report: Value = serde_json::from_str(&fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
        let found = report["joints"].as_array().unwrap();
        assert_eq!(found.len(), joints, "{robot}");
        for joint in found {
            let name = &joint["joint"];
            for direction in ["positive", "negative"] {
                let coulomb = &joint["friction"]["exponential"][direction]["coulomb"];
                let [value, injected] = ["value", "true"].map(|key| coulomb[key].as_f64().unwrap());
                // A gear that yields by 10 mrad under the arm's weight lets links hang lower than the motor says, and the weight changes by
                // some per cent of itself; it is several times the friction at most.
                assert!((value / injected - 1.0).abs() < 0.15, "{robot}, {name}, {direction}: {value} for {injected}");
            }
        }
    }
}

#[test]
fn property_references_begin_and_end_at_rest_within_the_limits() {
    let (folder, file) = alone("sixaxis");
    assert_eq!(lostmotion(&["new", file.to_str().unwrap(), "--staircase"]).status.code(), Some(0));
    let model = first_model(&file).unwrap().model;
    let table = fs::read_to_string(folder.path().join("first_experiment.csv")).unwrap();
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(head[..3], ["time", "joint1.reference_position", "joint1.reference_velocity"]);
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|word| word.parse().unwrap()).collect()).collect();
    for (i, body) in model.robot.bodies.iter().enumerate() {
        let limits = body.joint.limits;
        let [q, v] = [1 + 2 * i, 2 + 2 * i].map(|column| rows.iter().map(|row| row[column]).collect::<Vec<f64>>());
        assert_eq!((v[0], v[v.len() - 1]), (0.0, 0.0));
        assert!(q.iter().all(|q| (limits.lower..=limits.upper).contains(q)), "{}", body.joint.name);
        let fastest = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        assert!(fastest > 0.1 && fastest <= limits.velocity, "{}: {fastest}", body.joint.name);
        // 0.51 rad/s² as planned, and nine digits of a velocity in hundredths of a second.
        let steepest = v.windows(2).fold(0.0_f64, |most, v| most.max((v[1] - v[0]).abs() / 0.01));
        assert!(steepest < 0.511, "{}: {steepest}", body.joint.name);
        let moved = |k: usize| q[k + 1] - q[k] - 0.005 * (v[k] + v[k + 1]);
        // A kink of the velocity within an interval: a quarter of the change of acceleration times its square.
        assert!((0..q.len() - 1).all(|k| moved(k).abs() < 0.25 * 1.1 * 1e-4), "{}", body.joint.name);
    }
}

#[test]
fn property_nothing_is_written_where_a_file_stands_in_the_way_or_no_plan_fits() {
    let (folder, file) = alone("elbow");
    fs::write(folder.path().join("first_experiment.csv"), "mine").unwrap();
    let refused = lostmotion(&["new", file.to_str().unwrap(), "--staircase"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("first_experiment.csv"), "{}", text(&refused.stderr));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);

    let (folder, file) = alone("elbow");
    let urdf = fs::read_to_string(&file).unwrap();
    let effort = urdf.split("effort=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
    fs::write(&file, urdf.replace(&format!("effort=\"{effort}\""), "effort=\"0.01\"")).unwrap();
    let refused = lostmotion(&["new", file.to_str().unwrap(), "--staircase"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("limit effort = 0.01"), "{}", text(&refused.stderr));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    // Without the experiment the model is written, and `check` says what fails.
    assert_eq!(lostmotion(&["new", file.to_str().unwrap()]).status.code(), Some(0));
    let checked = lostmotion(&["check", folder.path().join("model.toml").to_str().unwrap()]);
    assert_eq!(checked.status.code(), Some(3), "{}", text(&checked.stdout));
    // An arm that hangs needs no effort to rest, and too much of it to move.
    let said = text(&checked.stdout);
    assert!(said.contains("this fails:") && said.contains("joint shoulder: "), "{said}");
}
