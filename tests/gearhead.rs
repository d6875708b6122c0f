//! Friction and gap: the laws themselves, and machines whose motion is known in closed form.

#[path = "support/machines.rs"]
mod machines;

use std::f64::consts::PI;

use lostmotion::drive::Noise;
use lostmotion::effects::JointState;
use lostmotion::gearhead::{
    DeadZone, Direction, Exponential, FrictionLaw, Gearhead, Lines, Memory, Mesh, Slip, slowed,
};
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::JointModel;
use lostmotion::units::DEG;
use machines::*;

/// Exact sensors, and steps of 0.1 ms: what is left is Runge-Kutta 4's own error.
fn fine() -> Options {
    Options { ideal_sensors: true, substeps: 10, ..Options::default() }
}

/// One joint about a vertical axis with a link of 0.05 kg·m².
fn single(joint: JointModel) -> Plant {
    Plant::new(&model(turntable(0.05), vec![joint]), &fine()).unwrap()
}

#[test]
fn analytic_dead_zone_is_a_spring_outside_its_gap() {
    let gear = DeadZone { backlash: 0.01, stiffness: 2000.0, damping: 3.0 };
    assert_eq!(gear.torque(0.004, 5.0), 0.0);
    assert!((gear.torque(0.006, 0.1) - (2000.0 * 0.001 + 0.3)).abs() < 1e-12);
    assert!((gear.torque(-0.006, 0.1) - (-2000.0 * 0.001 + 0.3)).abs() < 1e-12);
    // Parting faster than the damper lets the flank follow: no contact, though the teeth overlap.
    assert_eq!(gear.torque(0.006, -1.0), 0.0);
}

#[test]
fn analytic_flanks_that_press_against_each_other_add_up() {
    let gear = DeadZone { backlash: -0.002, stiffness: 2000.0, damping: 3.0 };
    // Both press, each by 0.001 rad and what the wind-up adds or takes: twice the stiffness and the damping.
    assert!((gear.of_flanks(0.0005, 0.1) - 2.0 * (2000.0 * 0.0005 + 0.3)).abs() < 1e-12);
    // Beyond the preload one flank is left.
    assert!((gear.of_flanks(0.003, 0.1) - (2000.0 * 0.004 + 0.3)).abs() < 1e-12);
}

#[test]
fn property_a_tooth_never_pulls_and_both_flanks_are_alike() {
    let gear = DeadZone { backlash: 0.01, stiffness: 2000.0, damping: 3.0 };
    let mut noise = Noise::new(3, 0);
    for _ in 0..10_000 {
        let (x, x_dot) = (0.05 * (noise.uniform() - 0.5), 20.0 * (noise.uniform() - 0.5));
        let torque = gear.torque(x, x_dot);
        assert!(torque * x >= 0.0);
        assert_eq!(torque, -gear.torque(-x, -x_dot));
    }
}

#[test]
fn equivalent_flanks_of_a_perfect_mesh_are_those_of_the_dead_zone() {
    let gear = DeadZone { backlash: 0.01, stiffness: 2000.0, damping: 3.0 };
    let mesh = Mesh::with_gap(gear.backlash);
    let mut noise = Noise::new(5, 0);
    for _ in 0..1000 {
        let [theta, q] = [(); 2].map(|()| 0.05 * (noise.uniform() - 0.5));
        let [omega, v] = [(); 2].map(|()| 20.0 * (noise.uniform() - 0.5));
        for side in [1.0, -1.0] {
            // The same sums in the same order: not a bit apart.
            assert_eq!(mesh.flank([theta, omega], [q, v], side), gear.flank(theta - q, omega - v, side));
            assert_eq!(mesh.lever(side), 1.0);
        }
    }
}

/// What an integrator that keeps the touching flank makes of the law is the law of both flanks.
#[test]
fn equivalent_the_flank_that_touches_is_the_whole_dead_zone() {
    let gear = DeadZone { backlash: 0.01, stiffness: 2000.0, damping: 3.0 };
    let mut noise = Noise::new(6, 0);
    for _ in 0..10_000 {
        let (x, x_dot) = (0.05 * (noise.uniform() - 0.5), 20.0 * (noise.uniform() - 0.5));
        let torque = match gear.contact(x, x_dot) {
            0 => 0.0,
            side => gear.push(&gear.flank(x, x_dot, f64::from(side))),
        };
        assert_eq!(torque, gear.torque(x, x_dot));
    }
}

#[test]
fn property_both_sides_of_a_gearhead_share_its_law() {
    let gear = DeadZone { backlash: 0.01, stiffness: 2000.0, damping: 3.0 };
    let (share, bearing) = (0.25, 0.03);
    let whole = friction(0.173, 0.187, 0.04, 0.2, share);
    let Gearhead { rotor, link, .. } = Gearhead::new(gear, Some(&whole), bearing);
    for k in 0..200 {
        let speed = 0.01 * f64::from(k);
        for (direction, slip) in [(Direction::Positive, Slip::Positive), (Direction::Negative, Slip::Negative)] {
            let law = whole.law.magnitude(direction, speed);
            let [rotor, link] = [&rotor, &link].map(|side| side.torque(side.level(slip, speed)));
            // Rounding of three sums at 0.6 N·m.
            assert!((rotor - (1.0 - share) * law).abs() < 1e-15, "{speed}: {rotor} {law}");
            assert!((link - share * law - bearing).abs() < 1e-15, "{speed}: {link} {law}");
        }
    }
    let without = Gearhead::new(gear, None, 0.0);
    assert!(!without.rotor.holds() && !without.link.holds());
}

#[test]
fn equivalent_two_lines_of_a_side_change_at_the_kink_of_the_law() {
    let lines = Lines { a1: 0.46, b1: -6.8, a2: 0.27, b2: 0.61 };
    let law = FrictionLaw::TwoLines([lines; 2]);
    let friction = lostmotion::gearhead::Friction { law, link_share: 0.0 };
    let gear = DeadZone { backlash: 0.0, stiffness: 2000.0, damping: 3.0 };
    let rotor = Gearhead::new(gear, Some(&friction), 0.0).rotor;
    for k in 1..200 {
        let velocity = 5e-4 * f64::from(k - 100);
        let slip = rotor.slip(velocity);
        // The same products and sums.
        assert_eq!(rotor.level(slip, velocity.abs()), law.magnitude(Direction::of(velocity), velocity.abs()));
        assert_eq!(slip.is_fast(), velocity.abs() > lines.switch_velocity());
    }
}

/// What an integrator runs goes on along its tangent below rest, where a step may lead before the end of a slip is located.
#[test]
fn property_a_side_goes_on_along_its_tangent_below_rest() {
    let gear = DeadZone { backlash: 0.0, stiffness: 2000.0, damping: 3.0 };
    let rotor = Gearhead::new(gear, Some(&friction(0.173, 0.187, 0.04, 0.2, 0.0)), 0.0).rotor;
    let at = |s: f64| rotor.level(Slip::Positive, s * 0.04);
    // Both pieces and their slopes meet at |v| σ = −1; the second difference there is half that of the exponential, e · 1e-6 of the drop.
    assert!((at(-1.0 + 1e-3) - 2.0 * at(-1.0) + at(-1.0 - 1e-3)).abs() < 3e-6 * 0.014);
    // Rounding of a few sums at 0.3 N·m.
    assert!((at(-3.0) - 2.0 * at(-2.0) + at(-1.0)).abs() < 1e-15);
}

#[test]
fn analytic_friction_stops_what_it_can_and_turns_nothing() {
    assert_eq!(slowed(0.5, [0.2, 9.0]), 0.3);
    assert_eq!(slowed(-0.5, [9.0, 0.2]), -0.3);
    assert_eq!(slowed(0.1, [0.2, 0.0]), 0.0);
    assert_eq!(slowed(-0.1, [0.0, 0.2]), 0.0);
    assert_eq!(slowed(0.0, [0.2, 0.2]), 0.0);
}

#[test]
fn analytic_contacts_grow_at_rest_as_the_exponential_does() {
    let (growth, time_constant, slip_distance) = (0.1, 2.0, 0.01);
    let memory = Memory::Rest { growth, time_constant, slip_distance };
    let (h, mut grown) = (0.01, 0.0);
    for k in 1..=1000 {
        grown += memory.change(grown, 0.0, 0.2, h);
        let t = h * f64::from(k);
        // Each step is exact: rounding of a thousand of them.
        assert!((grown - (1.0 - (-t / time_constant).exp())).abs() < 1e-13, "{t}");
    }
}

/// The gear of a plant at an instant: the law's torque at the states that it shows, and the flank that touches.
fn law_of_the_plant(plant: &Plant, gear: &DeadZone) -> [f64; 2] {
    let state = &plant.states()[0];
    let (x, x_dot) = (state.motor_position - state.link_position, state.motor_velocity - state.link_velocity);
    [gear.torque(x, x_dot), state.gear_torque]
}

/// What the plant integrates is the dead zone of the doc: where it starts, and after any number of flanks left and met.
#[test]
fn regress_the_plant_integrates_the_dead_zone_that_is_tested() {
    let (gap, stiffness, damping) = (0.01, 2000.0, 3.0);
    let gear = DeadZone { backlash: gap, stiffness, damping };
    let joint = JointModel {
        rotor_inertia: Some(0.02),
        gear_stiffness: Some(stiffness),
        gear_damping: Some(damping),
        backlash: Some(gap),
        ..plain_joint("joint1")
    };
    let mut plant = single(joint);
    let mut noise = Noise::new(7, 0);
    let mut flanks = [0; 3];
    for _ in 0..300 {
        let (x, x_dot) = (0.016 * (noise.uniform() - 0.5), 4.0 * (noise.uniform() - 0.5));
        let state = JointState { motor_position: x, motor_velocity: x_dot, ..JointState::default() };
        plant.launch(&[state]);
        let [law, integrated] = law_of_the_plant(&plant, &gear);
        // The same operations on the same numbers: rounding of the sums, at torques up to 12 N·m.
        assert!((law - integrated).abs() < 1e-12, "x = {x}, x' = {x_dot}: {law}, the plant has {integrated}");
        assert_eq!(plant.contact(0), gear.contact(x, x_dot));
        flanks[(plant.contact(0) + 1) as usize] += 1;
        for _ in 0..5 {
            plant.advance(&[0.0], 1e-3).unwrap();
            let [law, integrated] = law_of_the_plant(&plant, &gear);
            // A flank is met and left where the event is located, 1e-10 rad of wind-up: 2e-7 N·m.
            assert!((law - integrated).abs() < 1e-6, "{law}, the plant has {integrated}");
        }
    }
    // 5/8 of the draws lie within the gap.
    assert!(flanks.iter().all(|count| *count > 30), "{flanks:?}");
}

/// The published lines as [a1, b1, a2, b2], N·m against deg/s, with joint 2 + corrected for its misprint.
const PUBLISHED: [[f64; 4]; 4] = [
    [0.4645, -0.119, 0.2718, 0.0106],
    [0.4493, -0.1085, 0.2847, 0.0072],
    [0.3013, -0.0562, 0.1334, 0.0312],
    [0.3141, -0.0594, 0.1623, 0.0359],
];

#[test]
fn published_lines_meet_at_the_switch_velocity_of_equation_8() {
    for ([a1, b1, a2, b2], switch) in PUBLISHED.into_iter().zip([1.487, 1.423, 1.921, 1.593]) {
        let lines = Lines { a1, b1: b1 / DEG, a2, b2: b2 / DEG };
        // By hand from the published numbers, to their last digit. The paper prints 1.5, 1.5, 1.8 and 1.9 deg/s.
        assert!((lines.switch_velocity() / DEG - switch).abs() < 5e-4, "{}", lines.switch_velocity() / DEG);
        let law = FrictionLaw::TwoLines([lines, lines]);
        let at = lines.switch_velocity();
        // Equation 8 is where both lines meet: the law has no step there.
        let (below, above) = (law.kinetic(at * (1.0 - 1e-12)), law.kinetic(at * (1.0 + 1e-12)));
        assert!((below - above).abs() < 1e-9);
        assert_eq!(law.magnitude(Direction::Positive, 0.0), a1);
    }
}

#[test]
fn published_exponential_has_the_lines_as_tangents() {
    for [a1, b1, a2, b2] in PUBLISHED {
        let stribeck_velocity = (a1 - a2) / (b2 - b1) * DEG;
        let one = Exponential { coulomb: a2, breakaway: a1, stribeck_velocity, viscous: b2 / DEG };
        let law = FrictionLaw::Exponential([one, one]);
        let slope = |v: f64| (law.kinetic(v + 1e-7) - law.kinetic(v)) / 1e-7;
        // The difference quotient is off by half the curvature times 1e-7: 1e-5 relative.
        assert!((slope(0.0) * DEG / b1 - 1.0).abs() < 1e-5);
        assert!((law.kinetic(20.0 * DEG) - (a2 + 20.0 * b2)).abs() < 1e-5);
        assert!((law.kinetic(-20.0 * DEG) + law.kinetic(20.0 * DEG)).abs() < 1e-15);
    }
}

#[test]
fn analytic_two_masses_on_a_spring() {
    let (j, link, k) = (0.02, 0.05, 3000.0);
    let joint = JointModel {
        rotor_inertia: Some(j),
        gear_stiffness: Some(k),
        gear_damping: Some(0.0),
        ..plain_joint("joint1")
    };
    let mut plant = single(joint);
    plant.launch(&[JointState { motor_velocity: 1.0, ..JointState::default() }]);
    let omega = (k * (1.0 / j + 1.0 / link)).sqrt();
    let mean = j / (j + link);
    for step in 1..=2000 {
        plant.advance(&[0.0], 1e-3).unwrap();
        let t = f64::from(step) * 1e-3;
        let state = plant.states()[0];
        let theta = mean * t + (1.0 - mean) * (omega * t).sin() / omega;
        let q = mean * t - mean * (omega * t).sin() / omega;
        // Phase lost by Runge-Kutta 4: (ωh)⁵/120 a step, 2·10⁴ steps of ωh = 0.046, amplitude 1.5 mrad: 5e-8.
        assert!((state.motor_position - theta).abs() < 1e-7 && (state.link_position - q).abs() < 1e-7, "{t}");
    }
}

#[test]
fn analytic_pendulum_in_its_backlash_keeps_its_period() {
    let (j, link, k, gap, v0) = (0.02, 0.05, 3000.0, 0.02, 0.8);
    let joint = JointModel {
        rotor_inertia: Some(j),
        gear_stiffness: Some(k),
        gear_damping: Some(0.0),
        backlash: Some(gap),
        ..plain_joint("joint1")
    };
    let mut plant = single(joint);
    // No momentum in all, relative velocity v0: across the gap at v0, then half an oscillation on the flank, and back.
    let (rotor, other) = (v0 * link / (j + link), -v0 * j / (j + link));
    plant.launch(&[JointState { motor_velocity: rotor, link_velocity: other, ..JointState::default() }]);
    let period = 2.0 * gap / v0 + 2.0 * PI / (k * (1.0 / j + 1.0 / link)).sqrt();
    for _ in 0..20 {
        plant.advance(&[0.0], period).unwrap();
        let state = plant.states()[0];
        // The flank's half oscillation loses 1e-7 of its phase a step of 0.1 ms; 40 contacts of 70 steps.
        assert!((state.motor_position).abs() < 1e-6 && (state.motor_velocity - rotor).abs() < 1e-5, "{state:?}");
        assert_eq!(plant.contact(0), 0);
    }
}

#[test]
fn analytic_bounce_off_a_damped_flank() {
    let (j, link, k, d, gap, v0) = (0.02, 0.05, 3000.0, 4.0, 0.02, 0.8);
    let joint = JointModel {
        rotor_inertia: Some(j),
        gear_stiffness: Some(k),
        gear_damping: Some(d),
        backlash: Some(gap),
        ..plain_joint("joint1")
    };
    let mut plant = single(joint);
    let reduced = j * link / (j + link);
    plant.launch(&[JointState { motor_velocity: v0, ..JointState::default() }]);
    // p = v0/ω_d e^{−δt} sin ω_d t until k p + d ṗ = 0, the tooth leaving before p = 0.
    let delta = 0.5 * d / reduced;
    let omega = (k / reduced - delta * delta).sqrt();
    let leaves = (PI + (-d * omega / (k - d * delta)).atan()) / omega;
    let v1 = v0 * (-delta * leaves).exp() * ((omega * leaves).cos() - delta / omega * (omega * leaves).sin());
    plant.advance(&[0.0], 0.5 * gap / v0 + leaves + 1e-3).unwrap();
    let state = plant.states()[0];
    assert_eq!(plant.contact(0), 0);
    // As the undamped contact: 1e-6 of the velocity.
    assert!((state.motor_velocity - state.link_velocity - v1).abs() < 1e-6 * v0, "{state:?} {v1}");
    let books = plant.energy();
    // What the bounce has cost is the heat, the rest of compression that relaxes in the flank included.
    let lost = 0.5 * reduced * (v0 * v0 - v1 * v1);
    assert!((books.dissipated - lost).abs() < 1e-5 * lost, "{books:?} {lost}");
}

#[test]
fn published_coulomb_oscillator_loses_the_same_each_half_turn() {
    // A rotor too heavy to move holds one end of the spring: amplitude falls by 2 F/k each half period, and the link stops
    // within ±F/k (J. P. Den Hartog 1931; the case of Modelica's BearingFriction).
    let (k, level) = (300.0, 0.6);
    let joint = JointModel {
        rotor_inertia: Some(1e9),
        gear_stiffness: Some(k),
        gear_damping: Some(0.0),
        friction: Some(friction(level, level, 0.1, 0.0, 1.0)),
        ..plain_joint("joint1")
    };
    let mut plant = single(joint);
    let start = 0.0173;
    plant.launch(&[JointState { link_position: start, ..JointState::default() }]);
    let half = PI * (0.05_f64 / k).sqrt();
    let mut amplitude = start;
    for turn in 1..=4 {
        plant.advance(&[0.0], half).unwrap();
        amplitude -= 2.0 * level / k;
        let sign = if turn % 2 == 0 { 1.0 } else { -1.0 };
        // 1e-8 of slow waves in the heavy rotor and Runge-Kutta's phase.
        assert!((plant.states()[0].link_position - sign * amplitude).abs() < 1e-7, "{turn}");
    }
    assert!(amplitude < level / k);
    plant.advance(&[0.0], 1.0).unwrap();
    assert_eq!(plant.sticks(0), [false, true]);
    assert!((plant.states()[0].link_position - amplitude).abs() < 1e-7);
}

#[test]
fn analytic_rotor_breaks_away_at_its_level() {
    let level = 0.187;
    let joint = JointModel {
        friction: Some(friction(0.173, level, 0.04, 0.2, 0.0)),
        backlash: Some(0.01),
        ..plain_joint("joint1")
    };
    let mut plant = single(joint);
    for direction in [1.0, -1.0] {
        plant.place(&[0.0]);
        let mut torque = 0.9 * level;
        while plant.sticks(0)[0] && torque < 2.0 * level {
            torque += 1e-4 * level;
            plant.advance(&[direction * torque], 1e-3).unwrap();
        }
        // The ramp's own step.
        assert!((torque / level - 1.0).abs() <= 1.01e-4, "{torque}");
    }
}

#[test]
fn property_nothing_creeps_while_it_sticks() {
    let level = 0.2;
    let joint = |link_share| JointModel {
        friction: Some(friction(0.15, level, 0.04, 0.2, link_share)),
        ..plain_joint("joint1")
    };
    let hold = 0.9 * level;
    // The rotor under motor torque.
    let mut rotor = single(joint(0.0));
    rotor.advance(&[hold], 60.0).unwrap();
    assert_eq!(rotor.states()[0].motor_position, 0.0);
    // A link with friction of its own under gravity, the gear slack.
    let slack = JointModel { backlash: Some(1.0), ..joint(1.0) };
    let robot = pendulum(1.0, 0.1);
    let angle = (hold / (1.0 * 9.81 * 0.1)).asin();
    let mut link = Plant::new(&model(robot, vec![slack]), &fine()).unwrap();
    link.place(&[angle]);
    link.advance(&[0.0], 60.0).unwrap();
    assert_eq!(link.states()[0].link_position, angle);
}

#[test]
fn analytic_back_driven_gear_moves_when_the_load_beats_the_rotor() {
    let level = 0.3;
    let joint = JointModel { friction: Some(friction(level, level, 0.1, 0.5, 0.0)), ..plain_joint("joint1") };
    let robot = pendulum(1.0, 0.1);
    for (share, moves) in [(0.98, false), (1.02, true)] {
        let mut plant = Plant::new(&model(robot.clone(), vec![joint.clone()]), &fine()).unwrap();
        let load = share * level;
        let angle = (load / (1.0 * 9.81 * 0.1)).asin();
        // At rest on a gear wound up by the load.
        plant.launch(&[JointState {
            link_position: angle,
            motor_position: angle + load / 3000.0,
            ..JointState::default()
        }]);
        plant.advance(&[0.0], 5.0).unwrap();
        assert_eq!(!plant.sticks(0)[0], moves, "{share}");
    }
}

#[test]
fn property_a_link_that_sticks_is_not_dragged_by_its_neighbour() {
    let mut model = scara();
    model.joints[1].friction = Some(friction(3.0, 3.0, 0.05, 0.2, 0.9));
    let mut plant = Plant::new(&model, &fine()).unwrap();
    plant.place(&[0.0, 0.7]);
    for k in 0..2000 {
        plant.advance(&[8.0 * (f64::from(k) * 0.01).sin(), 0.0], 1e-3).unwrap();
        assert_eq!(plant.states()[1].link_position, 0.7);
    }
    assert!(plant.states()[0].link_position.abs() > 0.01);
}

#[test]
fn property_gear_torque_agrees_with_its_contact() {
    let mut plant = Plant::new(&scara(), &fine()).unwrap();
    let mut touched = [0; 3];
    for k in 0..4000 {
        let t = f64::from(k) * 1e-3;
        plant.advance(&[6.0 * (3.0 * t).sin(), 4.0 * (5.0 * t).sin()], 1e-3).unwrap();
        for joint in 0..2 {
            let state = plant.states()[joint];
            let contact = plant.contact(joint);
            touched[(contact + 1) as usize] += 1;
            assert!(state.gear_torque * f64::from(contact) >= 0.0);
            assert_eq!(contact == 0, state.gear_torque == 0.0);
        }
    }
    assert!(touched.iter().all(|&times| times > 100), "{touched:?}");
}
