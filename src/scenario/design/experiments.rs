//! Possible experiments of a machine, as texts of scenario files.
//!
//! Every joint keeps within its [`Reach`].

use std::fmt::Write as _;

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::effects::Experiment;
use crate::files::is_fit_name;
use crate::robot::{Load, Model};
use crate::scenario::reach::{Reach, reaches};
use crate::toml_input::{written_key, written_text};

/// Kinds of experiment, one or several in sequence, with a length.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The kinds.
    pub parts: Vec<Experiment>,
    /// [1] Length, in units of the shorter one.
    pub length: f64,
}

impl Plan {
    /// Whether it includes that kind; an experiment with an added mass includes fast motion.
    pub fn holds(&self, kind: Experiment) -> bool {
        self.parts.iter().any(|part| *part == kind || (*part == Experiment::AddedMass && kind == Experiment::Fast))
    }
}

/// The candidates, roughly from short to long.
pub fn plans() -> Vec<Plan> {
    use Experiment::{AddedMass, AtRest, Fast, OneByOne, SlowSteps, WideRange};
    let kinds: [&[Experiment]; 10] = [
        &[AddedMass],
        &[AtRest, SlowSteps],
        &[Fast],
        &[WideRange],
        &[OneByOne],
        &[SlowSteps],
        &[Fast, WideRange],
        &[Fast, SlowSteps],
        &[AddedMass, SlowSteps],
        &[Fast, OneByOne, WideRange, SlowSteps],
    ];
    let of_length = |length: f64| kinds.iter().map(move |parts| Plan { parts: parts.to_vec(), length });
    of_length(1.0).chain(of_length(2.0)).collect()
}

/// A known mass at the centre of mass of the last body. It is so heavy that the inertia of the joint that feels it most
/// grows by half, but no joint needs more than a quarter of its effort to hold it with the arm at q = 0.
fn added_mass(model: &Model, session: &str) -> Load {
    let dof = model.joints.len();
    let position = model.robot.bodies.last().map_or([0.0; 3], |body| body.inertia.com.into());
    let unit = Load { session: session.to_owned(), mass: 1.0, position };
    let loaded = Model { loads: vec![unit.clone()], ..model.clone() };
    let Some(alone) = loaded.load_in(session) else { return unit };
    let [own, added] = [&model.robot, &alone].map(|robot| {
        let mut mass = DMatrix::zeros(dof, dof);
        Dynamics::new(robot).mass_matrix(&vec![0.0; dof], &mut mass);
        mass
    });
    let still = vec![0.0; dof];
    let mut weight = vec![0.0; dof];
    Dynamics::new(&alone).inverse(&still, &still, &still, &mut weight);
    let bearable = |index: usize| {
        let inertia = own[(index, index)] + model.joints[index].reflected_inertia();
        let effort = model.robot.bodies[index].joint.limits.effort;
        (0.5 * inertia / added[(index, index)]).min(0.25 * effort / weight[index].abs())
    };
    let mass = (0..dof).map(bearable).filter(|mass| mass.is_finite()).fold(f64::INFINITY, f64::min);
    // Three digits, which is the precision of weighing.
    let digits = 10f64.powf(2.0 - mass.log10().floor());
    if mass.is_finite() && mass > 0.0 { Load { mass: (mass * digits).floor() / digits, ..unit } } else { unit }
}

/// The scenario file of a plan; `robot` is the path of the model file.
pub fn scenario_text(model: &Model, plan: &Plan, robot: &str, name: &str, question: &str) -> String {
    let reaches = reaches(model);
    let mut text = format!(
        "# Written by `lostmotion design`.\nschema = \"lostmotion/scenario/1\"\nname = {}\nquestion = {}\n\
         robot = {}\nsensors = \"model\"\ncontrol_period = 0.001\nprocedure = \"diagnose\"\n",
        written_text(name),
        written_text(question),
        written_text(robot)
    );
    for part in &plan.parts {
        match part {
            Experiment::Fast => {
                for run in 1..=2 {
                    fast(&mut text, &reaches, &format!("fast_{run}"), run, 30.0 * plan.length, None);
                }
            }
            Experiment::AddedMass => {
                fast(&mut text, &reaches, "bare", 1, 30.0 * plan.length, None);
                fast(&mut text, &reaches, "loaded", 2, 30.0 * plan.length, None);
                let Load { mass, position: [x, y, z], .. } = added_mass(model, "loaded");
                let _ = writeln!(text, "[session.added_mass]\nmass = {mass}\nx = {x}\ny = {y}\nz = {z}");
            }
            Experiment::AtRest => {
                head(&mut text, &reaches, "at_rest", "rest");
                let _ = writeln!(text, "duration = {}", 2.0 * plan.length);
            }
            Experiment::OneByOne => {
                for index in 0..reaches.len() {
                    let joint = &model.joints[index].name;
                    let by_name = Some(format!("alone_{joint}")).filter(|name| is_fit_name(name));
                    let alone = by_name.unwrap_or_else(|| format!("alone_{}", index + 1));
                    fast(&mut text, &reaches, &alone, 11 + index, 20.0 * plan.length, Some(index));
                }
            }
            Experiment::SlowSteps => slow_steps(&mut text, &reaches, plan.length),
            Experiment::WideRange => wide_range(&mut text, &reaches, plan.length),
        }
    }
    text += "\n[controller]\nlaw = \"pi\"\nvelocity = \"sensor\"\n";
    for Reach { name, gains: [proportional, integral], .. } in &reaches {
        let _ = writeln!(
            text,
            "[controller.joints.{}]\nproportional = {proportional}\nintegral = {integral}",
            written_key(name)
        );
    }
    text
}

fn head(text: &mut String, reaches: &[Reach], name: &str, kind: &str) {
    let _ = writeln!(text, "\n[[session]]\nname = {}\nkind = {kind:?}\nrest = 1.0", written_text(name));
    for reach in reaches {
        let _ = writeln!(text, "start.{} = {}", written_key(&reach.name), reach.middle);
    }
}

fn fast(text: &mut String, reaches: &[Reach], name: &str, seed: usize, duration: f64, alone: Option<usize>) {
    head(text, reaches, name, "fast");
    let _ = writeln!(text, "duration = {duration}\nlongest_rest = 0.2\nseed = {seed}");
    for (_, reach) in reaches.iter().enumerate().filter(|(index, _)| alone.is_none_or(|alone| alone == *index)) {
        let Reach { name, middle, half, speed, acceleration, .. } = reach;
        let _ = writeln!(
            text,
            "[session.joints.{}]\nlowest = {}\nhighest = {}\nspeed = {speed}\nacceleration = {acceleration}",
            written_key(name),
            middle - half,
            middle + half
        );
    }
}

fn slow_steps(text: &mut String, reaches: &[Reach], length: f64) {
    head(text, reaches, "steps", "staircase");
    for reach in reaches {
        let Reach { name, speed, acceleration, .. } = reach;
        let step = speed / 40.0;
        let _ = writeln!(
            text,
            "[session.joints.{}]\nfirst = {step}\nlast = {}\nincrement = {step}\nacceleration = {}\ndeceleration = {}\n\
             steady_time = {}",
            written_key(name),
            5.0 * step,
            0.2 * acceleration,
            0.2 * acceleration,
            1.5 * length
        );
    }
}

fn wide_range(text: &mut String, reaches: &[Reach], length: f64) {
    for (run, part) in [0.25, 0.5].into_iter().enumerate() {
        head(text, reaches, &format!("sweep_{}", run + 1), "waypoints");
        for (index, reach) in reaches.iter().enumerate() {
            let Reach { name, middle, half, speed, acceleration, .. } = reach;
            let (low, high) = (middle - half, middle + half);
            // Joints have different speeds, so that all poses of one occur with all poses of another.
            let own = part * speed * (1.0 - 0.3 * index as f64 / reaches.len() as f64);
            let ways: Vec<String> = (0..(2.0 * length) as usize).map(|_| format!("{high}, {low}")).collect();
            let _ = writeln!(
                text,
                "[session.joints.{}]\npositions = [{}, {middle}]\nspeed = {own}\nacceleration = {}",
                written_key(name),
                ways.join(", "),
                0.2 * acceleration
            );
        }
    }
}
