//! What the stage of a diagnosis says of a machine.

use std::fmt::Write as _;
use std::time::Instant;

use lostmotion::diagnose::judge::{self, judge};
use lostmotion::diagnose::{Judgement, Options, diagnose};
use lostmotion::error::Result;
use lostmotion::likelihood::{Recording, Score, Settings, score};

use super::case::Given;

/// A machine, what was hidden in it, and what was said.
pub struct Judged {
    name: String,
    hidden: Vec<String>,
    regression: Vec<String>,
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
        let (train, hold_out) = sessions.split_at(3);
        let found = diagnose(&nominal, train, hold_out, &Options::default(), &mut |_, _| {})?;
        let start = Instant::now();
        let mut options = judge::Options { seconds: f64::INFINITY, ..judge::Options::default() };
        options.unseen.retain(|effect| unseen.iter().any(|one| one == "all" || one == effect));
        let judgement = judge(&found, train, hold_out, &options, &mut |_, _| {})?;
        let seconds = start.elapsed().as_secs_f64();
        let floor = truth.map(|truth| -> Result<f64> {
            let mut windows = Vec::new();
            for one in judgement.windows.iter().filter(|one| !one.fitted) {
                if let Some(series) = sessions.iter().find(|series| series.name == one.session) {
                    windows.push(Recording::new(&truth, series)?.window(one.from, one.to));
                }
            }
            let exact = vec![-1.5; truth.joints.len()];
            let scores = score(&truth, &windows, &exact, &Settings { burn_in: 1.0, ..Settings::default() })?;
            let readings: usize = scores.iter().map(|score| score.samples * score.nats.len()).sum();
            Ok(scores.iter().map(Score::sum).sum::<f64>() / readings.max(1) as f64)
        });
        let regression = found.effects.iter().map(|effect| effect.effect.clone()).collect();
        Ok(Self { name, hidden, regression, judgement, floor: floor.transpose()?, seconds })
    }

    /// The lines of the machine.
    pub fn lines(&self) -> String {
        let said = &self.judgement;
        let mut text = format!("{}: regression names {:?}; {:.0} s", self.name, self.regression, self.seconds);
        self.hidden.iter().for_each(|hidden| {
            let _ = write!(text, "\n    hidden {hidden}");
        });
        if let Some(reason) = &said.not_applied {
            let _ = write!(text, "\n    not applied: {reason}");
        }
        if let Some(distance) = &said.distance {
            let _ = write!(
                text,
                "\n    baseline {:.4}, best {:.4}, its floor {:.4}, floor of the truth {:.4?}, missed torque {:.2?}{}",
                distance.baseline,
                distance.best,
                distance.floor,
                self.floor,
                distance.missed_torque,
                if said.unexplained { ", UNEXPLAINED" } else { "" }
            );
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
