//! The simulated machine against an independent reference: Dormand-Prince at 1e-12, of equations written down a second time.
//! `docs/exactness.md` quotes the figures; each test holds it to them.

use crate::closed_loop::{Loop, Motion, Trace, fast, slow, truth};
use crate::exactness;
use crate::machines::*;
use crate::reference;
use lostmotion::effects::JointState;
use lostmotion::plant::{Energy, Engine, Evaluations, Options, Plant};

/// [rad] Error of a step of the reference.
const TOLERANCE: f64 = 1e-12;

/// [rad or m] What is promised of the motion of the links alone.
const SMOOTH: f64 = 1e-6;

/// [rad] 1e-4 degrees, what is promised of a motion through gaps and stick: a thirtieth of an encoder count is 1e-3 degrees.
const EVENTFUL: f64 = 1.7e-6;

fn own(options: Options) -> Options {
    Options { engine: Engine::Reduced, ideal_sensors: true, ..options }
}

/// All ways to evaluate the links: rapier where its answer is needed, rapier alone, the project's own algorithms alone.
const WAYS: [(Engine, Evaluations); 3] = [
    (Engine::Rapier, Evaluations::AsNeeded),
    (Engine::Rapier, Evaluations::EveryInterval),
    (Engine::Reduced, Evaluations::EveryInterval),
];

fn on((engine, evaluations): (Engine, Evaluations)) -> Options {
    Options { engine, evaluations, ideal_sensors: true, ..Options::default() }
}

// The links alone.

/// `M(q)⁻¹ (τ − h)` of the planar arm.
fn link_acceleration(q2: f64, v: [f64; 2], torque: [f64; 2]) -> [f64; 2] {
    let (a, b, c) = (I1 + M1 * C1 * C1 + M2 * L1 * L1, I2 + M2 * C2 * C2, M2 * L1 * C2);
    let (m11, m12, m22) = (a + b + 2.0 * c * q2.cos(), b + c * q2.cos(), b);
    let r1 = torque[0] + c * q2.sin() * (2.0 * v[0] * v[1] + v[1] * v[1]);
    let r2 = torque[1] - c * q2.sin() * v[0] * v[0];
    let det = m11 * m22 - m12 * m12;
    [(m22 * r1 - m12 * r2) / det, (m11 * r2 - m12 * r1) / det]
}

/// [N·m/rad], [N·m·s/rad], [rad/s] Soft springs whose far ends turn: the smooth torques `k (Ω t − q) − d (q̇ − Ω)` on the links.
const PULL: [[f64; 3]; 2] = [[1.2, 0.05, 0.5], [0.4, 0.02, -0.7]];
const START: [f64; 2] = [0.3, 0.4];

/// The links after two seconds under [`PULL`], and their largest speed.
fn pulled_truth() -> ([f64; 2], f64) {
    let mut fastest = 0.0_f64;
    let mut y = [START[0], START[1], 0.0, 0.0, 0.0];
    for _ in 0..2000 {
        let rate = |y: &[f64; 5]| {
            let [q1, q2, v1, v2, t] = *y;
            let torque = |[k, d, omega]: [f64; 3], q: f64, v: f64| k * (omega * t - q) - d * (v - omega);
            let [a1, a2] = link_acceleration(q2, [v1, v2], [torque(PULL[0], q1, v1), torque(PULL[1], q2, v2)]);
            [v1, v2, a1, a2, 1.0]
        };
        y = reference::integrate(rate, y, 1e-3, TOLERANCE);
        fastest = fastest.max(y[2].abs()).max(y[3].abs());
    }
    ([y[0], y[1]], fastest)
}

/// The same by the plant, in periods of `period`: gears are the springs, and rotors that nothing slows down their far ends.
fn pulled(options: &Options, period: f64) -> [f64; 2] {
    let mut model = plain(planar_arm());
    for (joint, [k, d, _]) in model.joints.iter_mut().zip(PULL) {
        (joint.rotor_inertia, joint.gear_stiffness, joint.gear_damping) = (Some(1e12), Some(k), Some(d));
    }
    let mut plant = Plant::new(&model, options).unwrap();
    let start = |j: usize| JointState { motor_velocity: PULL[j][2], link_position: START[j], ..JointState::default() };
    plant.launch(&[start(0), start(1)]);
    for _ in 0..(2.0 / period).round() as usize {
        plant.advance(&[0.0, 0.0], period).unwrap();
    }
    [0, 1].map(|joint| plant.states()[joint].link_position)
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

#[test]
fn equivalent_links_under_smooth_torques() {
    let (truth, fastest) = pulled_truth();
    assert!((1.8..2.2).contains(&fastest), "up to 120 deg/s: {:.0} deg/s", fastest.to_degrees());
    let mut worst = 0.0_f64;
    for way in WAYS {
        let error = apart(pulled(&on(way), 1e-3), truth);
        println!("{way:?}: {error:.1e} rad at up to {:.0} deg/s", fastest.to_degrees());
        assert!(error < SMOOTH, "{way:?}: {error:e} rad");
        worst = worst.max(error);
    }
    exactness::says("| links alone, smooth torques, 2 s at up to", &[fastest.to_degrees(), worst]);
}

/// The orders `log₂` of what each halving of the step gains. `row` is the beginning of the row of the page.
fn orders(row: &str, errors: &[f64]) -> Vec<f64> {
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    exactness::says(row, &[errors, &orders].concat());
    orders
}

#[test]
fn equivalent_smooth_motion_converges_at_fourth_order() {
    let (truth, _) = pulled_truth();
    let error = |ms: f64, evaluations| {
        let options = own(Options { step: 1e-3 * ms, substeps: 1, evaluations, ..Options::default() });
        apart(pulled(&options, 1e-3 * ms), truth)
    };
    let ways = [
        ("| links alone, interpolated between evaluations | 8, 4, 2, 1 |", Evaluations::AsNeeded),
        ("| links alone, evaluated at every stage | 8, 4, 2, 1 |", Evaluations::EveryStage),
    ];
    for (row, evaluations) in ways {
        let orders = orders(row, &[8.0, 4.0, 2.0, 1.0].map(|ms| error(ms, evaluations)));
        // Fourth order; a few tenths less where higher powers of the step still count.
        assert!(orders.iter().all(|order| *order > 3.6), "{orders:?}");
    }
}

/// Gears that do nothing: the links alone.
fn links_alone() -> Plant {
    let mut model = plain(planar_arm());
    for joint in &mut model.joints {
        (joint.gear_stiffness, joint.gear_damping) = (Some(1e-12), Some(0.0));
    }
    Plant::new(&model, &on(WAYS[1])).unwrap()
}

#[test]
fn property_free_arm_keeps_its_energy_for_a_minute() {
    let mut plant = links_alone();
    let moving = |link_velocity| JointState { link_velocity, ..JointState::default() };
    plant.launch(&[moving(2.0), moving(-3.0)]);
    let start = plant.energy().stored;
    let mut worst = 0.0_f64;
    for _ in 0..60_000 {
        plant.advance(&[0.0, 0.0], 1e-3).unwrap();
        worst = worst.max((plant.energy().stored / start - 1.0).abs());
    }
    exactness::says("| free arm, 60 s |", &[worst]);
    // What is promised of the links alone.
    assert!(worst < 1e-8, "{worst:e}");
}

// Links, gears, friction, drives, in closed loop.

/// The paper's staircase, one joint after the other: ±0.5 to ±10 deg/s in steps of 0.5 deg/s, a second each way.
fn staircase(t: f64) -> [f64; 2] {
    let stair = 0.5_f64.to_radians() * ((0.5 * t % 20.0).floor() + 1.0);
    let speed = if t % 2.0 < 1.0 { stair } else { -stair };
    if t < 40.0 { [speed, 0.0] } else { [0.0, speed] }
}

/// Jumps between ±1.5 rad/s, both joints out of step: the drives meet their current and voltage limits, the teeth hammer.
fn hard(t: f64) -> [f64; 2] {
    let square = |t: f64, half_period: f64| if ((t / half_period) as usize).is_multiple_of(2) { 1.5 } else { -1.5 };
    [square(t, 0.4), square(t + 0.15, 0.25)]
}

/// What happened on the way, both joints together, seen at the control's instants.
#[derive(Debug, Default)]
struct Events {
    /// Flanks touched after the gap.
    flanks: usize,
    /// Motors that moved back after they moved forth, or the other way round.
    reversals: usize,
    /// Rotors and links that came to rest.
    rests: usize,
    /// [1] What is missing in the books, `work − dissipated − gain of what is stored`, against the work done.
    unbooked: f64,
}

/// The same by the plant.
fn simulated(motion: Motion, seconds: f64, options: &Options) -> (Trace, Events) {
    let mut plant = Plant::new(&scara(), options).unwrap();
    let mut control = Loop::default();
    let mut events = Events::default();
    let mut moved = [0.0; 2];
    let step = |k: usize| {
        let before = [0, 1].map(|j| (plant.contact(j), plant.sticks(j)));
        let velocity = [0, 1].map(|j| plant.states()[j].motor_velocity);
        plant.advance(&control.command(motion(k as f64 * 1e-3), velocity), 1e-3).unwrap();
        for (j, (contact, sticks)) in before.into_iter().enumerate() {
            let velocity = plant.states()[j].motor_velocity;
            events.flanks += usize::from(plant.contact(j) != 0 && plant.contact(j) != contact);
            events.reversals += usize::from(velocity * moved[j] < 0.0);
            events.rests += (0..2).filter(|&side| plant.sticks(j)[side] && !sticks[side]).count();
            moved[j] = if velocity == 0.0 { moved[j] } else { velocity };
        }
        let [a, b] = [plant.states()[0], plant.states()[1]];
        [a.motor_position, a.link_position, b.motor_position, b.link_position]
    };
    let trace = (0..(seconds * 1e3) as usize).map(step).collect();
    // It starts at rest with nothing stored.
    let Energy { work, dissipated, stored } = plant.energy();
    events.unbooked = (work - dissipated - stored) / work;
    (trace, events)
}

/// Largest difference of two traces [rad].
fn difference(a: &Trace, b: &Trace) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Motor and link angles within 1e-4 degrees of the reference through reversals, impacts and stick, and the books closed within
/// 1e-4; the reference itself does not move by a hundredth of what is asked where its tolerance is halved.
#[test]
fn equivalent_closed_loop_with_dormand_prince() {
    let motions: [(&str, Motion, f64, usize); 3] = [
        ("both gearheads in closed loop, 4 s at up to 120 deg/s", fast, 4.0, 5),
        ("to and fro from rest at 0.5 to 6 deg/s, 4 s", slow, 4.0, 2),
        ("the paper's staircase, both joints, 80 s", staircase, 80.0, 70),
    ];
    let [mut of_reference, mut of_books] = [0.0_f64; 2];
    for (name, motion, seconds, often) in motions {
        let truth_at = |tolerance| truth(motion, seconds, tolerance);
        let truth = truth_at(TOLERANCE);
        let own_error = difference(&truth, &truth_at(0.5 * TOLERANCE));
        assert!(own_error < 0.01 * EVENTFUL, "{name}: {own_error:e} rad");
        of_reference = of_reference.max(own_error);
        let (mut worst, mut seen) = (0.0_f64, [0; 3]);
        for way in WAYS {
            let (trace, events) = simulated(motion, seconds, &on(way));
            let error = difference(&trace, &truth);
            println!("{name} {way:?}: {:.1e} deg, {events:?}", error.to_degrees());
            assert!(error < EVENTFUL, "{name} {way:?}: {error:e} rad");
            let Events { flanks, reversals, rests, unbooked } = events;
            assert!(unbooked.abs() < 1e-4, "{name} {way:?}: {unbooked:e} of the work");
            assert!(flanks.min(reversals).min(rests) >= often, "{name}: too little happens, {events:?}");
            (worst, of_books) = (worst.max(error), of_books.max(unbooked.abs()));
            seen = [flanks, reversals, rests];
        }
        let [flanks, reversals, rests] = seen.map(|count| count as f64);
        exactness::says(&format!("| {name} |"), &[flanks, reversals, rests, worst.to_degrees()]);
    }
    exactness::says("halving the tolerance changes it by at most", &[of_reference.to_degrees()]);
    exactness::says("Work, heat and stored energy agree within", &[of_books]);
}

/// Teeth that meet at up to 3 rad/s swing by 3 mrad on their stiffness: what is promised takes three steps a millisecond there.
/// The default of two stays below three times as much.
#[test]
fn equivalent_hammering_teeth_with_dormand_prince() {
    let truth = truth(hard, 4.0, TOLERANCE);
    let (mut quoted, mut of_books) = (Vec::new(), 0.0_f64);
    for (substeps, most) in [(3, EVENTFUL), (Options::default().substeps, 3.0 * EVENTFUL)] {
        let (trace, events) = simulated(hard, 4.0, &own(Options { substeps, ..Options::default() }));
        let error = difference(&trace, &truth);
        println!("hard, {substeps} steps a millisecond: {:.1e} deg, {events:?}", error.to_degrees());
        assert!(error < most, "{substeps} steps: {error:e} rad");
        assert!(events.unbooked.abs() < 1e-4 && events.flanks > 40 && events.reversals > 30, "{events:?}");
        let counts = [events.flanks, events.reversals, events.rests].map(|count| count as f64);
        of_books = of_books.max(events.unbooked.abs());
        // The default is the last, and stands first on the page.
        quoted = [&counts[..], &[error.to_degrees()], quoted.get(3..4).unwrap_or_default()].concat();
    }
    let row = "| jumps between ±86 deg/s, teeth that meet at up to 3 rad/s, limits of current and voltage, 4 s |";
    exactness::says(row, &quoted);
    exactness::says("with hammering teeth within", &[of_books]);
}

/// [rad] A hundredth of a degree, what coarse accuracy promises.
const COARSE: f64 = 1.7e-4;

/// Coarse accuracy is within a hundredth of a degree wherever the motion does not hammer, closes its books, and evaluates the links a tenth as often
/// while the arm is slow; where rapier is to be asked every millisecond, it is.
#[test]
fn equivalent_coarse_accuracy_within_a_hundredth_of_a_degree() {
    for (name, motion, seconds) in [("fast", fast as Motion, 4.0), ("slow", slow, 4.0), ("staircase", staircase, 80.0)]
    {
        let truth = truth(motion, seconds, TOLERANCE);
        for engine in [Engine::Rapier, Engine::Reduced] {
            let options = Options { engine, ideal_sensors: true, ..Options::coarse() };
            let (trace, events) = simulated(motion, seconds, &options);
            let error = difference(&trace, &truth);
            println!("coarse, {name} {engine:?}: {:.1e} deg, {events:?}", error.to_degrees());
            assert!(error < COARSE, "{name} {engine:?}: {error:e} rad");
            assert!(events.unbooked.abs() < 1e-2, "{name} {engine:?}: {:e} of the work", events.unbooked);
        }
    }
    let evaluations = |evaluations| {
        let options = Options { evaluations, ideal_sensors: true, ..Options::coarse() };
        let mut plant = Plant::new(&scara(), &options).unwrap();
        // At rest nothing happens.
        for _ in 0..1000 {
            plant.advance(&[0.0, 0.0], 1e-3).unwrap();
        }
        plant.counts().evaluations
    };
    // Intervals that are longer than any lull.
    let mut plant = Plant::new(&scara(), &Options { step: 0.05, ..Options::coarse() }).unwrap();
    plant.advance(&[0.0, 0.0], 1.0).unwrap();
    let seldom = evaluations(Evaluations::AsNeeded);
    assert!(seldom < 100, "{seldom} evaluations in a second at rest");
    assert!(evaluations(Evaluations::EveryInterval) >= 1000);
}

/// Runge-Kutta 4 between located events is of fourth order. Between evaluations the engine's answer is extrapolated as long as
/// that counts as right: smaller steps then lead down to what such a surprise may do, 1e-8 rad, and no further.
#[test]
fn equivalent_eventful_motion_converges_at_the_stated_order() {
    let truth = truth(fast, 2.0, TOLERANCE);
    let error = |per_ms: f64, evaluations| {
        let options = own(Options { step: 3e-3 / per_ms, substeps: 3, evaluations, ..Options::default() });
        difference(&simulated(fast, 2.0, &options).0, &truth)
    };
    let errors = [3.0, 6.0, 12.0, 24.0].map(|per_ms| error(per_ms, Evaluations::EveryStage));
    let orders_found =
        orders("| gears in closed loop, 2 s, evaluated at every stage | 1/3, 1/6, 1/12, 1/24 |", &errors);
    // Events fall on other places of the step each time: one halving gains more and the next less. The mean is what counts.
    let mean = orders_found.iter().sum::<f64>() / orders_found.len() as f64;
    assert!(mean > 0.9 * 4.0, "{orders_found:?}");

    let errors = [3.0, 6.0, 12.0, 24.0].map(|per_ms| error(per_ms, Evaluations::AsNeeded));
    orders("| gears in closed loop, 2 s, interpolated | 1/3, 1/6, 1/12, 1/24 |", &errors);
    assert!(errors[0] < 0.1 * EVENTFUL && errors[3] < 0.1 * errors[0], "{errors:?}");
}
