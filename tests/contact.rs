//! Links that meet obstacles and end stops, against closed forms and the machine's own books.

#[path = "support/machines.rs"]
mod machines;

use std::path::PathBuf;

use lostmotion::drive::Noise;
use lostmotion::dynamics::Dynamics;
use lostmotion::effects::JointState;
use lostmotion::error::Error;
use lostmotion::plant::Evaluations::{AsNeeded, EveryStage};
use lostmotion::plant::{Energy, Engine, Obstacle, Options, Plant, RigidBody, World};
use lostmotion::robot::{Geometry, JointModel, Limits, Model, Robot, Shape};
use lostmotion::scenario::{Scenario, simulate};
use lostmotion::timeseries::Channel;
use lostmotion::units::JointKind;
use machines::*;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// [m] Distance of the finger's centre from the axis, and its radius.
const ARM: f64 = 0.3;
const FINGER: f64 = 0.02;
/// [m] Where the wall's face stands: `d = WALL − ARM sin q − FINGER`.
const WALL: f64 = 0.12;
/// [kg·m²]
const LINK: f64 = 0.05;

fn shape(link: &str, x: f64, y: f64, geometry: Geometry) -> Shape {
    Shape { link: link.to_owned(), pose: Isometry3::translation(x, y, 0.0), geometry }
}

/// A table that turns about a vertical axis, with a round finger at its rim.
fn table() -> Robot {
    let mut robot = turntable(LINK);
    robot.bodies[0].shapes.push(shape("table", ARM, 0.0, Geometry::Sphere(FINGER)));
    robot
}

/// A wall in the finger's way, its face across y.
fn wall(stiffness: f64, damping: f64) -> Obstacle {
    let geometry = Geometry::Box(Vector3::new(1.0, 0.2, 0.4));
    Obstacle { shape: shape("wall", 0.3, WALL + 0.1, geometry), edge_radius: 0.01, stiffness, damping }
}

fn ideal(obstacles: Vec<Obstacle>) -> Options {
    Options { ideal_sensors: true, obstacles, ..Options::default() }
}

/// A drive that can hardly be felt: what the link does is its own.
fn loose() -> JointModel {
    JointModel { gear_stiffness: Some(1e-9), gear_damping: Some(0.0), ..plain_joint("joint1") }
}

/// A slide of 1 kg along y with the finger on it: `d = WALL − FINGER − q`, and nothing but the wall acts on it.
fn slider(obstacle: Obstacle, options: &Options) -> Plant {
    let mut robot = slide(1.0, Vector3::y());
    robot.bodies[0].shapes.push(shape("slider", ARM, 0.0, Geometry::Sphere(FINGER)));
    let joint = JointModel { kind: JointKind::Prismatic, ..loose() };
    let options = Options { obstacles: vec![obstacle], ..options.clone() };
    Plant::new(&model(robot, vec![joint]), &options).unwrap()
}

fn launched(mut plant: Plant, v: f64) -> Plant {
    plant.launch(&[JointState { link_velocity: v, motor_velocity: v, ..JointState::default() }]);
    plant
}

/// Restitution and duration [s] of an impact on a spring and a damper that do not pull.
/// T. Schwager, T. Pöschel, Coefficient of restitution and linear-dashpot model revisited, Granular Matter 9 (2007), eq. 21.
fn rebound(k: f64, c: f64, m: f64) -> (f64, f64) {
    let (square, delta) = (k / m, 0.5 * c / m);
    let omega = (square - delta * delta).sqrt();
    let duration = (std::f64::consts::PI - (2.0 * delta * omega).atan2(square - 2.0 * delta * delta)) / omega;
    ((-delta * duration).exp(), duration)
}

#[test]
fn analytic_an_impact_rebounds_as_a_damped_oscillator() {
    let v0 = 0.8;
    for (k, c) in [(1e5, 0.0), (1e5, 100.0), (1e5, 400.0), (1e7, 1000.0), (1e9, 1e4)] {
        let mut plant = launched(slider(wall(k, c), &ideal(Vec::new())), v0);
        let start = plant.energy();
        let end = 0.25;
        for _ in 0..250 {
            plant.advance(&[0.0], 1e-3).unwrap();
        }
        let state = plant.states()[0];
        let (restitution, duration) = rebound(k, c, 1.0);
        let found = -state.link_velocity / v0;
        // p where the wall is left, k p = −c ṗ, and the times before and after.
        let left = WALL - FINGER + c * found * v0 / k;
        let found_duration = end - (WALL - FINGER) / v0 - (left - state.link_position) / (found * v0);
        let energy = plant.energy();
        let gap = energy.work - energy.dissipated - (energy.stored - start.stored);
        println!("{k:e} {c}: {:e} {:e} {gap:e}", found - restitution, found_duration / duration - 1.0);
        // 1e-5: Runge-Kutta 4 in 16 steps an impact, see LONGEST_STEP_TOUCHING.
        assert!((found - restitution).abs() < 1e-5, "{k} N/m: {found}, {restitution}");
        assert!((found_duration / duration - 1.0).abs() < 1e-5, "{k} N/m: {found_duration}, {duration} s");
        assert!(gap.abs() < 1e-5 * start.stored, "{k} N/m: {gap:e} J");
    }
}

#[test]
fn analytic_a_motor_presses_with_its_torque_over_the_lever_arm() {
    let (k, torque) = (1e5, 6.0);
    let mut plant = Plant::new(&model(table(), vec![plain_joint("joint1")]), &ideal(vec![wall(k, 200.0)])).unwrap();
    for _ in 0..3000 {
        plant.advance(&[torque], 1e-3).unwrap();
    }
    let state = plant.states()[0];
    let (sin, cos) = state.link_position.sin_cos();
    let [touch] = plant.touches().collect::<Vec<_>>()[..] else { panic!("no contact") };
    println!("{touch:?} {state:?}");
    // 1e-9: what is left of the motion after three seconds of its damping, and rounding.
    assert!((touch.force - torque / (ARM * cos)).abs() < 1e-9 * touch.force, "{touch:?}");
    let depth = ARM * sin + FINGER - WALL;
    assert!((depth - torque / (ARM * cos * k)).abs() < 1e-12, "{depth:e}");
}

#[test]
fn analytic_distance_and_gradient_of_balls_on_random_trees() {
    let mut noise = Noise::new(3, 0);
    for round in 0..60 {
        let joints = 1 + round % 7;
        let mut robot = random_tree(|| noise.uniform(), joints);
        let finger = shape("finger", 0.2 * noise.uniform(), 0.1, Geometry::Sphere(0.03));
        let ball = shape("ball", noise.uniform() - 0.5, noise.uniform() - 0.5, Geometry::Sphere(0.2));
        let [place, target] = [&finger, &ball].map(|shape| Point3::from(shape.pose.translation.vector));
        robot.bodies[joints - 1].shapes.push(finger);
        let mut world = World::new(&robot);
        let obstacle = Obstacle { shape: ball, edge_radius: 0.1, stiffness: 1e5, damping: 0.0 };
        world.put_obstacles(&robot, &[obstacle]).unwrap();
        let mut own = Dynamics::new(&robot);
        let mut expected = |q: &[f64]| (own.poses(q)[joints - 1] * place - target).norm() - 0.23;
        let mut q: Vec<f64> = (0..joints).map(|_| 2.0 * noise.uniform() - 1.0).collect();
        let mut gradient = vec![0.0; joints];
        let distance = world.distance(0, &q, 10.0, &mut gradient).unwrap();
        // 1e-12: rounding of a chain of seven poses.
        assert!((distance - expected(&q)).abs() < 1e-12, "{distance}, {}", expected(&q));
        for (j, slope) in gradient.iter().enumerate() {
            let at = q[j];
            let [before, after] = [-1e-5, 1e-5].map(|step| {
                q[j] = at + step;
                expected(&q)
            });
            q[j] = at;
            // 1e-8: a central difference over 2e-5, of a distance with third derivatives of order ten.
            assert!((slope - (after - before) / 2e-5).abs() < 1e-8, "joint {j} of {joints}: {slope}");
        }
    }
}

#[test]
fn property_the_gradient_is_that_of_the_distance_for_every_shape() {
    let shapes = [
        Geometry::Box(Vector3::new(0.3, 0.2, 0.4)),
        Geometry::Cylinder(0.15, 0.3),
        Geometry::Capsule(0.1, 0.3),
        Geometry::Sphere(0.2),
        Geometry::ConvexHull(
            (0..8).map(|k| 0.1 * Vector3::from([1, 2, 4].map(|bit| f64::from(k & bit > 0)))).collect(),
        ),
    ];
    let mut noise = Noise::new(4, 0);
    let (mut asked, mut kinks) = (0, 0);
    for obstacle in &shapes[..4] {
        for geometry in &shapes {
            for _ in 0..20 {
                let mut robot = random_tree(|| noise.uniform(), 3);
                robot.bodies[2].shapes.push(shape("finger", 0.1, 0.0, geometry.clone()));
                let mut world = World::new(&robot);
                let turn = UnitQuaternion::from_euler_angles(noise.uniform(), noise.uniform(), noise.uniform());
                let pose = Isometry3::from_parts(Translation3::new(0.8 * noise.uniform(), 0.6, 0.3), turn);
                let shape = Shape { link: "thing".to_owned(), pose, geometry: obstacle.clone() };
                world
                    .put_obstacles(&robot, &[Obstacle { shape, edge_radius: 0.02, stiffness: 1e5, damping: 0.0 }])
                    .unwrap();
                let mut q: Vec<f64> = (0..3).map(|_| 2.0 * noise.uniform() - 1.0).collect();
                let mut scratch = vec![0.0; 3];
                let mut gradient = vec![0.0; 3];
                let distance = world.distance(0, &q, 10.0, &mut gradient).unwrap();
                // Deeper than its skin nothing is promised.
                if distance < -0.015 {
                    continue;
                }
                for j in 0..3 {
                    let at = q[j];
                    let [before, after] = [-1e-4, 1e-4].map(|step| {
                        q[j] = at + step;
                        world.distance(0, &q, 10.0, &mut scratch).unwrap()
                    });
                    q[j] = at;
                    asked += 1;
                    let apart = (gradient[j] - (after - before) / 2e-4).abs();
                    // 2e-4: the distance is right within 5e-8 of itself; where the nearest points jump to another edge, more.
                    kinks += i32::from(apart > 2e-4);
                    assert!(apart < 0.1, "{obstacle:?} and {geometry:?}: {} off by {apart:e}", gradient[j]);
                }
            }
        }
    }
    println!("{kinks} kinks among {asked}");
    assert!(asked > 600 && kinks * 50 < asked, "{kinks} of {asked} gradients are off");
}

/// The arm with gears, friction and drives, its forearm a capsule, and a post in its way.
fn arm_and_post(at: [f64; 2]) -> (Model, Obstacle) {
    let mut model = scara();
    let along = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let pose = Isometry3::from_parts(Translation3::new(0.15, 0.0, 0.0), along);
    let geometry = Geometry::Capsule(0.03, 0.3);
    model.robot.bodies[1].shapes.push(Shape { link: "forearm".to_owned(), pose, geometry });
    let post = shape("post", at[0], at[1], Geometry::Cylinder(0.02, 0.3));
    (model, Obstacle { shape: post, edge_radius: 0.005, stiffness: 1e5, damping: 100.0 })
}

/// Commands [A] that press the arm against the post, and hammer it there.
fn push(t: f64) -> [f64; 2] {
    [6.0 + 12.0 * (12.0 * t).cos(), 3.0 + 6.0 * (12.0 * t + 0.5).cos()]
}

/// Presses the arm against the post for so many milliseconds; what every joint did, a row each.
fn press(plant: &mut Plant, milliseconds: u32) -> Vec<f64> {
    plant.place(&[0.0, 0.3]);
    let mut trace = Vec::new();
    for k in 0..milliseconds {
        let t = f64::from(k) * 1e-3;
        plant.advance(&push(t), 1e-3).unwrap();
        trace.extend(plant.states().iter().flat_map(|state| [state.link_position, state.motor_position]));
    }
    trace
}

#[test]
fn property_energy_closes_through_impacts_of_a_geared_arm() {
    let (model, post) = arm_and_post([0.47, 0.14]);
    let mut plant = Plant::new(&model, &ideal(vec![post])).unwrap();
    plant.place(&[0.0, 0.3]);
    let start = plant.energy();
    let (mut met, mut touching, mut peak) = (0, false, 0.0_f64);
    for k in 0..4000 {
        let t = f64::from(k) * 1e-3;
        plant.advance(&push(t), 1e-3).unwrap();
        let force = plant.touches().map(|touch| touch.force).sum::<f64>();
        met += i32::from(force > 0.0 && !touching);
        (touching, peak) = (force > 0.0, peak.max(force));
        let Energy { work, dissipated, stored } = plant.energy();
        let gap = work - dissipated - (stored - start.stored);
        // 1e-4 of the work done is what the plant promises.
        assert!(gap.abs() < 1e-4 * work.abs().max(0.01), "at {t} s: {gap:e} J of {work} J");
    }
    println!("met {met} times, peak {peak} N; {:?}", plant.energy());
    assert!(met >= 5 && peak > 50.0, "met {met} times, {peak} N");
}

#[test]
fn property_energy_closes_where_a_six_joint_arm_drops_on_a_table() {
    let model = Model::load(&root().join("robots/sixaxis/model.toml")).unwrap();
    let pose = Isometry3::translation(0.6, 0.0, 0.0);
    let shape = Shape { link: "table".to_owned(), pose, geometry: Geometry::Box(Vector3::new(0.6, 1.0, 0.3)) };
    let table = Obstacle { shape, edge_radius: 0.01, stiffness: 1e6, damping: 1000.0 };
    let mut plant = Plant::new(&model, &ideal(vec![table])).unwrap();
    plant.place(&[0.2, 0.5, 0.3, 0.4, 0.5, 0.0]);
    let start = plant.energy();
    let mut touched = std::collections::BTreeSet::new();
    for _ in 0..2000 {
        plant.advance(&[0.0; 6], 1e-3).unwrap();
        touched.extend(plant.touches().map(|touch| touch.body));
    }
    let end = plant.energy();
    let gap = end.dissipated + end.stored - start.stored;
    println!("links {touched:?}: {end:?}, gap {gap:e} J");
    // 1e-4 of what the fall has turned over is what the plant promises.
    assert!(touched.len() >= 2 && end.dissipated > 10.0, "{touched:?}, {end:?}");
    assert!(gap.abs() < 1e-4 * end.dissipated, "{gap:e} J of {} J", end.dissipated);
}

#[test]
fn equivalent_an_arm_against_a_post_converges() {
    let (model, post) = arm_and_post([0.47, 0.14]);
    let trace = |substeps, evaluations| {
        let options = Options { substeps, evaluations, ..ideal(vec![post.clone()]) };
        press(&mut Plant::new(&model, &options).unwrap(), 500)
    };
    let reference = trace(40, EveryStage);
    // 1e-4 deg is what the default settings promise of geared arms, impacts included; a quarter of the step leaves
    // what the response, held by a cubic through an impact, is wrong by. Asked at every stage, it goes with the fourth power.
    for (substeps, evaluations, limit) in [(3, AsNeeded, 1e-4), (12, AsNeeded, 3e-5), (12, EveryStage, 1e-6)] {
        let found = trace(substeps, evaluations);
        let apart = found.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max).to_degrees();
        println!("{substeps} steps a ms, evaluations {evaluations:?}: {apart:e} deg");
        assert!(apart < limit, "{substeps} steps a ms: {apart:e} deg");
    }
}

#[test]
fn property_reruns_with_contacts_are_bit_identical() {
    let (model, post) = arm_and_post([0.47, 0.14]);
    let bits = || {
        let trace = press(&mut Plant::new(&model, &ideal(vec![post.clone()])).unwrap(), 1000);
        trace.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let here = bits();
    assert!(here == bits(), "the second run differs");
    assert!(here == std::thread::scope(|scope| scope.spawn(bits).join().unwrap()), "another thread's run differs");
}

#[test]
fn property_an_obstacle_out_of_reach_changes_nothing() {
    let (model, far) = arm_and_post([0.9, 0.9]);
    let bits = |obstacles| {
        let trace = press(&mut Plant::new(&model, &ideal(obstacles)).unwrap(), 1000);
        trace.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let free = bits(Vec::new());
    assert!(free == bits(vec![far]), "an obstacle out of reach was felt");
    assert!(free != bits(vec![arm_and_post([0.47, 0.14]).1]), "an obstacle in the way was not felt");
}

#[test]
fn property_a_fast_link_does_not_get_through_a_thin_wall() {
    // 5 mm thick, met at 8 m/s: 8 mm in a millisecond.
    let thin = Shape {
        pose: Isometry3::translation(0.3, WALL + 0.0025, 0.0),
        geometry: Geometry::Box(Vector3::new(1.0, 0.005, 0.4)),
        link: "sheet".to_owned(),
    };
    for (v, k) in [(8.0, 1e8), (2.0, 1e7), (0.05, 1e5)] {
        let obstacle = Obstacle { shape: thin.clone(), edge_radius: 0.002, stiffness: k, damping: 100.0 };
        let mut plant = launched(slider(obstacle, &ideal(Vec::new())), v);
        for _ in 0..(0.3 / v * 1e3) as usize {
            plant.advance(&[0.0], 1e-3).unwrap();
            assert!(plant.states()[0].link_position + FINGER < WALL + 0.0025, "{v} m/s: through");
        }
        assert!(plant.states()[0].link_velocity < -0.5 * v, "{v} m/s: {:?}", plant.states()[0]);
    }
}

/// A joint with stops at ±0.5 rad.
fn stopped(stiffness: Option<f64>) -> Model {
    let mut robot = turntable(LINK);
    robot.bodies[0].joint.limits = Limits { lower: -0.5, upper: 0.5, ..UNLIMITED };
    model(robot, vec![JointModel { end_stop_stiffness: stiffness, gear_damping: Some(20.0), ..plain_joint("joint1") }])
}

#[test]
fn analytic_an_end_stop_holds_a_joint_on_both_engines() {
    for engine in [Engine::Rapier, Engine::Reduced] {
        let (k, torque) = (2000.0, 5.0);
        let mut plant = Plant::new(&stopped(Some(k)), &Options { engine, ..ideal(Vec::new()) }).unwrap();
        for side in [1.0, -1.0] {
            for _ in 0..4000 {
                plant.advance(&[side * torque], 1e-3).unwrap();
            }
            let [touch] = plant.touches().collect::<Vec<_>>()[..] else { panic!("no contact") };
            assert_eq!((touch.body, touch.obstacle), (0, None));
            // 1e-9: what is left of the motion after four seconds of its damping.
            assert!((touch.force - torque).abs() < 1e-9 * torque, "{touch:?}");
            let depth = side * plant.states()[0].link_position - 0.5;
            assert!((depth - torque / k).abs() < 1e-11, "{depth:e}");
        }
    }
}

#[test]
fn equivalent_both_engines_hit_an_end_stop_alike() {
    let trace = |engine| {
        let mut model = scara();
        for (joint, body) in model.joints.iter_mut().zip(&mut model.robot.bodies) {
            joint.end_stop_stiffness = Some(1000.0);
            body.joint.limits = Limits { lower: -0.3, upper: 0.35, ..UNLIMITED };
        }
        let mut plant = Plant::new(&model, &Options { engine, ..ideal(Vec::new()) }).unwrap();
        let trace = press(&mut plant, 1000);
        assert!(trace.iter().copied().fold(0.0, f64::max) > 0.35, "no stop was met");
        trace
    };
    let [rapier, reduced] = [Engine::Rapier, Engine::Reduced].map(trace);
    let apart = rapier.iter().zip(&reduced).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{apart:e} rad");
    // 1e-8 rad as without stops: the engines' biases differ by 1e-11.
    assert!(apart < 1e-8, "{apart:e}");
}

#[test]
fn property_without_a_stop_a_joint_passes_its_limit() {
    let mut plant = Plant::new(&stopped(None), &ideal(Vec::new())).unwrap();
    for _ in 0..1000 {
        plant.advance(&[5.0], 1e-3).unwrap();
    }
    assert!(plant.states()[0].link_position > 1.0);
    assert_eq!(plant.touches().count(), 0);
}

#[test]
fn property_obstacles_need_rapier() {
    let options = Options { engine: Engine::Reduced, ..ideal(vec![wall(1e5, 0.0)]) };
    let error = Plant::new(&model(table(), vec![plain_joint("joint1")]), &options).err().expect("must be refused");
    assert!(error.to_string().contains("engine = reduced") && error.to_string().contains("rapier"), "{error}");
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The scenario of the catalogue with a post in the way, changed.
fn scenario(changes: &[(&str, &str)]) -> Result<Scenario, Error> {
    let file = root().join("scenarios/04_meet_an_obstacle/scenario.toml");
    let mut text = std::fs::read_to_string(&file).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "the scenario lacks {from}");
        text = text.replacen(from, to, 1);
    }
    Scenario::from_text(&text, &file, &[])
}

#[test]
fn scenario_an_arm_meets_a_post_and_is_held_there() {
    let scenario = scenario(&[]).unwrap();
    scenario.check_motion().unwrap();
    let run = simulate(&scenario, scenario.seed, &|_, _| {}).unwrap();
    assert_eq!(scenario.contact_expectations.len(), 3);
    let unmet: Vec<String> =
        scenario.contact_expectations.iter().filter_map(|e| Some(e.check(&run)?.to_string())).collect();
    assert!(unmet.is_empty(), "{unmet:?}");
    let [contact] = &run.contacts[0][..] else { panic!("{} contacts", run.contacts[0].len()) };
    assert_eq!((contact.link.as_str(), contact.obstacle.as_deref()), ("forearm", Some("post")));
    assert_eq!(contact.force.len(), run.sessions[0].len());
    // Held: the arm stands at its angle although the reference is 29 degrees further.
    let link = run.sessions[0].joint("joint1").and_then(|joint| joint.get(Channel::TrueLinkPosition)).unwrap();
    let still = (link[link.len() - 1] - link[link.len() - 1000]).abs();
    assert!(still < 1e-6 && link[link.len() - 1] < 0.42, "{still:e} rad in the last second");
}

#[test]
fn scenario_a_post_out_of_the_way_is_missed() {
    let scenario = scenario(&[("xyz = [0.52, 0.30, 0.40]", "xyz = [0.52, -0.30, 0.40]")]).unwrap();
    let run = simulate(&scenario, scenario.seed, &|_, _| {}).unwrap();
    assert!(run.contacts[0].is_empty());
    for expectation in &scenario.contact_expectations {
        let unmet = expectation.check(&run).expect("nothing was touched").to_string();
        assert!(unmet.contains("post: nothing touched it"), "{unmet}");
    }
}

#[test]
fn property_a_start_inside_an_obstacle_is_refused() {
    let scenario = scenario(&[("xyz = [0.52, 0.30, 0.40]", "xyz = [0.52, 0.0, 0.40]")]).unwrap();
    let error = scenario.check_motion().unwrap_err().to_string();
    assert!(error.contains("obstacles.post") && error.contains("clear of forearm where session1 starts"), "{error}");
}

#[test]
fn property_broken_obstacles_are_refused_with_line_and_key() {
    let cases: [(&[(&str, &str)], &str); 9] = [
        (&[("shape = \"cylinder\"", "shape = \"cone\"")], "obstacles[1].shape = \"cone\": expected"),
        (&[("radius = 0.02", "radius = -0.02")], "obstacles[1].radius = -0.02: expected"),
        (&[("length = 0.40", "height = 0.40")], "obstacles[1].length: expected"),
        (&[("stiffness = 1e5", "stiffness = 1e12")], "obstacles[1].stiffness = 1e12: expected"),
        (&[("damping = 100.0", "damping = 100.0\nedge_radius = 0.03")], "obstacles[1].edge_radius = 0.03: expected"),
        (&[("damping = 100.0", "friction = 0.3")], "obstacles[1].friction = 0.3: expected"),
        (&[("seed = 1", "seed = 1\nplant.engine = \"reduced\"")], "expected plant.engine = \"rapier\""),
        (&[("[expect.obstacles.post]", "[expect.obstacles.wall]")], "expect.obstacles.wall"),
        (&[("xyz = [0.52, 0.30, 0.40]", "xyz = [0.52, 0.30]")], "obstacles[1].xyz = [0.52, 0.30]: expected"),
    ];
    for (changes, expected) in cases {
        let error = scenario(changes).err().unwrap_or_else(|| panic!("{changes:?} was accepted")).to_string();
        let place = error.split("scenario.toml:").nth(1).and_then(|rest| rest.split(':').next());
        assert!(place.is_some_and(|line| line.parse::<usize>().is_ok()), "no line in {error}");
        assert!(error.contains(expected), "{error} lacks {expected}");
    }
    let twice = ("[reference]", "[[obstacles]]\nname = \"post\"\nshape = \"sphere\"\nradius = 0.1\n[reference]");
    let error = scenario(&[twice]).expect_err("two of a name").to_string();
    assert!(error.contains("obstacles[2].name"), "{error}");
}
