//! From a model to a machine.

use nalgebra::DMatrix;

use super::accuracy::Lull;
use super::contact::{Barrier, Barriers, Cause};
use super::coupled::Coupled;
use super::integrator::Integrator;
use super::joint::{JointLaws, Phase, Power};
use super::links::Links;
use super::machine::Machine;
use super::mode::Mode;
use super::obstacle::Obstacle;
use super::pace::LONGEST_STEP_DAMPED;
use super::rigid_body::{OnAxes, RigidBody};
use super::sensors::Sensors;
use super::state::State;
use super::world::Pair;
use super::{Engine, Evaluations, Options, Plant, World};
use crate::drive::PowerStage;
use crate::dynamics::Dynamics;
use crate::effects::{Action, Catalogue, JointState, Reading, Stop, install_listed};
use crate::error::{Error, Place, Result};
use crate::gearhead::{DeadZone, Gearhead, Grip, Memory, Slip};
use crate::robot::{Body, JointModel, Model};

/// [rad/s] Fastest motion of a gear that is simulated: 3 µs a step.
pub(super) const FASTEST: f64 = 1e5;

impl Plant {
    /// Builds the machine of a model, with its effects installed, at rest at zero.
    ///
    /// # Errors
    /// An effect is unknown or its parameters do not fit; a gear is too fast to be simulated. The error gives the line of the model file,
    /// if any.
    pub fn new(model: &Model, options: &Options) -> Result<Self> {
        Self::build(model, options).map_err(|error| model.places.locate(error))
    }

    fn build(model: &Model, options: &Options) -> Result<Self> {
        let mut plant = Self::unpaced(model, options)?;
        let (joint, fastest) = plant.integrator.machine.fastest();
        let pole = fastest.pole();
        if !is_followed(pole) {
            return Err(too_fast(model, joint, pole));
        }
        let asked = options.substeps.max(1) as f64 / options.step;
        plant.fastest = pole;
        let longest_step = options.accuracy.longest_step();
        plant.rate = asked.max(fastest.oscillation / longest_step).max(fastest.decay / LONGEST_STEP_DAMPED);
        Ok(plant)
    }

    /// The joint whose gear is too fast to be simulated, if there is one.
    pub(super) fn too_fast(model: &Model) -> Result<Option<usize>> {
        let (joint, fastest) = Self::unpaced(model, &Options::default())?.integrator.machine.fastest();
        Ok((!is_followed(fastest.pole())).then_some(joint))
    }

    /// The machine before its steps are chosen.
    fn unpaced(model: &Model, options: &Options) -> Result<Self> {
        let mut model = model.clone();
        let actions = install(&mut model, &options.catalogue)?;
        let mut laws = laws(&model);
        let mut sensors: Vec<Sensors> = (model.joints.iter().enumerate())
            .map(|(i, joint)| Sensors::new(joint, options.ideal_sensors, options.seed, i as u64))
            .collect();
        let mut barriers = end_stops(&model);
        for (number, action) in actions {
            put(number, action, &model, &mut laws, &mut sensors, &mut barriers)?;
        }
        let n = laws.len();
        let links = match options.engine {
            Engine::Rapier => {
                let mut world = World::new(&model.robot);
                barriers.extend(put_obstacles(&mut world, &model, &options.obstacles)?);
                let engine: Box<dyn RigidBody> = match &model.robot.coupling {
                    Some(coupling) => Box::new(OnAxes::new(world, coupling.clone())),
                    None => Box::new(world),
                };
                match options.evaluations {
                    Evaluations::AsNeeded => {
                        Links::carried(engine, Dynamics::new(&model.robot), options.accuracy.confirmation())
                    }
                    Evaluations::EveryInterval | Evaluations::EveryStage => Links::asked(engine),
                }
            }
            Engine::Reduced if options.obstacles.is_empty() => Links::asked(Box::new(Dynamics::new(&model.robot))),
            Engine::Reduced => {
                let expected = "the engine rapier: no other engine supports obstacles";
                return Err(Error::input(&model.source, Place::File, "engine", "reduced", expected));
            }
        };
        let state = State {
            time: 0.0,
            joints: vec![Phase::default(); n],
            modes: laws.iter().map(resting_mode).collect(),
            touching: vec![false; barriers.len()],
            done: Power::default(),
        };
        let mut plant = Self {
            integrator: Integrator::new(
                Machine::new(Coupled::new(laws, Barriers::new(barriers, &model.robot), &model.robot), links),
                options.most_steps,
            ),
            robot: model.robot.clone(),
            step: options.step,
            rate: 0.0,
            fastest: 0.0,
            no_surprise: options.accuracy.no_surprise(),
            lull: Lull::new(n, options),
            calm: false,
            every_stage: options.evaluations == Evaluations::EveryStage,
            asked: 0.0,
            saved: state.clone(),
            saved_trackers: sensors.iter().map(|sensors| sensors.tracker).collect(),
            sensors,
            state,
            commands: vec![0.0; n],
            states: vec![JointState::default(); n],
            readings: vec![Reading::default(); n],
        };
        plant.place(&vec![0.0; n]);
        if plant.integrator.machine.slow_dampers() {
            plant.place(&vec![0.0; n]);
        }
        Ok(plant)
    }
}

/// Whether a simulation follows the fastest motion of gears [rad/s].
fn is_followed(pole: f64) -> bool {
    pole.is_finite() && pole <= FASTEST
}

/// Installs an action of the effect with this number in the list, counted from 1.
fn put(
    number: usize,
    action: Action,
    model: &Model,
    laws: &mut [JointLaws],
    sensors: &mut [Sensors],
    barriers: &mut Vec<Barrier>,
) -> Result<()> {
    match action {
        Action::Joint(joint, action) => {
            laws[joint].actions.push(action);
            laws[joint].plain = false;
            if model.joints[joint].friction.is_none() {
                laws[joint].gearhead.rotor.share = 1.0;
            }
        }
        Action::Gear(joint, action) => {
            laws[joint].gears.push(action);
            laws[joint].plain = false;
        }
        Action::Friction(joint, memory) => {
            if laws[joint].gearhead.memory.replace(memory).is_some() {
                let (key, name) = (format!("effects[{number}].effect"), &model.effects[number - 1].effect);
                let expected = format!(
                    "one of presliding and dwell_stiction on {}, not both: its friction has only one memory",
                    model.joints[joint].name
                );
                return Err(Error::input(&model.source, Place::File, key, name, expected));
            }
            laws[joint].plain = false;
        }
        Action::Drive(joint, action) => laws[joint].drives.push(action),
        Action::Encoder(joint, action) => sensors[joint].push_before(action),
        Action::Sensor(joint, action) => sensors[joint].push(action),
        Action::Stop(joint, Stop { side, place, stiffness, damping }) => {
            let cause = Cause::EndStop(joint, side, place);
            barriers.push(Barrier::new(cause, stiffness, damping, &model.robot));
        }
    }
    Ok(())
}

/// Stops at the ends of the joints' ranges, where the model has them.
fn end_stops(model: &Model) -> Vec<Barrier> {
    let mut stops = Vec::new();
    for (i, (joint, body)) in model.joints.iter().zip(&model.robot.bodies).enumerate() {
        let Some((stiffness, damping)) = joint.end_stop() else { continue };
        let limits = body.joint.limits;
        for (side, place) in [(1.0, limits.upper), (-1.0, limits.lower)] {
            if place.is_finite() {
                stops.push(Barrier::new(Cause::EndStop(i, side, place), stiffness, damping, &model.robot));
            }
        }
    }
    stops
}

fn put_obstacles(world: &mut World, model: &Model, obstacles: &[Obstacle]) -> Result<Vec<Barrier>> {
    if obstacles.is_empty() {
        return Ok(Vec::new());
    }
    let pairs = world.put_obstacles(&model.robot, obstacles)?;
    let barrier = |(index, pair): (usize, &Pair)| {
        let Obstacle { stiffness, damping, .. } = obstacles[pair.obstacle];
        Barrier::new(Cause::Pair(index, pair.body, pair.obstacle), stiffness, damping, &model.robot)
    };
    Ok(pairs.iter().enumerate().map(barrier).collect())
}

/// The actions of a model's effects, each with the effect's number in the list, counted from 1.
fn install(model: &mut Model, catalogue: &Catalogue) -> Result<Vec<(usize, Action)>> {
    let mut actions = Vec::new();
    for (number, entry) in (1..).zip(model.effects.clone()) {
        let acting = install_listed(model, number, &entry, catalogue)?;
        actions.extend(acting.into_iter().map(|action| (number, action)));
    }
    Ok(actions)
}

/// The laws of all joints. Unknown values of gears and rotors are computed from the links with all joints at zero; the plant's steps are
/// chosen in the same posture.
fn laws(model: &Model) -> Vec<JointLaws> {
    let n = model.joints.len();
    let mut mass = DMatrix::zeros(n, n);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; n], &mut mass);
    // Links without inertia make no finite W: the plant is refused once its fastest motion is known.
    let mobility = mass.clone().cholesky().map(|cholesky| cholesky.inverse());
    let of_joint = |(i, (joint, body)): (usize, (&JointModel, &Body))| {
        let rotor_inertia = joint.rotor_beside(mass[(i, i)]);
        let of_link = mobility.as_ref().map_or(f64::INFINITY, |w| w[(i, i)]);
        let (inertia, mobility) = (rotor_inertia + mass[(i, i)], 1.0 / rotor_inertia + of_link);
        let dead_zone = joint.flanks(joint.backlash.unwrap_or(0.0), inertia, mobility);
        let mut laws = laws_of(joint, &body.joint, rotor_inertia, dead_zone);
        if model.robot.coupling.is_some() {
            (laws.link_damping, laws.moves_joint) = (0.0, false);
        }
        laws
    };
    model.joints.iter().zip(&model.robot.bodies).enumerate().map(of_joint).collect()
}

/// The error of a gear that is too fast for any step. It names a value of the gear that the model file gives.
fn too_fast(model: &Model, joint: usize, pole: f64) -> Error {
    let own = &model.joints[joint];
    let given = [
        ("gear_stiffness", own.gear_stiffness),
        ("gear_damping", own.gear_damping),
        ("rotor_inertia", own.rotor_inertia),
    ];
    let known = given.iter().find_map(|(key, value)| Some((format!(".{key}"), value.as_ref()?.to_string())));
    let (key, value) = known.unwrap_or_default();
    let expected = format!(
        "a gear between rotor and link whose fastest motion is below {FASTEST:.0} rad/s, with inertia on both sides \
         (here {pole:.3e} rad/s)"
    );
    Error::input(&model.source, Place::File, format!("joints.{}{key}", own.name), value, expected)
}

/// The laws of a joint. The rotor has its share of the friction; if there is none, effects may still add some.
fn laws_of(joint: &JointModel, link: &crate::robot::Joint, rotor_inertia: f64, dead_zone: DeadZone) -> JointLaws {
    JointLaws {
        rotor_inertia,
        power: PowerStage::new(joint.motor.as_ref(), &joint.amplifier, joint.torque_per_ampere()),
        gearhead: Gearhead::new(dead_zone, joint.friction.as_ref(), link.friction),
        link_damping: link.damping,
        actions: Vec::new(),
        gears: Vec::new(),
        drives: Vec::new(),
        plain: true,
        moves_joint: true,
    }
}

fn resting_mode(law: &JointLaws) -> Mode {
    let slip = |grip: &Grip| if grip.holds() { Slip::Stuck } else { Slip::Free };
    // Bristles yield before they slip: nothing sticks.
    let bristles = matches!(law.gearhead.memory, Some(Memory::Bristles { .. }));
    Mode {
        contact: i8::from(law.gearhead.dead_zone.backlash == 0.0),
        rotor: if bristles { Slip::Free } else { slip(&law.gearhead.rotor) },
        link: slip(&law.gearhead.link),
        saturation: 0,
    }
}

/// The modes of a joint in a motion: a side at rest sticks if friction holds it.
pub(super) fn moving_mode(law: &JointLaws, time: f64, y: &Phase) -> Mode {
    let resting = resting_mode(law);
    let way = |slip: Slip, grip: &Grip, velocity: f64| match slip {
        Slip::Stuck if velocity != 0.0 => grip.slip(velocity),
        slip => slip,
    };
    Mode {
        contact: law.contact(time, y),
        rotor: way(resting.rotor, &law.gearhead.rotor, y.omega),
        link: way(resting.link, &law.gearhead.link, y.v),
        ..resting
    }
}
