//! Whether the delay of the current differs between the two recordings.

use crate::diagnose::fit::cause::change_of;
use crate::diagnose::instruments::current_lag::Aligned;
use crate::diagnose::result::{Findings, FoundEffect, Unexplained};
use crate::robot::Model;

/// Standard errors by which two lags have to differ: the lag of one joint in one session scatters by 0.2 ms, and few lags are compared.
const SURELY: f64 = 4.0;

/// Findings of both recordings about a late current: a new delay is named as a change, a delay of the reference is not.
pub fn changed(model: &Model, [before, now]: [&Option<Aligned>; 2]) -> Findings {
    match (before, now) {
        (None, None) => Findings::default(),
        (None, Some(now)) => Findings { effects: now.told.effects.iter().map(as_change).collect(), ..now.told.clone() },
        (Some(before), None) => Findings { unexplained: in_words(model, before, None), ..Findings::default() },
        (Some(before), Some(now)) => {
            let [was, is] = [before.late.lag, now.late.lag];
            let differs = (is.value - was.value).abs() > SURELY * is.std_error.hypot(was.std_error);
            let unexplained = if differs { in_words(model, before, Some(now)) } else { Vec::new() };
            Findings { effects: before.told.effects.clone(), unexplained, ..Findings::default() }
        }
    }
}

fn as_change(found: &FoundEffect) -> FoundEffect {
    FoundEffect { effect: change_of(&found.effect), ..found.clone() }
}

fn in_words(model: &Model, before: &Aligned, now: Option<&Aligned>) -> Vec<Unexplained> {
    let words = |aligned: &Aligned| {
        let lag = aligned.late.lag;
        format!("{:.2} ± {:.2} ms", 1e3 * lag.value, 1e3 * lag.std_error)
    };
    let now = now.map_or_else(|| "by no measurable time".to_owned(), |now| format!("by {}", words(now)));
    let pattern = format!("the current lags behind the motion {now}; in the reference it lags by {}", words(before));
    model.joints.iter().map(|joint| Unexplained { joint: joint.name.clone(), pattern: pattern.clone() }).collect()
}
