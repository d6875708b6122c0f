//! Where the fit of an effect starts, and which of its parameters are fitted: sizes that a machine may have, in terms of its model and of the friction and the
//! gaps that the regression found.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::sets;
use crate::gearhead::Direction;
use crate::likelihood::{Free, Gear, Hypothesis, ORDERS, SOFT_GEAR, STIFFNESS, Scale, SoughtGear, Start};
use crate::likelihood::{UNEVEN_GAP, UnevenGap, hardly_soft};
use crate::robot::{EffectEntry, Model};

/// Every effect that has starts.
pub const EFFECTS: [&str; 10] = [
    "joint_compliance",
    "dwell_stiction",
    "position_dependent_backlash",
    "payload",
    "rotor_inertia",
    "sensor_delay",
    "periodic_disturbance",
    "base_tilt",
    "load_dependent_friction",
    "torque_constant_error",
];

/// Values of the parameters of one start.
type Values = Vec<(&'static str, f64)>;

/// Hypotheses of one effect: on all joints at once where its starts are few, otherwise one for each joint; none for an effect without starts. `lines`: the
/// strongest frequencies [Hz] of each joint's missing torque, from which a periodic disturbance starts.
pub fn of(effect: &str, model: &Model, lines: &[Vec<f64>]) -> Vec<Hypothesis> {
    let whole = |starts: Vec<Values>, free: &[(&str, Scale)]| vec![hypothesis(effect, None, starts, free)];
    match effect {
        "payload" => {
            let reach = last_reach(model);
            let starts = [0.1, 0.3, 0.6].map(|mass| vec![("mass", mass), ("x", reach)]).into();
            whole(starts, &[("mass", Scale::By(0.1)), ("x", Scale::By(0.05))])
        }
        "base_tilt" => {
            let starts = around(8).map(|azimuth| vec![("tilt", 0.03), ("azimuth", azimuth)]).collect();
            whole(starts, &[("tilt", Scale::By(0.01)), ("azimuth", Scale::By(0.3))])
        }
        "sensor_delay" => ["current_delay", "position_delay"]
            .into_iter()
            .flat_map(|channel| {
                let starts = [0.002, 0.005, 0.01].map(|delay| vec![(channel, delay)]).into();
                whole(starts, &[(channel, Scale::By(0.001))])
            })
            .collect(),
        // A rigid joint that begins as a soft one is fitted worse than the soft one beside it gains.
        SOFT_GEAR => {
            let each = (0..model.joints.len()).map(|joint| alone(effect, model, joint, &[]));
            each.chain(on_all(effect, model).filter(|_| model.joints.len() > 1)).collect()
        }
        "dwell_stiction" | "rotor_inertia" | "load_dependent_friction" | "torque_constant_error" => {
            on_all(effect, model).into_iter().collect()
        }
        UNEVEN_GAP | "periodic_disturbance" => {
            let lines = |joint: usize| lines.get(joint).map_or(&[][..], Vec::as_slice);
            let alone = (0..model.joints.len()).map(|joint| alone(effect, model, joint, lines(joint)));
            alone.filter(|one| !one.starts.is_empty()).collect()
        }
        _ => Vec::new(),
    }
}

/// The effect on one joint.
fn alone(effect: &str, model: &Model, joint: usize, lines: &[f64]) -> Hypothesis {
    let (starts, free) = of_joint(effect, model, joint, lines);
    hypothesis(effect, Some(&model.joints[joint].name), starts, &free)
}

/// The effect on all joints, with the same start on each; `None` without joints.
fn on_all(effect: &str, model: &Model) -> Option<Hypothesis> {
    let alone: Vec<Hypothesis> = (0..model.joints.len()).map(|joint| alone(effect, model, joint, &[])).collect();
    let starts = (0..alone.first()?.starts.len()).map(|k| {
        let effects = alone.iter().flat_map(|one| one.starts[k].effects.clone()).collect();
        Start::new(effects)
    });
    let starts = starts.collect();
    let free = alone
        .iter()
        .enumerate()
        .flat_map(|(effect, one)| one.free.iter().map(move |free| Free { effect, ..free.clone() }));
    Some(Hypothesis { name: effect.to_owned(), starts, free: free.collect() })
}

/// Starts of soft gears at those that were sought, gaps and link shares with them; other effects start as before.
pub fn at_sought_gears(hypothesis: &Hypothesis, model: &Model, sought: &[SoughtGear]) -> Hypothesis {
    let at = |start: &Start| {
        let mut start = start.clone();
        for entry in start.effects.iter_mut().filter(|entry| entry.effect == SOFT_GEAR) {
            let joint = model.joints.iter().position(|joint| Some(&joint.name) == entry.joint.as_ref());
            let Some((joint, gear)) = joint.and_then(|joint| Some((joint, sought.get(joint)?))) else { continue };
            start.gears.resize(model.joints.len(), None);
            start.gears[joint] = Some(gear.gear);
            entry.parameters.extend(gear.stiffness.map(|stiffness| (STIFFNESS.to_owned(), stiffness)));
        }
        start
    };
    let mut starts: Vec<Start> = Vec::new();
    for start in hypothesis.starts.iter().map(at) {
        if !starts.contains(&start) {
            starts.push(start);
        }
    }
    Hypothesis { starts, ..hypothesis.clone() }
}

/// Sets of a gap that varies on one joint: the gaps that were sought are their only starts, and one set more has them on all joints. Other sets stay.
pub fn at_uneven_gaps(sets: Vec<Hypothesis>, model: &Model, sought: &[Vec<UnevenGap>]) -> Vec<Hypothesis> {
    let is_uneven = |set: &Hypothesis| {
        set.starts.iter().any(|start| matches!(&start.effects[..], [one] if one.effect == UNEVEN_GAP))
    };
    let all: Vec<usize> = (0..sought.len()).filter(|joint| !sought[*joint].is_empty()).collect();
    let (uneven, mut sets): (Vec<_>, Vec<_>) = sets.into_iter().partition(is_uneven);
    if uneven.is_empty() {
        return sets;
    }
    sets.extend(all.iter().map(|joint| uneven_gaps(&[*joint], model, sought)));
    if all.len() > 1 {
        sets.push(uneven_gaps(&all, model, sought));
    }
    sets
}

/// Gaps that vary on these joints, the most probable ones of each together first.
fn uneven_gaps(joints: &[usize], model: &Model, sought: &[Vec<UnevenGap>]) -> Hypothesis {
    let count = joints.iter().map(|joint| sought[*joint].len()).min().unwrap_or(0);
    let start = |k: usize| {
        let mut gears = vec![None; model.joints.len()];
        let effects = joints.iter().map(|joint| {
            let (own, place) = (&model.joints[*joint], sought[*joint][k]);
            let share = own.friction.map_or(0.0, |friction| friction.link_share);
            gears[*joint] = Some(Gear { gap: place.gap, share });
            place.entry(&own.name)
        });
        let effects = effects.collect();
        Start { effects, gears }
    };
    let starts: Vec<Start> = (0..count).map(start).collect();
    let free = joints.iter().enumerate().flat_map(|(effect, joint)| {
        let own = of_uneven_gap(sought[*joint][0].gap);
        own.map(|(parameter, scale)| Free { effect, parameter: parameter.to_owned(), scale })
    });
    let entries: Vec<&EffectEntry> = starts.iter().take(1).flat_map(|start| &start.effects).collect();
    Hypothesis { name: sets::name(&entries), free: free.collect(), starts }
}

/// What is fitted of a gap that varies around a mean.
fn of_uneven_gap(mean: f64) -> [(&'static str, Scale); 2] {
    [("amplitude", Scale::By(0.1 * mean)), ("phase", Scale::By(0.3))]
}

fn around(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| TAU * f64::from(k) / f64::from(count) - 0.5 * TAU)
}

fn of_joint(effect: &str, model: &Model, joint: usize, lines: &[f64]) -> (Vec<Values>, Vec<(&'static str, Scale)>) {
    let own = &model.joints[joint];
    let coulomb = own.friction.map_or(0.0, |friction| friction.law.coulomb(Direction::Positive));
    let gap = own.backlash.unwrap_or(0.0);
    match effect {
        SOFT_GEAR => {
            let starts = [0.5, 0.2, 0.1, 0.05].map(|share| vec![(STIFFNESS, share * hardly_soft(own))]).into();
            (starts, vec![(STIFFNESS, Scale::Times(0.3))])
        }
        "dwell_stiction" => {
            let start = |share: f64, time: f64| vec![("growth", share * coulomb), ("time_constant", time)];
            let starts = [start(0.1, 0.5), start(0.1, 2.0), start(0.25, 0.5), start(0.25, 2.0)].into();
            (starts, vec![("growth", Scale::By(0.05 * coulomb)), ("time_constant", Scale::Times(0.3))])
        }
        UNEVEN_GAP => {
            let start = |order: f64| {
                around(16).map(move |phase| vec![("amplitude", 0.3 * gap), ("order", order), ("phase", phase)])
            };
            // A gap that the regression did not find varies by nothing.
            let orders = ORDERS.into_iter().filter(|_| gap > 0.0);
            (orders.flat_map(start).collect(), of_uneven_gap(gap).into())
        }
        "rotor_inertia" => {
            let starts = [-0.25, -0.1, 0.1, 0.25].map(|error| vec![("error", error)]).into();
            (starts, vec![("error", Scale::By(0.05))])
        }
        "periodic_disturbance" => {
            let start = |frequency: &f64| {
                let frequency = *frequency;
                around(6)
                    .map(move |phase| vec![("amplitude", 0.1 * coulomb), ("frequency", frequency), ("phase", phase)])
            };
            let starts = lines.iter().flat_map(start).collect();
            let free = [("amplitude", 0.05 * coulomb), ("frequency", 0.01), ("phase", 0.3)];
            (starts, free.map(|(name, scale)| (name, Scale::By(scale))).into())
        }
        "torque_constant_error" => {
            let starts = [-0.1, 0.1].map(|error| vec![("error", error)]).into();
            (starts, vec![("error", Scale::By(0.03))])
        }
        _ => {
            let starts = [0.07, 0.15].map(|coefficient| vec![("coefficient", coefficient)]).into();
            (starts, vec![("coefficient", Scale::By(0.03))])
        }
    }
}

fn hypothesis(effect: &str, joint: Option<&str>, starts: Vec<Values>, free: &[(&str, Scale)]) -> Hypothesis {
    let entry = |values: Values| EffectEntry {
        effect: effect.to_owned(),
        joint: joint.map(str::to_owned),
        parameters: values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect::<BTreeMap<_, _>>(),
    };
    let free = free.iter().map(|(name, scale)| Free { effect: 0, parameter: (*name).to_owned(), scale: *scale });
    Hypothesis {
        name: joint.map_or_else(|| effect.to_owned(), |joint| format!("{effect} {joint}")),
        starts: starts.into_iter().map(|values| Start::new(vec![entry(values)])).collect(),
        free: free.collect(),
    }
}

/// [m] From the last joint to the far end of its link, as far as the mass says: twice the distance of its centre.
fn last_reach(model: &Model) -> f64 {
    model.robot.bodies.last().map_or(0.0, |body| 2.0 * body.inertia.com.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::Gear;

    #[test]
    fn property_sought_gears_are_the_only_start_of_soft_ones_and_leave_others_as_they_are() {
        let model = Model::load(std::path::Path::new("robots/scara/model.toml")).expect("a model");
        let gear = |gap: f64| SoughtGear { gear: Gear { gap, share: 0.2 }, stiffness: Some(1e5 * gap) };
        let sought: Vec<SoughtGear> = (0..model.joints.len()).map(|joint| gear(0.001 * (joint + 1) as f64)).collect();
        let soft = of(SOFT_GEAR, &model, &[]);
        let second = at_sought_gears(&soft[1], &model, &sought);
        assert_eq!(second.starts.len(), 1);
        let Start { effects, gears } = &second.starts[0];
        assert!((effects[0].parameters[STIFFNESS] - 200.0).abs() < 1e-9);
        let own: Vec<usize> = (0..gears.len()).filter(|joint| gears[*joint].is_some()).collect();
        assert_eq!((gears.len(), own), (model.joints.len(), vec![1]));
        let other = of("dwell_stiction", &model, &[]);
        assert_eq!(at_sought_gears(&other[0], &model, &sought), other[0]);
    }

    #[test]
    fn property_gaps_that_were_sought_are_the_starts_of_each_joint_and_of_all_together() {
        let model = Model::load(std::path::Path::new("robots/scara/model.toml")).expect("a model");
        let place = |gap: f64, order: f64| UnevenGap { gap, amplitude: 0.5 * gap, order, phase: 0.1 };
        let sought = vec![vec![place(0.01, 2.0), place(0.012, 1.0)], vec![place(0.004, 3.0)]];
        let other = of("dwell_stiction", &model, &[]);
        let all = at_uneven_gaps([other.clone(), of(UNEVEN_GAP, &model, &[])].concat(), &model, &sought);
        assert_eq!(all[..other.len()], other);
        let [first, second, both] = &all[other.len()..] else { panic!("{}", all.len()) };
        // As many starts together as the joint with the fewest has.
        assert_eq!([first, second, both].map(|set| set.starts.len()), [2, 1, 1]);
        assert_eq!([first, second, both].map(|set| set.free.len()), [2, 2, 4]);
        let Start { effects, gears } = &both.starts[0];
        assert_eq!(effects.iter().map(|one| one.parameters["order"]).collect::<Vec<_>>(), [2.0, 3.0]);
        assert_eq!(
            gears.iter().map(|gear| gear.map(|gear| gear.gap)).collect::<Vec<_>>()[..2],
            [Some(0.01), Some(0.004)]
        );
        // Beside nothing of this effect nothing is added.
        assert_eq!(at_uneven_gaps(other.clone(), &model, &sought), other);
    }
}
