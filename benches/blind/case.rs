//! One machine from seed to answer; its data are deleted afterwards.

use lostmotion::diagnose::separability::Separability;
use lostmotion::diagnose::{Options, Split};
use lostmotion::effects::find;

use super::generate::{self, Set};
use super::hidden::Order;
use super::separate::separabilities;
use super::verdict::{Verdict, verdict};

/// What became of a machine.
pub struct Case {
    pub order: Order,
    pub verdict: Verdict,
    /// One for each hidden effect; `None` where a diagnosis does not tell it by torque against motion.
    pub told: Vec<Option<Separability>>,
    /// With the hidden effect taken out of the catalogue.
    pub left_out: Option<Verdict>,
    /// The same machine along the same motion with nothing hidden.
    pub clean: Option<Verdict>,
}

impl Case {
    /// Draws, diagnoses and forgets; with `thorough` also without the effect in the catalogue, and without it in the machine.
    pub fn new(order: &Order, thorough: bool) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let made = |order: &Order| generate::in_own_process(&[super::GENERATE_ONE], folder.path(), order);
        let set = made(order);
        let verdict_of = |set: &Set, options: &Options| verdict(&order.name(), set, options);
        let verdict = verdict_of(&set, &Options::default());
        let told = match verdict.failure {
            None => separabilities(&set, &verdict.effects, &verdict.hidden),
            Some(_) => vec![None; verdict.effects.len()],
        };
        let thorough = thorough && order.effects.len() == 1;
        let left_out = thorough.then(|| {
            let mut options = Options::default();
            options.catalogue = options.catalogue.without(&order.effects[0]);
            verdict_of(&set, &options)
        });
        let clean = thorough.then(|| verdict_of(&made(&Order::nothing(order.seed)), &Options::default()));
        Self { order: order.clone(), verdict, told, left_out, clean }
    }

    /// Name of the effect where one is hidden.
    pub fn single(&self) -> Option<&str> {
        (self.order.effects.len() == 1).then(|| self.order.effects[0].as_str())
    }

    /// Whether one effect is hidden.
    pub fn is_single(&self) -> bool {
        self.order.effects.len() == 1
    }

    /// Whether one effect of strength 1 is hidden.
    pub fn is_full(&self) -> bool {
        self.is_single() && self.order.strength == 1.0
    }

    /// Whether every hidden effect shows more than `nats` beside the baseline.
    pub fn shows(&self, nats: f64) -> bool {
        self.told.iter().all(|told| told.as_ref().is_some_and(|told| told.visible > nats))
    }

    /// Whether the data tell every hidden effect from everything else by more than `nats`.
    pub fn is_separable(&self, nats: f64) -> bool {
        self.told.iter().all(|told| told.as_ref().is_some_and(|told| told.least() > nats))
    }

    /// Whether one of the hidden effects was named first, or is listed as one that cannot be told from what was.
    pub fn is_first_or_listed(&self) -> bool {
        let listed = |name: &String| self.order.effects.contains(name);
        self.verdict.is_first() || self.verdict.found.first().is_some_and(|one| one.confusable_with.iter().any(listed))
    }

    /// Whether, with the effect out of the catalogue, something is said to be unexplained, or a look-alike is named: one that
    /// declares the hidden effect as such, or is declared by it.
    pub fn left_out_well(&self) -> Option<bool> {
        let left_out = self.left_out.as_ref()?;
        let hidden = self.single()?;
        let declares = |one: &str, other: &str| find(one).is_some_and(|one| one.about().look_alikes.contains(&other));
        Some(match left_out.found.first() {
            Some(first) => declares(hidden, &first.effect) || declares(&first.effect, hidden),
            None => !left_out.unexplained.is_empty(),
        })
    }

    /// Torque error on held-out data against that of the same machine with nothing hidden.
    pub fn error_ratio(&self) -> Option<f64> {
        let error = |verdict: &Verdict| -> f64 {
            let held_out = verdict.fit.iter().filter(|error| error.split == Split::HeldOut);
            held_out.map(|error| error.after.powi(2)).sum::<f64>().sqrt()
        };
        Some(error(&self.verdict) / error(self.clean.as_ref()?))
    }
}
