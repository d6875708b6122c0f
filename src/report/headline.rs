//! The gain of the extended model, joint by joint: in torque along the measured motion, and in simulation.

use super::display::shown;
use super::number::{part, significant};
use super::table::Table;
use crate::diagnose::{Diagnosis, FitError, FoundEffect, ReplayError, Split};
use crate::replay::Gain;

/// One sentence for each joint with an effect: both gains on held-out data.
pub fn gains(diagnosis: &Diagnosis) -> Vec<String> {
    let named = |joint: &str| diagnosis.effects.iter().any(|found| found.joints.iter().any(|own| own == joint));
    let judged = diagnosis.fit.iter().filter(|error| is_judged(error));
    judged.filter(|error| named(&error.joint)).map(|error| sentence(error, &diagnosis.replay)).collect()
}

/// Whether an error is that of a torque on data held out.
fn is_judged(error: &FitError) -> bool {
    error.split == Split::HeldOut && error.quantity != "link_position"
}

/// In which quantity an effect gains. Rows that neither model explains have little weight in its own gain, so it may be shown where no joint's is.
pub fn quantity(found: &FoundEffect, fit: &[FitError]) -> String {
    let of_effect = |error: &&FitError| is_judged(error) && found.joints.contains(&error.joint);
    let mut judged = fit.iter().filter(of_effect).peekable();
    let gain_of = &found.gain.gain_of;
    match gain_of == "torque" && judged.peek().is_some() && judged.all(|error| !error.gain.shown) {
        true => {
            format!("{gain_of}, with little weight on rows that neither model explains; over all rows no gain is shown")
        }
        false => gain_of.clone(),
    }
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::diagnose::result::{EffectGain, Standing};
    use crate::effects::find;

    /// The sentence of an effect says that its gain is not that of all rows only where no joint of it has one, and says nothing of other joints.
    #[test]
    fn property_a_gain_that_all_rows_do_not_show_is_told_so() {
        let gain =
            |shown: bool| Gain { gain_percent: 40.0, interval_percent: [if shown { 30.0 } else { -9.0 }, 50.0], shown };
        let error = |joint: &str, shown: bool| FitError {
            joint: joint.to_owned(),
            quantity: "torque",
            unit: "N·m",
            split: Split::HeldOut,
            before: 2.0,
            after: 1.2,
            floor: 1.0,
            before_percent: 5.0,
            after_percent: 3.0,
            gain: gain(shown),
        };
        let about = find("cogging").expect("an effect of the catalogue").about();
        let standing = Standing { probability: 0.9, evidence_nats: 90.0, gain: EffectGain::of(gain(true), "torque") };
        let found = FoundEffect::new(about, vec!["one".to_owned()], BTreeMap::new(), standing);
        let over_all = |fit: &[FitError]| quantity(&found, fit).ends_with("over all rows no gain is shown");
        assert!(over_all(&[error("one", false), error("two", true)]));
        assert!(!over_all(&[error("one", true), error("two", false)]));
        assert!(!over_all(&[error("two", false)]));
    }
}
