//! Compensation of friction and gap: its laws against closed forms, and the tracking that it makes possible on the paper's arm.

use std::path::{Path, PathBuf};

use lostmotion::control::{Compensation, Feedforward, KnownGear, Target};
use lostmotion::gearhead::{Direction, Exponential, FrictionLaw};
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::Model;
use lostmotion::scenario::{Found, Keep, Regulator, Scenario, Timing, Tracking, closed_loop, simulate_keeping};
use lostmotion::timeseries::Channel;

/// [s] Control period.
const PERIOD: f64 = 1e-3;
/// `b` [rad], `T` [s], share of the link, `J` [kg·m²].
const BACKLASH: f64 = 0.008;
const CROSSING: f64 = 0.06;
const SHARE: f64 = 0.3;
const ROTOR: f64 = 0.024;

fn law() -> FrictionLaw {
    let positive = Exponential { coulomb: 0.27, breakaway: 0.46, stribeck_velocity: 0.026, viscous: 0.6 };
    FrictionLaw::Exponential([positive, Exponential { coulomb: 0.29, breakaway: 0.44, ..positive }])
}

fn compensation() -> Compensation {
    let law = law();
    Compensation::new(KnownGear {
        friction: Box::new(move |velocity| law.kinetic(velocity)),
        link_share: SHARE,
        backlash: BACKLASH,
        rotor_inertia: ROTOR,
        crossing_time: CROSSING,
    })
}

fn moving(velocity: f64, acceleration: f64) -> Target {
    Target { position: 0.0, velocity, acceleration, ..Target::default() }
}

/// After so many calls with one target and one torque of the links.
fn held(compensation: &mut Compensation, target: Target, rigid: f64, calls: usize) -> Feedforward {
    (0..calls).map(|_| compensation.advance(&target, rigid, PERIOD)).last().unwrap()
}

/// Calls that a crossing takes, and some.
const SETTLED: usize = 70;

#[test]
fn analytic_at_constant_velocity_the_feedforward_is_the_friction() {
    for velocity in [-0.2, -0.01, 0.003, 0.15] {
        let found = held(&mut compensation(), moving(velocity, 0.0), 0.0, SETTLED);
        // Two products of shares that sum to one: rounding.
        assert!((found.torque - law().kinetic(velocity)).abs() < 1e-15, "{velocity}: {found:?}");
        assert_eq!(found.shift_velocity, 0.0);
        // The link's friction alone loads the gear: the motor leads by half the gap in the direction of motion.
        assert!((found.shift - 0.5 * BACKLASH * velocity.signum()).abs() < 1e-15);
    }
}

#[test]
fn analytic_the_motor_leads_on_the_side_of_the_torque_not_of_the_velocity() {
    let link = SHARE * law().magnitude(Direction::Positive, 0.1);
    // Braked more gently than by its own friction, the link still has to be pushed; braked harder, it has to be held back.
    for (rigid, side) in [(-0.9 * link, 1.0), (-1.1 * link, -1.0)] {
        let found = held(&mut compensation(), moving(0.1, -0.05), rigid, SETTLED);
        assert!((found.shift - side * 0.5 * BACKLASH).abs() < 1e-15, "{rigid}: {found:?}");
    }
}

#[test]
fn analytic_at_rest_nothing_is_fed_forward_and_the_flank_stays() {
    let breakaway = SHARE * law().magnitude(Direction::Positive, 0.0);
    let mut one = compensation();
    held(&mut one, moving(-0.1, 0.0), 0.0, SETTLED);
    // Gravity within the link's own friction does not move it to the other flank.
    let rest = held(&mut one, moving(0.0, 0.0), 0.9 * breakaway, SETTLED);
    assert_eq!((rest.torque, rest.shift_velocity), (0.0, 0.0));
    assert!((rest.shift + 0.5 * BACKLASH).abs() < 1e-15);
    let pulled = held(&mut one, moving(0.0, 0.0), 1.5 * breakaway, SETTLED);
    assert!((pulled.shift - 0.5 * BACKLASH).abs() < 1e-15);
    // A controller that begins at rest knows no flank: no shift.
    assert_eq!(held(&mut compensation(), moving(0.0, 0.0), 0.0, SETTLED), Feedforward::default());
}

#[test]
fn property_a_crossing_takes_its_time_and_its_velocity_is_its_derivative() {
    let mut one = compensation();
    held(&mut one, moving(-0.1, 0.0), 0.0, SETTLED);
    let crossing: Vec<Feedforward> = (0..SETTLED).map(|_| one.advance(&moving(0.1, 0.0), 0.0, PERIOD)).collect();
    let end = crossing.iter().position(|one| (one.shift - 0.5 * BACKLASH).abs() < 1e-15).unwrap();
    // The first call begins it, and 60 periods later it has ended; the last steps of a fifth-order end are below rounding.
    assert!((58..=60).contains(&end), "{end}");
    for three in crossing.windows(3) {
        let slope = (three[2].shift - three[0].shift) / (2.0 * PERIOD);
        // Central difference: dt²/6 · s‴, s‴ ≤ 60 b/T³.
        assert!((slope - three[1].shift_velocity).abs() <= PERIOD * PERIOD * 10.0 * BACKLASH / CROSSING.powi(3));
    }
}

#[test]
fn property_the_rotor_s_part_follows_the_rotor_and_the_link_s_part_the_link() {
    let mut one = compensation();
    held(&mut one, moving(0.02, 0.0), 0.0, SETTLED);
    // Braking sends the rotor backwards through the gap while the link moves on.
    let braking = moving(0.02, -1.0);
    let middle = held(&mut one, braking, -1.0, 31);
    assert!(middle.shift_velocity < -0.2, "{middle:?}");
    let law = law();
    let friction = (1.0 - SHARE) * law.kinetic(0.02 + middle.shift_velocity) + SHARE * law.kinetic(0.02);
    // Half-way the crossing does not accelerate; one call of 60 off, it does by 60·½·½/30 b/T² at most.
    assert!((middle.torque - friction).abs() < ROTOR * 60.0 * 0.25 / 30.0 * BACKLASH / (CROSSING * CROSSING));
}

fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).join("scenario.toml")
}

fn file() -> PathBuf {
    scenario("14_compensate_scara")
}

/// A scenario carried out with this seed: its tracking, and the expectations that failed.
fn carried_out(file: &Path, set: &[&str], seed: u64) -> (Tracking, Vec<String>) {
    let set: Vec<String> = set.iter().map(|&one| one.to_owned()).collect();
    let scenario = Scenario::load(file, &set).unwrap();
    let run = simulate_keeping(Keep::Measured, &scenario, seed, &|_, _| {}).unwrap();
    let conclusion = scenario.carry_out(&run, &mut |_, _| {}).unwrap();
    let Found::Compensated(compensated) = conclusion.found else { panic!("not compensated") };
    (compensated.tracking, conclusion.unmet)
}

/// The scenario's file holds the promised figures: 44 and 36 % less error as published, nine tenths of what the true values reach, half more
/// variation of current, no cycle of an encoder count at rest. Seeds that nothing was chosen on.
#[test]
fn scenario_compensation_reaches_the_published_share_on_four_seeds() {
    for seed in [401, 402, 403, 404] {
        let (tracking, unmet) = carried_out(&file(), &[], seed);
        assert!(unmet.is_empty(), "seed {seed}: {unmet:#?}");
        for joint in &tracking.joints {
            println!(
                "seed {seed} {}: {:.4}° → {:.4}° ({:.1} %), share {:.1} %, variation {:+.1} %",
                joint.joint,
                joint.without.figures.mean_error.to_degrees(),
                joint.with.figures.mean_error.to_degrees(),
                joint.reduction_percent(),
                joint.share_percent(),
                joint.variation_percent()
            );
            // Four fifths is what was reached with room for other seeds: the worst of ten had 85 % when this was written.
            assert!(joint.reduction_percent() > 80.0, "{joint:?}");
        }
    }
}

/// Six joints under gravity, as the scenario expects of them.
#[test]
fn scenario_compensation_helps_every_joint_of_an_arm_under_gravity() {
    let (tracking, unmet) = carried_out(&scenario("15_compensate_sixaxis"), &[], 1);
    assert!(unmet.is_empty(), "{unmet:#?}");
    assert_eq!(tracking.joints.len(), 6);
}

/// With so loose a limit on the velocity error the rotor hammers in its gap, also at rest: the figure shows it.
#[test]
fn scenario_a_limit_cycle_at_rest_is_seen() {
    let (_, unmet) = carried_out(&file(), &["controller.joints.joint1.velocity_error_limit=0.2"], 1);
    assert!(unmet.iter().any(|unmet| unmet.contains("joint1: most_rest_amplitude")), "{unmet:#?}");
}

/// Mean absolute error of the links of joints 1 and 2 [rad] on the scenario's motion, with this model's friction and gaps compensated.
fn tracked(known: Option<&Model>) -> [f64; 2] {
    let scenario = Scenario::load(&file(), &[]).unwrap();
    let plan = scenario.tracking.as_ref().unwrap();
    let mut plant = Plant::new(&machine(), &Options { seed: 7, ..scenario.options.clone() }).unwrap();
    plant.place(&plan.session.profile.start());
    let mut regulator = Regulator::new(&scenario.model, &scenario.controller, PERIOD);
    if let Some(known) = known {
        regulator.compensate(known, plan.crossing_time);
    }
    let timing = Timing { period: PERIOD, duration: plan.session.duration };
    let profile = &plan.session.profile;
    let run = closed_loop(&mut plant, &mut regulator, profile, timing, Keep::Everything, &mut |_| {}).unwrap();
    let (series, _) = run.finish("tracking", &scenario.model);
    [0, 1].map(|joint| {
        let channel = |channel| series.joints[joint].get(channel).unwrap();
        let pairs = channel(Channel::TrueLinkPosition).iter().zip(channel(Channel::ReferencePosition));
        pairs.map(|(link, reference)| (link - reference).abs()).sum::<f64>() / series.len() as f64
    })
}

/// The simulated arm, all of it known.
fn machine() -> Model {
    Model::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/scara/model.toml")).unwrap()
}

/// The arm with its friction multiplied.
fn with_friction(factor: f64) -> Model {
    let mut model = machine();
    for joint in &mut model.joints {
        if let Some(FrictionLaw::Exponential(laws)) = joint.friction.as_mut().map(|friction| &mut friction.law) {
            for law in laws {
                law.coulomb *= factor;
                law.breakaway *= factor;
                law.viscous *= factor;
            }
        }
    }
    model
}

#[test]
fn property_wrong_friction_is_worse_than_none_and_each_part_helps() {
    let without = tracked(None);
    let exact = tracked(Some(&machine()));
    let wrong_sign = tracked(Some(&with_friction(-1.0)));
    let doubled = tracked(Some(&with_friction(2.0)));
    let mut no_gap = machine();
    no_gap.joints.iter_mut().for_each(|joint| joint.backlash = None);
    let friction_alone = tracked(Some(&no_gap));
    let mut inverted = machine();
    inverted.joints.iter_mut().for_each(|joint| joint.backlash = joint.backlash.map(|gap| -gap));
    let gap_inverted = tracked(Some(&inverted));
    for joint in [0, 1] {
        assert!(wrong_sign[joint] > 2.0 * without[joint], "{wrong_sign:?} {without:?}");
        // As much too much as there was too little before.
        assert!(doubled[joint] > 5.0 * exact[joint], "{doubled:?} {exact:?}");
        assert!(friction_alone[joint] < without[joint], "{friction_alone:?} {without:?}");
        // Without the inverse of the gap the link is half a gap off: 0.23° and 0.17°.
        assert!(exact[joint] < 0.6 * friction_alone[joint], "{exact:?} {friction_alone:?}");
        assert!(gap_inverted[joint] > 1.5 * friction_alone[joint], "{gap_inverted:?} {friction_alone:?}");
    }
}
