//! What the stage of a diagnosis says of a machine.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use lostmotion::dataset::Session;
use lostmotion::diagnose::{Diagnosis, FoundEffect, Judgement, judge};
use lostmotion::error::Result;
use lostmotion::likelihood::{Recording, Score, Settings, score};
use lostmotion::scenario::Findings;
use lostmotion::timeseries::TimeSeries;

use super::case::Given;

/// A machine, what was hidden in it, and what was said.
pub struct Judged {
    name: String,
    hidden: Vec<String>,
    found: Diagnosis,
    judgement: Judgement,
    /// [nat] a reading of the true machine on the same windows, where it is known.
    floor: Option<f64>,
    /// [s]
    seconds: f64,
}

impl Judged {
    /// With these effects beside what the regression names; `all`: those of the stage.
    pub fn new(given: Given, unseen: &[String]) -> Result<Self> {
        let Given { name, hidden, nominal, truth, sessions } = given;
        let session = |series: &TimeSeries| Session {
            series: series.clone(),
            notes: Vec::new(),
            source: PathBuf::from(&series.name),
            controllers: vec![None; series.joints.len()],
        };
        let all: Vec<Session> = sessions.iter().map(session).collect();
        let (train, hold_out) = all.split_at(3);
        let start = Instant::now();
        let mut options = judge::Options { seconds: f64::INFINITY, ..judge::Options::default() };
        options.unseen.retain(|effect| unseen.iter().any(|one| one == "all" || one == effect));
        let mut findings = Findings::new(&nominal, train.into(), hold_out.into(), &mut |_, _| {})?;
        findings.judge(train.into(), hold_out.into(), &options, &mut |_, _| {});
        let seconds = start.elapsed().as_secs_f64();
        if let Some(failure) = findings.judge_failure {
            return Err(failure);
        }
        let found = findings.diagnosis;
        let judgement = found.judgement.clone().unwrap_or_default();
        let floor = truth.map(|truth| -> Result<f64> {
            let mut windows = Vec::new();
            for one in judgement.windows.iter().filter(|one| !one.fitted) {
                if let Some(series) = sessions.iter().find(|series| series.name == one.session) {
                    windows.push(Recording::new(&truth, series)?.window(one.from, one.to));
                }
            }
            let exact = vec![-1.5; truth.joints.len()];
            let scores = score(&truth, &windows, &exact, &Settings { burn_in: 1.0, ..Settings::default() })?;
            let readings: usize = scores.iter().flat_map(|score| &score.readings).sum();
            Ok(scores.iter().map(Score::sum).sum::<f64>() / readings.max(1) as f64)
        });
        Ok(Self { name, hidden, found, judgement, floor: floor.transpose()?, seconds })
    }

    /// The lines of the machine.
    pub fn lines(&self) -> String {
        let said = &self.judgement;
        let mut text = format!("{}; {:.0} s", self.name, self.seconds);
        self.hidden.iter().for_each(|hidden| {
            let _ = write!(text, "\n    hidden {hidden}");
        });
        if let Some(reason) = &said.not_applied {
            let _ = write!(text, "\n    not applied: {reason}");
        }
        if let Some(distance) = &said.distance {
            let _ = write!(
                text,
                "\n    baseline {:.4}, best {:.4}, its floor {:.4?}, floor of the truth {:.4?}, missed torque {:.2?}{}",
                distance.baseline,
                distance.best,
                distance.floor,
                self.floor,
                distance.missed_torque,
                if said.unexplained { ", UNEXPLAINED" } else { "" }
            );
        }
        self.found.effects.iter().for_each(|effect| {
            let _ = write!(text, "\n    named {}", named(effect));
        });
        for (joint, baseline) in &self.found.baseline {
            let gap = baseline.backlash.as_ref().map(|gap| format!("{:.4} ± {:.4}", gap.value, gap.std_error));
            let _ = write!(text, "\n    gap of {joint} {gap:?}");
        }
        for error in &self.found.replay {
            let _ = write!(
                text,
                "\n    {} {} {:?} s: {:.3e} to {:.3e}, floor {:.2e}, gain {:.1?}",
                error.joint,
                error.quantity,
                error.horizon,
                error.before,
                error.after,
                error.floor.unwrap_or(f64::NAN),
                error.gain.interval_percent
            );
        }
        for withdrawn in &self.found.withdrawn {
            let _ = write!(text, "\n    withdrawn {} {:?}: {}", withdrawn.effect, withdrawn.joints, withdrawn.reason);
        }
        for name in &said.names {
            let _ = write!(
                text,
                "\n  > {} {:?} {:.3} or {:?}",
                name.effect, name.joints, name.probability, name.confusable_with
            );
        }
        for set in &said.sets {
            let sizes: Vec<String> = set
                .sizes
                .iter()
                .map(|(name, size)| format!("{name} {:.4} ± {:.4}", size.value, size.std_error))
                .collect();
            let _ = write!(
                text,
                "\n    {:50} {:8.1} {:.3?} {}",
                set.name,
                set.gain_nats,
                set.probability,
                sizes.join(", ")
            );
        }
        for window in &said.windows {
            let what = if window.fitted { "fit" } else { "judge" };
            let _ = write!(text, "\n    {what} {} {:.0}–{:.0} s", window.session, window.from, window.to);
        }
        text
    }
}

/// An effect with its parameters, probability and gain.
fn named(effect: &FoundEffect) -> String {
    let one = |(name, measured): (&String, &lostmotion::diagnose::Measured)| {
        format!("{name} {:.4} ± {:.4}", measured.value, measured.std_error)
    };
    let parameters: Vec<String> = effect.parameters.iter().map(one).collect();
    format!(
        "{} {:?} ({}), {:.3}, {:.0} nats, gain {:.0?} % of {}",
        effect.effect,
        effect.joints,
        parameters.join(", "),
        effect.probability,
        effect.evidence_nats,
        effect.gain.gain_interval_percent,
        effect.gain.gain_of
    )
}
