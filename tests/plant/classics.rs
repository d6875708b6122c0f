//! The simulated machine against classics with closed forms: springs, gaps, friction, and a gear that is driven backwards.
//!
//! Each test states its formula. Where links are involved both engines have to agree with it. A tolerance on an angle is
//! [`EXACT`] unless a closed form allows less.

use std::f64::consts::PI;

use crate::engines::*;
use crate::exactness;
use crate::machines::*;
use lostmotion::effects::JointState;
use lostmotion::gearhead::{Direction, Friction, FrictionLaw, Lines};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use nalgebra::Vector3;

/// [rad or m] 1e-4 degrees: what is promised of a motion through impacts, reversals and stick.
const EXACT: f64 = 1.7e-6;

/// [N·m] Friction that nothing here overcomes: it holds a rotor like a vice.
const VICE: f64 = 1e9;

/// [kg·m²] A rotor that nothing here slows down: it turns at the velocity that it has.
const FLYWHEEL: f64 = 1e12;

/// A mass–spring–damper from a state: `ẍ + 2δ ẋ + ω² (x − x∞) = 0`; δ may be negative, |δ| < ω.
#[derive(Clone, Copy)]
struct Oscillator {
    omega: f64,
    delta: f64,
    rest: f64,
    x: f64,
    v: f64,
}

impl Oscillator {
    /// `x = x∞ + e^{−δt} (A cos ω_d t + B sin ω_d t)`, `A = x₀ − x∞`, `B = (v₀ + δ A)/ω_d`.
    fn at(&self, t: f64) -> (f64, f64) {
        let omega_d = (self.omega * self.omega - self.delta * self.delta).sqrt();
        let a = self.x - self.rest;
        let b = (self.v + self.delta * a) / omega_d;
        let (sin, cos) = (omega_d * t).sin_cos();
        let decay = (-self.delta * t).exp();
        let x = decay * (a * cos + b * sin);
        (self.rest + x, decay * omega_d * (b * cos - a * sin) - self.delta * x)
    }

    /// First time after `from` at which `f(x, v)` changes its sign, looked for in steps of a five-hundredth of a period.
    fn when(&self, from: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
        let at = |t: f64| {
            let (x, v) = self.at(t);
            f(x, v)
        };
        let step = 2.0 * PI / self.omega / 500.0;
        let (mut low, mut high) = (from, from + step);
        while at(low).signum() == at(high).signum() {
            (low, high) = (high, high + step);
        }
        while high - low > 1e-15 * high {
            let middle = 0.5 * (low + high);
            if middle == low || middle == high {
                break;
            }
            if at(middle).signum() == at(low).signum() { low = middle } else { high = middle }
        }
        high
    }
}

/// Two inertias on a spring with a damper, a constant torque τ on the first:
/// `ẍ + d/μ ẋ + k/μ x = τ/J` for the wind-up `x = θ − q` with `1/μ = 1/J + 1/I`, and `s̈ = τ/(J + I)` for the centre of inertia
/// `s = (J θ + I q)/(J + I)`. (S. Timoshenko, Vibration Problems in Engineering: torsional vibration of two discs on a shaft.)
#[test]
fn analytic_two_inertias_on_a_spring() {
    let (j, i, k, d, torque) = (0.02, 0.05, 300.0, 0.2, 0.4);
    let joint =
        JointModel { rotor_inertia: Some(j), gear_stiffness: Some(k), gear_damping: Some(d), ..plain_joint("joint1") };
    let inverse = 1.0 / j + 1.0 / i;
    let (omega0, v0) = (3.0, -1.0);
    let windup = Oscillator {
        omega: (k * inverse).sqrt(),
        delta: 0.5 * d * inverse,
        rest: torque / j / (k * inverse),
        x: 0.0,
        v: omega0 - v0,
    };
    let mut error = 0.0_f64;
    on_both_engines(&model(turntable(i), vec![joint]), |mut plant| {
        plant.launch(&[JointState { motor_velocity: omega0, link_velocity: v0, ..JointState::default() }]);
        let mut worst = 0.0_f64;
        for step in 1..=1000 {
            plant.advance(&[torque], 1e-3).unwrap();
            let t = 1e-3 * f64::from(step);
            let s = (j * omega0 + i * v0) / (j + i) * t + 0.5 * torque / (j + i) * t * t;
            let (x, _) = windup.at(t);
            let state = plant.states()[0];
            worst = worst.max((state.motor_position - (s + i / (j + i) * x)).abs());
            worst = worst.max((state.link_position - (s - j / (j + i) * x)).abs());
        }
        error = error.max(assert_near("two inertias, worst of a second [rad]", worst, 0.0, EXACT));
    });
    exactness::says("| ẍ + d/μ ẋ + k/μ x = τ/J |", &[error]);
}

/// A link on the gear of a rotor in a vice.
fn link_on_a_gap(inertia: f64, k: f64, d: f64, gap: f64) -> Model {
    let joint = JointModel {
        gear_stiffness: Some(k),
        gear_damping: Some(d),
        backlash: Some(gap),
        friction: Some(friction(VICE, VICE, 1.0, 0.0, 0.0)),
        ..plain_joint("joint1")
    };
    model(turntable(inertia), vec![joint])
}

/// Free oscillation with a dead zone: half a sine on each flank, uniform motion through the gap at the velocity `v` between:
/// `T = 2π/ω + 2 b/v`, `ω² = k/I`. (Piecewise linear oscillator with clearance: S. W. Shaw, P. J. Holmes 1983.)
#[test]
fn analytic_period_of_a_torsion_pendulum_with_backlash() {
    let (inertia, k, gap, v) = (0.05_f64, 500.0, 0.02, 0.8);
    let omega = (k / inertia).sqrt();
    let period = 2.0 * PI / omega + 2.0 * gap / v;
    let mut error = 0.0_f64;
    on_both_engines(&link_on_a_gap(inertia, k, 0.0, gap), |mut plant| {
        plant.launch(&[JointState { link_velocity: v, ..JointState::default() }]);
        plant.advance(&[0.0], 0.5 * gap / v + 0.5 * PI / omega).unwrap();
        assert_near("turning point [rad]", plant.states()[0].link_position, 0.5 * gap + v / omega, EXACT);
        for _ in 0..20 {
            plant.advance(&[0.0], period).unwrap();
        }
        let state = plant.states()[0];
        let turned = 0.5 * gap + v / omega;
        error = error.max(assert_near("the same after 20 periods [rad]", state.link_position, turned, EXACT));
        // At the turning point position says little about the phase, velocity does: ω times a phase of EXACT ω/v radians.
        assert_near("its velocity [rad/s]", state.link_velocity, 0.0, omega * EXACT);
    });
    exactness::says("| T = 2π/ω + 2 b/v |", &[error]);
}

/// With damping a tooth is left when `k p + d ṗ = 0`, compression still there, and each visit takes the same share of the
/// velocity: `ω_d t = π − atan2(d ω_d, k − d δ)`, `e = |ṗ(t)|/v₀`. After n visits the energy is `e^{2n}` of the first.
#[test]
fn analytic_decay_of_a_torsion_pendulum_with_backlash() {
    let (inertia, k, d, gap, v) = (0.05_f64, 500.0, 0.4_f64, 0.02, 0.8);
    let (omega, delta) = ((k / inertia).sqrt(), 0.5 * d / inertia);
    let omega_d = (omega * omega - delta * delta).sqrt();
    let contact = (PI - (d * omega_d).atan2(k - d * delta)) / omega_d;
    let (left_at, left_with) = Oscillator { omega, delta, rest: 0.0, x: 0.0, v }.at(contact);
    let restitution = -left_with / v;
    let mut error = 0.0_f64;
    on_both_engines(&link_on_a_gap(inertia, k, d, gap), |mut plant| {
        plant.launch(&[JointState { link_position: 0.5 * gap, link_velocity: v, ..JointState::default() }]);
        let start = plant.energy().stored;
        let (mut speed, visits) = (v, 10);
        for visit in 0..visits {
            plant.advance(&[0.0], contact).unwrap();
            speed *= restitution;
            // To the other flank, from where the compression of this one was left.
            let flight = (gap + left_at * speed / (restitution * v)) / speed;
            plant.advance(&[0.0], flight).unwrap();
            let side = if visit % 2 == 0 { -1.0 } else { 1.0 };
            let state = plant.states()[0];
            // A tooth met a microsecond late is met at v · 1e-6: the flight between has the accuracy of the instants.
            assert_near("flank met at [rad]", state.link_position, side * 0.5 * gap, EXACT);
        }
        let share = plant.energy().stored / start;
        // Ten visits of an error of 1e-6 each; what is left is a few per cent.
        error = error.max(assert_near("energy left", share / restitution.powi(2 * visits), 1.0, 2e-5));
        assert!(share < 0.5, "{share}");
    });
    exactness::says("| each impact leaves the same share of the velocity |", &[error]);
}

/// A mass on a spring that is pulled at a velocity, with friction of the two lines `a1 + b1 v` and `a2 + b2 v`.
#[derive(Clone, Copy)]
struct StickSlip {
    inertia: f64,
    k: f64,
    pull: f64,
    law: Lines,
}

/// One period of stick-slip.
#[derive(Debug)]
struct Cycle {
    slip: f64,
    stick: f64,
    /// [rad] of the link in a slip.
    stroke: f64,
}

impl StickSlip {
    /// An arc of the extension `u = V t − q` under the line `a + b v`: `J ü + b u̇ + k u = a + b V`.
    fn arc(&self, (a, b): (f64, f64), (u, rate): (f64, f64)) -> Oscillator {
        let (omega, delta) = ((self.k / self.inertia).sqrt(), 0.5 * b / self.inertia);
        Oscillator { omega, delta, rest: (a + b * self.pull) / self.k, x: u, v: rate }
    }

    /// From breakaway at `k u = a1`, up the first line, along the second, down the first, to rest, and back to breakaway.
    fn cycle(&self) -> Cycle {
        let Lines { a1, b1, a2, b2 } = self.law;
        let switch = self.law.switch_velocity();
        let mut slip = 0.0;
        let mut state = (a1 / self.k, self.pull);
        // Each line, and the velocity of the mass at which it ends.
        for (line, end) in [((a1, b1), switch), ((a2, b2), switch), ((a1, b1), 0.0)] {
            let arc = self.arc(line, state);
            // Past the instant at which the arc begins on the border that it ends on.
            let t = arc.when(1e-6 / arc.omega, |_, rate| self.pull - rate - end);
            slip += t;
            state = arc.at(t);
        }
        let stick = (a1 / self.k - state.0) / self.pull;
        Cycle { slip, stick, stroke: self.pull * (slip + stick) }
    }
}

/// A mass pulled by a spring at constant velocity V: with friction that falls at once from F_S to F_C, slip is a part of a circle
/// in the plane of extension and velocity,
/// `t_stick = 2 (F_S − F_C)/(k V)`, `t_slip = 2/ω (π − atan((F_S − F_C) ω/(k V)))`. With the two lines of equation 9 it is three
/// arcs. (The mass on a moving belt, seen from the belt: J. J. Thomsen, A. Fidlin 2003 and the references there.)
#[test]
fn analytic_stick_slip_of_a_mass_pulled_by_a_spring() {
    let case = StickSlip { inertia: 0.05, k: 20.0, pull: 0.03, law: Lines { a1: 0.5, b1: -1.5, a2: 0.3, b2: 0.05 } };
    // An arc with friction that falls at once is the textbook's.
    let Lines { a1, a2, .. } = case.law;
    let (omega, lag) = ((case.k / case.inertia).sqrt(), (a1 - a2) / case.k);
    let sudden = case.arc((a2, 0.0), (a1 / case.k, case.pull));
    let slip = sudden.when(1e-6 / omega, |_, rate| case.pull - rate);
    assert_near("t_slip", slip, 2.0 / omega * (PI - (lag * omega / case.pull).atan()), 1e-12);
    assert_near("t_stick", (a1 / case.k - sudden.at(slip).0) / case.pull, 2.0 * lag / case.pull, 1e-12);

    let Cycle { slip, stick, stroke } = case.cycle();
    assert!(slip > 0.1 && stick > 0.1, "{slip} {stick}");
    let joint = JointModel {
        rotor_inertia: Some(FLYWHEEL),
        gear_stiffness: Some(case.k),
        gear_damping: Some(0.0),
        friction: Some(Friction { law: FrictionLaw::TwoLines([case.law; 2]), link_share: 1.0 }),
        ..plain_joint("joint1")
    };
    let mut error = 0.0_f64;
    on_both_engines(&model(turntable(case.inertia), vec![joint]), |mut plant| {
        let first = case.law.a1 / case.k;
        plant.launch(&[JointState { motor_velocity: case.pull, ..JointState::default() }]);
        // Just before the first breakaway, then just before and after the end of each slip and of each stick.
        let moment = 1e-6;
        plant.advance(&[0.0], first / case.pull - moment).unwrap();
        for turn in 1..=5 {
            assert!(plant.sticks(0)[1], "still sticks before breakaway {turn}");
            plant.advance(&[0.0], slip).unwrap();
            assert!(!plant.sticks(0)[1], "still slips {turn}");
            plant.advance(&[0.0], 2.0 * moment).unwrap();
            assert!(plant.sticks(0)[1], "sticks after slip {turn}");
            let strokes = f64::from(turn) * stroke;
            error = error.max(assert_near("stroke [rad]", plant.states()[0].link_position, strokes, EXACT));
            plant.advance(&[0.0], stick - 2.0 * moment).unwrap();
        }
    });
    exactness::says("t_stick = 2 (F_S − F_C)/(k V) where friction falls at once |", &[error]);
}

/// A weight on a spindle that drives the motor backwards. Friction F of the motor holds it up to `m g = F`; beyond that both
/// move with `a = (m g − F)/(m + J)`. With friction that grows with the load, `F + μ T`, it is `T = m (g − a)` and
/// `a = ((1 − μ) m g − F)/(J + (1 − μ) m)`, which is the efficiency `1 − μ` of a gear driven backwards.
#[test]
fn analytic_weight_on_a_gear_driven_backwards() {
    let (m, j, g, k) = (3.0, 5.0, 9.81, 2e5);
    for (level, mu) in [(0.9, 0.0), (0.999, 0.0), (1.001, 0.0), (0.5, 0.0), (0.5, 0.4), (0.5, 0.51)] {
        let level = level * m * g;
        let joint = JointModel {
            rotor_inertia: Some(j),
            gear_stiffness: Some(k),
            gear_damping: Some(0.0),
            friction: Some(friction(level, level, 1.0, 0.0, 0.0)),
            ..plain_joint("joint1")
        };
        let mut model = model(slide(m, Vector3::z()), vec![joint]);
        if mu > 0.0 {
            model.effects.push(EffectEntry {
                effect: "load_dependent_friction".to_owned(),
                joint: Some("joint1".to_owned()),
                parameters: [("coefficient".to_owned(), mu)].into(),
            });
        }
        let acceleration = (((1.0 - mu) * m * g - level) / (j + (1.0 - mu) * m)).max(0.0);
        on_both_engines(&model, |mut plant| {
            // Wound up as the motion needs it: nothing swings.
            let windup = m * (g - acceleration) / k;
            plant.launch(&[JointState { link_position: -windup, ..JointState::default() }]);
            let seconds = if acceleration > 0.0 { 1.0 } else { 60.0 };
            plant.advance(&[0.0], seconds).unwrap();
            let fallen = -plant.states()[0].motor_position;
            println!("friction {level:.2} N + {mu} T: fallen {fallen:e} m");
            if acceleration > 0.0 {
                assert_near("fallen", fallen, 0.5 * acceleration * seconds * seconds, EXACT);
            } else {
                assert_eq!(fallen, 0.0, "it sticks, and nothing creeps");
            }
        });
    }
}

/// A joint lets go at the torque of its law, in both directions, and rotor and link each at their share of it.
#[test]
fn analytic_breakaway_at_the_torque_of_the_law() {
    let lines = |a1: f64| Lines { a1, b1: -2.0, a2: 0.7 * a1, b2: 0.4 };
    let laws = [
        friction(0.4, 0.5, 0.03, 0.4, 0.3),
        Friction { law: FrictionLaw::TwoLines([lines(0.5), lines(0.6)]), link_share: 0.3 },
    ];
    let mut error = 0.0_f64;
    for friction in laws {
        for direction in [Direction::Positive, Direction::Negative] {
            let level = friction.law.magnitude(direction, 0.0);
            let joint = JointModel { friction: Some(friction), ..plain_joint("joint1") };
            on_both_engines(&model(turntable(0.05), vec![joint]), |mut plant| {
                // A ramp of two seconds to breakaway, so slow that inertia is of no account.
                let step = 2.5e-5 * level;
                let mut torque = 0.0;
                let mut rotor_at = None;
                while plant.sticks(0)[1] && torque < 2.0 * level {
                    torque += step;
                    plant.advance(&[direction.sign() * torque], 5e-5).unwrap();
                    if rotor_at.is_none() && !plant.sticks(0)[0] {
                        rotor_at = Some(torque);
                    }
                }
                let share = friction.link_share;
                let rotor_at = rotor_at.expect("the rotor moves first");
                let of_rotor = assert_near("rotor lets go at", rotor_at / ((1.0 - share) * level), 1.0, 1e-3);
                let gear = direction.sign() * plant.states()[0].gear_torque;
                let of_link = assert_near("link lets go at", gear / (share * level), 1.0, 1e-3);
                error = error.max(of_rotor).max(of_link);
            });
        }
    }
    exactness::says("| at their shares of F_S | within", &[100.0 * error]);
}

/// At nine tenths of the breakaway torques of rotor and link, both joints of the arm at once: a minute of nothing.
#[test]
fn property_nothing_creeps_in_a_minute() {
    let model = scara();
    on_both_engines(&model, |mut plant| {
        let at_rest: Vec<JointState> = (model.joints.iter().zip([1.0, -1.0]))
            .map(|(joint, sign)| {
                let friction = joint.friction.unwrap();
                let level = 0.9 * friction.law.magnitude(Direction::Positive, 0.0);
                let windup = friction.link_share * level / joint.gear_stiffness.expect("a gear");
                JointState {
                    motor_position: sign * (0.5 * joint.backlash.unwrap() + windup),
                    current: sign * level / joint.torque_per_ampere(),
                    ..JointState::default()
                }
            })
            .collect();
        plant.launch(&at_rest);
        let command: Vec<f64> = at_rest.iter().map(|state| state.current).collect();
        plant.advance(&command, 60.0).unwrap();
        for (state, start) in plant.states().iter().zip(&at_rest) {
            let crept = (state.motor_position - start.motor_position).abs().max(state.link_position.abs());
            assert_near("crept [rad]", crept, 0.0, 1e-9);
        }
    });
}
