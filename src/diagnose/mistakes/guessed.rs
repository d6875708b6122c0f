//! Torque constants that the model guesses, from the torque of inertia and weight.
//!
//! A first model of a URDF states constants with an accuracy of 1: the true one may be several times as large. The [balance](super::balance) of all joints
//! gives most of them ([`factors`](super::factors)).
//!
//! A constant is replaced where the residual is a small part of the torque and its error by a load or a tilt is smaller than that of the guess; otherwise its
//! guess is taken to be off as those of the nearest joints are, as far as the [size](super::size) of its torque allows, and by what the checks for
//! [mistakes](super) say of its scale. All stages work with the model that this gives and with the accuracy that the constants have then: the deviations of
//! their fits are small, and a load or a tilt has one size on all joints only if the constants of these joints are nearly right.

use std::borrow::Cow;

use super::balance::{Columns, SIZE_FACTOR, bounds};
use super::factors::{FURTHEST, Factor, factors, is_within};
use super::{Mistake, rows, size, suspected, training_parts};
use crate::diagnose::rows::division::Division;
use crate::identify::statistics::median;
use crate::robot::{JointModel, Masses, Model};
use crate::timeseries::{Channel, TimeSeries};

/// [1] Where guesses are off by more in the median of the joints, the unit of the currents may be [another](shows_another_unit). What the balance does not show
/// and another check tells of a single joint is a mistake beyond it, too.
const COMMON: f64 = 30.0;
/// [N·m/A] Least torque constant of a robot's motor: a smaller one turns faster than 3000 rad/s on 6 V, its back EMF in V·s/rad being the same number.
const LEAST_CONSTANT: f64 = 0.002;
/// [1] Relative error of a constant with which it shows its unit: two of it are the factor by which a model may be off.
const UNIT_SHOWS: f64 = 0.5 * std::f64::consts::LN_2;

/// The model with constants that agree with inertia and weight in the training data, where its own are guesses and the recordings hold currents.
pub fn with_constants<'m>(model: &'m Model, sessions: &[&TimeSeries], division: Division) -> Cow<'m, Model> {
    if !model.accuracy.guesses_torque_constants() || model.masses == Masses::Estimated {
        return Cow::Borrowed(model);
    }
    let trained = training_parts(sessions, division);
    let parts: Vec<Cow<TimeSeries>> = trained.iter().flat_map(|session| session.uninterrupted()).collect();
    let parts: Vec<&TimeSeries> = parts.iter().map(AsRef::as_ref).collect();
    if model.joints.is_empty() || parts.is_empty() {
        return Cow::Borrowed(model);
    }
    let mut scaled = model.clone();
    let doubtful = scale_by_balance(&mut scaled, &parts);
    scale_by_mistakes(&mut scaled, &parts, doubtful);
    restore_far_ones(model, &mut scaled);
    Cow::Owned(scaled)
}

/// Constants from the balance of all joints; where it determines none, from those of the nearest joints, as near to them as the size of the rigid body's torque
/// allows. Returns the names of joints whose constant the balance tells no better than the guess, each with the factor that it would ask for.
fn scale_by_balance(model: &mut Model, parts: &[&TimeSeries]) -> Vec<(String, f64)> {
    let rows = rows::rows(model, parts);
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let normals = Columns::new(model, &rows).normals(&rows, &moves);
    let bounds = bounds(model);
    let stated = model.accuracy;
    let found = factors(&normals, &bounds, stated.torque_constants);
    let with_current: Vec<bool> = model.joints.iter().map(|joint| has_current(parts, &joint.name)).collect();
    let is_known = |joint: usize, found: &Factor| with_current[joint] && found.error < stated.torque_constants;
    let known: Vec<Option<Factor>> =
        found.iter().enumerate().map(|(joint, found)| found.filter(|found| is_known(joint, found))).collect();
    let mut doubtful = Vec::new();
    for index in (0..known.len()).filter(|joint| with_current[*joint]) {
        let name = model.joints[index].name.clone();
        if let Some(Factor { f, error }) = known[index] {
            scale(model, &name, f);
            // The masses, too, are only as accurate as the model says, and the constant was measured by their weight.
            model.joints[index].constant_accuracy = Some(error.hypot(stated.masses).min(stated.torque_constants));
            continue;
        }
        let neighbours = factor_of_nearest(&known, index);
        let size = size::of_rows(model, index, &normals[index], &bounds);
        let used = size.map_or(neighbours, |size| size.possible_factor(neighbours));
        scale(model, &name, used);
        doubtful.extend(found[index].map(|found| (name, found.f / used)));
    }
    doubtful
}

/// `f` of the nearest joints along the arm whose constant is known, their geometric mean where there are two; one where none is. Neighbours have motors of
/// about one size, and effort limits that are all too large are so together.
fn factor_of_nearest(known: &[Option<Factor>], joint: usize) -> f64 {
    let at = |distance: usize| {
        let places = [joint.checked_sub(distance), joint.checked_add(distance)].into_iter().flatten();
        places.filter_map(|place| Some((*known.get(place)?)?.f.ln())).collect::<Vec<_>>()
    };
    let nearest = (1..known.len()).map(at).find(|logarithms| !logarithms.is_empty()).unwrap_or_default();
    (nearest.iter().sum::<f64>() / nearest.len().max(1) as f64).exp()
}

/// What the other checks say of a scale is a constant too; each may have to be right before the next one shows. A `doubtful` constant was nearer than the
/// guess where they say so of its joint, or take its torque for one that was recorded in place of its current.
fn scale_by_mistakes(model: &mut Model, parts: &[&TimeSeries], mut doubtful: Vec<(String, f64)>) {
    for _ in 0..model.joints.len() {
        let found = suspected(model, parts);
        let of_guess = found.iter().filter(|mistake| is_of_guess(model, parts, mistake));
        if let Some((mistake, factor)) = of_guess.filter_map(|one| Some((one, scale_of_guess(one)?))).next() {
            for name in &mistake.joints {
                let own = doubtful.iter().position(|(joint, _)| joint == name).map(|at| doubtful.swap_remove(at).1);
                scale(model, name, own.unwrap_or(factor));
            }
            continue;
        }
        let as_current = found.iter().filter(|mistake| mistake.mistake == "torque_recorded_as_current");
        let names: Vec<&String> = as_current.flat_map(|mistake| &mistake.joints).collect();
        let Some(place) = doubtful.iter().position(|(name, _)| names.contains(&name)) else { break };
        let (name, factor) = doubtful.swap_remove(place);
        scale(model, &name, factor);
    }
}

/// Constants that would be off by more than a guess may be stay as the model file gives them: that is another mistake, to be told.
fn restore_far_ones(given: &Model, scaled: &mut Model) {
    let factor =
        |given: &JointModel, used: &JointModel| Some(used.motor?.torque_constant / given.motor?.torque_constant);
    let joints = || given.joints.iter().zip(&scaled.joints);
    let logarithms: Vec<f64> = joints().filter_map(|(given, used)| Some(factor(given, used)?.ln())).collect();
    let is_usual = is_within(COMMON, median(logarithms).exp()) || !shows_another_unit(scaled);
    let furthest = if is_usual { FURTHEST } else { 1.0 };
    for (given, used) in given.joints.iter().zip(&mut scaled.joints) {
        if factor(given, used).is_some_and(|factor| !is_within(furthest, factor)) {
            (used.motor, used.constant_accuracy) = (given.motor, given.constant_accuracy);
        }
    }
}

/// Whether the constants that are surely found are of currents in a smaller unit, or of torques in their place, of which one unit is one newton metre.
/// Otherwise guesses that are all far off follow from effort limits that nobody set.
fn shows_another_unit(scaled: &Model) -> bool {
    let of_joint = |joint: &JointModel| {
        Some((joint.constant_accuracy?, [joint.motor?.torque_constant, joint.torque_per_ampere()]))
    };
    let found: Vec<(f64, [f64; 2])> = scaled.joints.iter().filter_map(of_joint).collect();
    let sure: Vec<[f64; 2]> =
        found.iter().filter(|(error, _)| *error < UNIT_SHOWS).map(|(_, constants)| *constants).collect();
    if sure.is_empty() {
        return found.is_empty();
    }
    let are_one = |side: usize| sure.iter().all(|constants| is_within(SIZE_FACTOR, constants[side]));
    are_one(0) || are_one(1) || median(sure.iter().map(|[of_motor, _]| *of_motor).collect()) < LEAST_CONSTANT
}

/// Multiplies the torque constant of a joint.
fn scale(model: &mut Model, name: &str, factor: f64) {
    let joint = model.joints.iter_mut().find(|joint| joint.name == name);
    if let Some(motor) = joint.and_then(|joint| joint.motor.as_mut()) {
        motor.torque_constant *= factor;
    }
}

/// Whether these sessions hold currents of a joint, from which a constant makes its torque.
fn has_current(sessions: &[&TimeSeries], name: &str) -> bool {
    let has = |session: &&TimeSeries, channel| session.joint(name).is_some_and(|joint| joint.get(channel).is_some());
    sessions.iter().all(|session| has(session, Channel::Current))
        && !sessions.iter().any(|session| has(session, Channel::Torque))
}

/// Whether a mistake is no more than a guessed torque constant: its scale, or a gear ratio or a torque in place of its current that these data do not
/// distinguish from another scale, as its constant would only be another one.
pub fn is_of_guess(model: &Model, sessions: &[&TimeSeries], mistake: &Mistake) -> bool {
    let as_current = mistake.mistake == "torque_recorded_as_current" && mistake.alternatives.contains(&"torque_scale");
    let is_scale = as_current || scale_of_guess(mistake).is_some();
    let of_joint = |name: &String| has_current(sessions, name);
    is_scale && model.accuracy.guesses_torque_constants() && mistake.joints.iter().all(of_joint)
}

/// The factor on a constant that a mistake asks for, if it is a scale that a guess may be off by. What shows a gear ratio by the size of a torque alone, as
/// of another joint, is such a scale.
fn scale_of_guess(mistake: &Mistake) -> Option<f64> {
    let as_ratio = mistake.mistake == "gear_ratio" && mistake.alternatives.contains(&"torque_scale");
    let is_scale = as_ratio || mistake.mistake == "torque_scale";
    mistake.factor.filter(|factor| is_scale && is_within(COMMON, *factor))
}

/// What became of the constants of a model, a clause for the report; empty where nothing did.
pub fn words(given: &Model, used: &Model) -> String {
    let constant = |model: &Model, joint: usize| model.joints[joint].motor.map(|motor| motor.torque_constant);
    let of_joint = |joint: usize| {
        let [guess, found] = [given, used].map(|model| constant(model, joint));
        let (guess, found) = (guess?, found?);
        (guess != found).then(|| format!("{} {guess:.3} to {found:.3}", given.joints[joint].name))
    };
    match (0..given.joints.len()).filter_map(of_joint).collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => none,
        list => format!(
            "; torque constants that the model file guesses were first brought into agreement with inertia and weight: {list} [N·m/A]"
        ),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::timeseries::JointSeries;

    /// A scale within a factor of thirty, on a joint with a current, is what a guessed constant may be off by; nothing else is.
    #[test]
    fn property_a_scale_is_of_a_guess_only_where_constants_are_guesses() {
        let model = |accuracy: f64| {
            let text = MODEL.replace("[accuracy]\n", &format!("[accuracy]\ntorque_constants = {accuracy}\n"));
            Model::from_texts(&text, ROBOT, Path::new("model.toml")).expect("a model")
        };
        let guesses = model(1.0);
        let name = guesses.joints[0].name.clone();
        let recorded = |channel| TimeSeries {
            name: "one".to_owned(),
            time: vec![0.0],
            joints: vec![JointSeries { name: name.clone(), channels: [(channel, vec![0.0].into())].into() }],
        };
        let mistake = |mistake, factor| Mistake {
            mistake,
            joints: vec![name.clone()],
            factor: Some(factor),
            evidence: String::new(),
            remedy: String::new(),
            alternatives: Vec::new(),
        };
        let (current, torque) = (recorded(Channel::Current), recorded(Channel::Torque));
        let as_current =
            |alternatives: Vec<&'static str>| Mistake { alternatives, ..mistake("torque_recorded_as_current", 50.0) };
        assert!(is_of_guess(&guesses, &[&current], &as_current(vec!["torque_scale"])));
        assert!(is_of_guess(&guesses, &[&current], &mistake("torque_scale", 8.0)));
        let ratio = |alternatives: Vec<&'static str>| Mistake { alternatives, ..mistake("gear_ratio", 2.5) };
        assert!(is_of_guess(&guesses, &[&current], &ratio(vec!["torque_scale"])));
        // The first of so many joints is off.
        let scaled = |joints: usize, factor: f64| {
            let mut given = guesses.clone();
            given.joints = vec![given.joints[0].clone(); joints];
            let mut used = given.clone();
            scale(&mut used, &name, factor);
            restore_far_ones(&given, &mut used);
            let [used, given] = [used, given].map(|model| model.joints[0].motor.expect("a motor").torque_constant);
            used / given
        };
        // Alone, it may have currents in another unit; one of three has a motor of its own kind.
        assert_eq!([8.0, 64.0, 1.0 / 64.0].map(|factor| scaled(1, factor)), [8.0, 1.0, 1.0]);
        assert_eq!([8.0, 512.0, 1.0 / 512.0, 1024.0].map(|factor| scaled(3, factor)), [8.0, 512.0, 1.0 / 512.0, 1.0]);
        for (model, session, told) in [
            (&model(0.05), &current, mistake("torque_scale", 8.0)),
            (&guesses, &torque, mistake("torque_scale", 8.0)),
            (&guesses, &current, mistake("torque_scale", 100.0)),
            (&guesses, &current, mistake("milliampere_for_ampere", 8.0)),
            (&guesses, &current, as_current(Vec::new())),
            (&guesses, &current, ratio(Vec::new())),
            (&model(0.05), &current, ratio(vec!["torque_scale"])),
            (&model(0.05), &current, as_current(vec!["torque_scale"])),
        ] {
            assert!(!is_of_guess(model, &[session], &told), "{}", told.mistake);
        }
    }

    /// Guesses that are a hundred times too large: what was found is used where it is that of motors, and not where it is that of another unit.
    #[test]
    fn property_guesses_that_are_all_far_off_are_replaced_unless_the_unit_is_another() {
        let is_used = |constants: [f64; 3], error: f64| {
            let mut used = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a model");
            used.joints = vec![used.joints[0].clone(); constants.len()];
            let mut given = used.clone();
            for (place, constant) in constants.into_iter().enumerate() {
                let [found, guess] = [&mut used, &mut given].map(|model| &mut model.joints[place]);
                found.motor.as_mut().expect("a motor").torque_constant = constant;
                found.constant_accuracy = Some(error);
                guess.motor.as_mut().expect("a motor").torque_constant = 100.0 * constant;
            }
            let found = used.clone();
            restore_far_ones(&given, &mut used);
            used.joints == found.joints
        };
        // Joints have a ratio of 45: `1/45` is a joint's torque, one a motor's. Thousandths are currents in mA.
        assert!(is_used([0.04, 0.01, 0.07], 0.1));
        for of_unit in [[0.02, 0.03, 0.025], [0.7, 1.1, 1.3], [4e-5, 1e-5, 3e-3]] {
            assert!(!is_used(of_unit, 0.1), "{of_unit:?}");
            // Known to a factor of two they may be those of motors.
            assert!(is_used(of_unit, 0.5), "{of_unit:?}");
        }
    }

    /// The nearest joints along the arm that are known, whichever side they are on.
    #[test]
    fn property_a_constant_that_nothing_shows_is_off_as_those_of_its_neighbours() {
        let known = |f: f64| Some(Factor { f, error: 0.1 });
        let arm = [known(0.5), None, known(0.02), None, None, None];
        let found: Vec<f64> = (0..arm.len()).map(|joint| factor_of_nearest(&arm, joint)).collect();
        // The mean of both of the second joint is that of the logarithms. Rounding.
        for (found, expected) in found.iter().zip([0.02, 0.1, 0.5, 0.02, 0.02, 0.02]) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(factor_of_nearest(&[None, None], 1), 1.0);
    }
}
