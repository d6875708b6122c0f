//! Links that meet obstacles and end stops, against closed forms and the machine's own books.

#[path = "support/machines.rs"]
mod machines;

use lostmotion::effects::JointState;
use lostmotion::plant::{Obstacle, Options, Plant};
use lostmotion::robot::{Geometry, JointModel, Robot, Shape};
use lostmotion::units::JointKind;
use machines::*;
use nalgebra::{Isometry3, Vector3};

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
    JointModel { gear_stiffness: 1e-9, gear_damping: 0.0, ..plain_joint("joint1") }
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
