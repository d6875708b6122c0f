//! A machine drawn by seed: the six-joint arm of the catalogue with links, friction and gaps of its own.
//!
//! Links scatter as nominal values of the default accuracy do, friction, rotors and gaps within factors of 1.25 to 1.5.

use lostmotion::drive::VelocitySensor;
use lostmotion::dynamics::Dynamics;
use lostmotion::gearhead::{Exponential, FrictionLaw};
use lostmotion::robot::{Accuracy, Model};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::hidden::Host;
use super::machine::{Friction, around};
use super::motion::Space;
use super::record::Gains;
use super::six_joints::{RANGES, symmetric};
use super::strengths::{JointSizes, Payload};

/// [s] of the filtered differences that a drive takes for the velocity.
const VELOCITY_FILTER: f64 = 0.01;

/// The arm.
#[derive(Debug)]
pub struct SixJoints {
    /// The machine that moves.
    pub truth: Model,
    /// As in [`Machine`](super::machine::Machine).
    friction_unknown: bool,
    guess: [[f64; 2]; 6],
}

impl SixJoints {
    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        let catalogue = Model { accuracy: Accuracy::default(), ..symmetric() };
        let of_links: Vec<f64> =
            (0..10 * catalogue.robot.bodies.len()).map(|_| StandardNormal.sample(&mut *rng)).collect();
        let mut truth = Model { accuracy: Accuracy::EXACT, ..catalogue.deviating(&of_links) };
        let share = rng.random_range(0.1..0.5);
        for joint in &mut truth.joints {
            joint.rotor_inertia = joint.rotor_inertia.map(|inertia| around(rng, inertia, 1.25));
            joint.backlash = joint.backlash.map(|gap| around(rng, gap, 1.5));
            joint.velocity_sensor = Some(VelocitySensor::LowPass(VELOCITY_FILTER));
            let Some(friction) = &mut joint.friction else { continue };
            friction.link_share = share;
            if let FrictionLaw::Exponential(sides) = &mut friction.law {
                let coulomb = around(rng, sides[0].coulomb, 1.25);
                *sides = [Exponential {
                    coulomb,
                    breakaway: coulomb * around(rng, 1.18, 1.08),
                    stribeck_velocity: around(rng, sides[0].stribeck_velocity, 1.25),
                    viscous: around(rng, sides[0].viscous, 1.25),
                }; 2];
            }
        }
        let guess = [(); 6].map(|()| [(); 2].map(|()| rng.random_range(0.7..1.3)));
        let mut drawn = Self { truth, friction_unknown: true, guess };
        if rng.random_bool(0.25) {
            drawn.know_friction();
        }
        drawn
    }

    /// The exact model without gaps and effects, with friction as far as it is known.
    pub fn nominal(&self) -> Model {
        let mut nominal = self.truth.clone();
        for (joint, [dry, wet]) in nominal.joints.iter_mut().zip(self.guess) {
            joint.backlash = None;
            joint.friction = joint.friction.filter(|_| !self.friction_unknown);
            if let Some(FrictionLaw::Exponential(sides)) = joint.friction.as_mut().map(|friction| &mut friction.law) {
                for side in sides {
                    side.coulomb *= dry;
                    side.breakaway = side.coulomb;
                    side.viscous *= wet;
                }
            }
        }
        nominal
    }

    /// Where the joints move.
    pub fn spaces() -> Vec<Space> {
        RANGES.map(|[middle, half, ..]| Space { middle, half }).into()
    }

    /// The controllers, that hold the arm at rest in this pose [rad].
    pub fn gains(&self, pose: &[f64]) -> Vec<Gains> {
        let mut held = vec![0.0; pose.len()];
        let rest = vec![0.0; pose.len()];
        Dynamics::new(&self.truth.robot).inverse(pose, &rest, &rest, &mut held);
        let gains = |(index, held): (usize, f64)| {
            let joint = &self.truth.joints[index];
            let [.., inertia] = RANGES[index];
            let friction = self.sizes(index).friction;
            let torque_per_ampere = joint.torque_per_ampere();
            Gains {
                proportional: 30.0 * inertia,
                integral: 300.0 * inertia,
                integral_limit: joint.amplifier.current_limit * torque_per_ampere,
                inertia,
                coulomb: 0.7 * friction.coulomb,
                viscous: 0.5 * friction.viscous,
                held,
                torque_per_ampere,
            }
        };
        held.into_iter().enumerate().map(gains).collect()
    }
}

impl Host for SixJoints {
    fn joints(&self) -> Vec<String> {
        self.truth.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// The strengths of the planar arm, as shares of Coulomb friction.
    fn sizes(&self, joint: usize) -> JointSizes {
        let [middle, half, ..] = RANGES[joint];
        let joint = &self.truth.joints[joint];
        let friction = joint.friction.expect("friction");
        let FrictionLaw::Exponential([side, _]) = friction.law else { unreachable!("drawn as an exponential law") };
        let coulomb = side.coulomb;
        let current = coulomb / joint.torque_per_ampere();
        JointSizes {
            gear_ratio: joint.gear_ratio,
            rotor_inertia: joint.reflected_inertia(),
            backlash: joint.backlash.unwrap_or(0.0),
            friction: Friction {
                coulomb,
                breakaway: side.breakaway,
                stribeck_velocity: side.stribeck_velocity,
                viscous: side.viscous,
            },
            link_share: friction.link_share,
            middle,
            reach: half / Space::PLANAR[0].half,
            cable: 0.4 * coulomb,
            contact: 6.0 * coulomb,
            drag: 0.36 * coulomb,
            disturbance: 0.2 * coulomb,
            offset: 0.15 * current,
            dead_band: 0.13 * current,
            // A soft gear bends by ten times as much as the gear of the catalogue.
            soft: 0.1 * joint.gear_stiffness.unwrap_or(f64::INFINITY),
            // Of a torque of gravity that is ten times the friction.
            load_friction: 0.03,
        }
    }

    /// A third of the last link with its tool, in the hand.
    fn payload(&self) -> Payload {
        Payload { mass: 1.2, x: 0.08, z: 0.02 }
    }

    fn know_friction(&mut self) {
        self.friction_unknown = false;
        for friction in self.truth.joints.iter_mut().filter_map(|joint| joint.friction.as_mut()) {
            if let FrictionLaw::Exponential(sides) = &mut friction.law {
                sides.iter_mut().for_each(|side| side.breakaway = side.coulomb);
            }
        }
    }
}
