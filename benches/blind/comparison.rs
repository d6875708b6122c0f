//! A machine twice: healthy, and later with one of its quantities changed, or as it was.

use std::path::Path;

use lostmotion::dataset;
use lostmotion::diagnose::{Change, Options, compare};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

use super::generate;
use super::hidden::Order;

/// What became of it.
pub struct Comparison {
    pub order: Order,
    /// What was said to have changed, surest first.
    pub changes: Vec<Change>,
    /// Names of effects said to be there now and not before.
    pub effects: Vec<String>,
}

impl Comparison {
    /// Draws both, compares, forgets. The program has the nominal model of the healthy machine.
    pub fn new(order: &Order) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let made = |order: &Order| generate::in_own_process(&[super::GENERATE_ONE], folder.path(), order);
        let (healthy, now) = (made(&Order::nothing(order.seed)), made(order));
        let model = Model::load(&healthy.model).expect("the nominal model");
        let read = |file: &Path| dataset::load(file, &dataset::joints_of(&model)).expect("a recording").series;
        let all = |files: &[std::path::PathBuf]| files.iter().map(|file| read(file)).collect::<Vec<TimeSeries>>();
        let (before, after, judged) = (all(&healthy.data), all(&now.data), [read(&now.hold_out)]);
        let found = compare(&model, &before, &after, &judged, &Options::default(), &mut |_, _| {});
        let found = found.expect("a comparison");
        let effects = found.effects.iter().map(|effect| effect.effect.clone()).collect();
        Self { order: order.clone(), changes: found.changes.unwrap_or_default(), effects }
    }

    /// Whether what has changed was named first; where nothing has, that nothing was named.
    pub fn is_first(&self) -> bool {
        match self.order.changed() {
            Some(quantity) if !quantity.is_empty() => {
                self.changes.first().is_some_and(|change| change.quantity == quantity)
            }
            _ => self.changes.is_empty() && self.effects.is_empty(),
        }
    }

    /// One line for the log.
    pub fn line(&self) -> String {
        let one = |change: &Change| {
            let percent = &change.change_percent;
            format!("{} {} {:+.1} ± {:.1} %", change.joint, change.quantity, percent.value, percent.std_error)
        };
        let changes: Vec<String> = self.changes.iter().map(one).collect();
        let mark = if self.is_first() { "ok   " } else { "WRONG" };
        format!("{mark} {}: {}; effects {}", self.order.name(), changes.join(", "), self.effects.join(", "))
    }
}
