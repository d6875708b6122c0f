//! The gain of the extended model, joint by joint: in torque along the measured motion, and in simulation.

use super::display::shown;
use super::number::{part, significant};
use super::table::Table;
use crate::diagnose::{Diagnosis, FitError, ReplayError, Split};
use crate::replay::Gain;

/// One sentence for each joint with an effect: both gains on held-out data.
pub fn gains(diagnosis: &Diagnosis) -> Vec<String> {
    let named = |joint: &str| diagnosis.effects.iter().any(|found| found.joints.iter().any(|own| own == joint));
    let judged =
        diagnosis.fit.iter().filter(|error| error.split == Split::HeldOut && error.quantity != "link_position");
    judged.filter(|error| named(&error.joint)).map(|error| sentence(error, &diagnosis.replay)).collect()
}

fn sentence(error: &FitError, replay: &[ReplayError]) -> String {
    let own = || replay.iter().filter(|one| one.joint == error.joint && one.split == Split::HeldOut);
    let furthest = own().max_by(|a, b| a.horizon.unwrap_or(0.0).total_cmp(&b.horizon.unwrap_or(0.0)));
    let simulation = match furthest {
        None => "not simulated".to_owned(),
        Some(ReplayError { horizon: Some(horizon), .. }) => {
            let ahead = own().filter(|one| one.horizon == Some(*horizon)).map(in_simulation);
            format!("predicted {} s ahead, {}", significant(*horizon, 1), ahead.collect::<Vec<_>>().join(", "))
        }
        Some(_) => format!("in simulation {}", own().map(in_simulation).collect::<Vec<_>>().join(", ")),
    };
    format!(
        "{} on data held out: {} error along the motion {} to {} {} ({}); {simulation}.",
        error.joint,
        error.quantity,
        significant(error.before, 3),
        significant(error.after, 3),
        error.unit,
        change(error.gain)
    )
}

fn in_simulation(error: &ReplayError) -> String {
    let (unit, factor) = shown(error.unit);
    let [before, after] = [error.before, error.after].map(|value| significant(value * factor, 3));
    let floor = error.floor.map(|floor| format!("; sensors alone {}", significant(floor * factor, 2)));
    let change = change(error.gain);
    format!("{} {before} to {after} {unit} ({change}{})", error.quantity, floor.unwrap_or_default())
}

/// A gain in a few words; there is none if its interval contains zero.
fn change(gain: Gain) -> String {
    let [_, high] = gain.interval_percent;
    if gain.shown {
        format!("{} less", part(gain.gain_percent))
    } else if high < 0.0 {
        format!("{:.0} % more", -gain.gain_percent)
    } else {
        "no gain shown".to_owned()
    }
}

/// A gain with its 95 % interval, or a note that it is not significant.
pub fn gain(gain: Gain) -> String {
    let [low, high] = gain.interval_percent;
    if gain.shown {
        format!("{} ({low:.0} to {high:.0})", part(gain.gain_percent))
    } else if high < -0.5 {
        format!("worse by {:.0} % ({:.0} to {:.0})", -gain.gain_percent, -high, -low)
    } else {
        "no gain shown".to_owned()
    }
}

/// The share of the nominal torque error that each effect removes, joint by joint; empty with fewer than two effects.
pub fn by_effect(diagnosis: &Diagnosis) -> Table {
    let mut table =
        Table::new("Torque error on data held out, by effect", &["joint", "effect", "of the nominal error"]);
    if diagnosis.effects.len() < 2 {
        return table;
    }
    for found in &diagnosis.effects {
        for (joint, percent) in &found.gain.gain_by_joint {
            table.row([joint.clone(), found.effect.clone(), format!("{percent:.1} %")]);
        }
    }
    table.rows.sort();
    table
}
