//! Likelihood of the encoder counts of one reversal, if the gap is `b` and the measured current drove the rotor.
//!
//! An ensemble of guesses at the state of rotor and link is simulated along the reversal, each with its own torque noise and its own
//! friction. At every sample the encoder shows that the rotor is in one count, `lo ≤ θ < lo + δ`. The ensemble's mean `μ` and
//! variance `σ²` of `θ` give the likelihood of this reading. They are then moved to the moments of the normal distribution truncated to
//! the count; all other states follow by their covariance with `θ`:
//!
//! ```text
//!   S² = σ² + σ_o²     μ ← μ + (σ²/S) d     σ² ← σ² (1 − σ²/S² k)     ln L += ln Z         d, k, Z: `truncated`
//! ```
//! So an edge, or its absence, places the rotor inside a count, even where the current predicts another position.
//!
//! Left out: correlation of the torque noise in time. The likelihood is therefore too sharp; the scatter of the reversals
//! gives the standard error.
//! References: J. L. Anderson (2001), An ensemble adjustment Kalman filter; T. P. Minka (2001), assumed-density filtering.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::transmission::{Member, Transmission};
use super::truncated::Truncated;

/// Lower bound of `ln Z` of one sample: a reading that no guess explains counts, but does not outweigh all others.
const WORST_SAMPLE: f64 = -20.0;

/// Distance of a guess from the far flank, in counts, at which the runs for all gaps separate if the guesses begin on both flanks.
const MARGIN: f64 = 2.0;

/// The measured reversal, with what is known of the machine there.
#[derive(Debug, Clone)]
pub(super) struct Window {
    /// The machine at this posture.
    pub transmission: Transmission,
    /// `δ` [rad or m] size of a count.
    pub count: f64,
    /// [s] median sample interval.
    pub interval: f64,
    /// [s] from each sample to the next.
    pub steps: Vec<f64>,
    /// [rad or m] middle of the count at each sample.
    pub position: Vec<f64>,
    /// `τ` [N·m or N] motor torque between a sample and the next.
    pub torque: Vec<f64>,
    /// `K` [N·m or N] coupling to the other joints between a sample and the next.
    pub coupling: Vec<f64>,
    /// [rad/s or m/s] approximate velocity at the first sample.
    pub velocity: f64,
    /// Seed of the ensemble's noise; the same for every gap, so that likelihoods compare.
    pub seed: u64,
}

/// Spread of the guesses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    /// Number of guesses.
    pub members: usize,
    /// `s` [1] link share: mean and standard deviation.
    pub share: [f64; 2],
    /// [1] standard deviation of the factor on the friction law.
    pub level: f64,
    /// [s] time over which that factor changes.
    pub level_time: f64,
    /// [N·m or N] standard deviation of the torque of a sample.
    pub torque: f64,
    /// `σ_o` in counts: how sharp a count's ends are.
    pub blur: f64,
    /// [1] Weight of `ln L` within one reversal: neighbouring samples share their errors, so the counts say less than they seem to.
    pub temper: f64,
}

/// How well a gap explains a reversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    /// `ln L`.
    pub log_likelihood: f64,
    /// Least `ln Z` of a sample.
    pub worst: f64,
    /// `s` [1] link share after the reversal: mean and standard deviation.
    pub share: [f64; 2],
}

/// Random numbers of a reversal: for the initial guesses, and for the noise on each of them.
#[derive(Debug)]
pub(super) struct Draws {
    start: Vec<[f64; 4]>,
    noise: Vec<[f64; 2]>,
}

impl Draws {
    /// Standard normal draws for a window.
    pub fn new(window: &Window, members: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(window.seed);
        let mut draw = || StandardNormal.sample(&mut rng);
        let start = (0..members).map(|_| std::array::from_fn(|_| draw())).collect();
        let noise = (0..members * window.position.len()).map(|_| [draw(), draw()]).collect();
        Self { start, noise }
    }
}

/// An ensemble at one sample of a reversal.
#[derive(Debug, Clone)]
pub(super) struct Run<'a> {
    window: &'a Window,
    draws: &'a Draws,
    spread: Spread,
    members: Vec<Member>,
    /// [N·m or N] of each member's motor at the sample.
    torques: Vec<f64>,
    gap: f64,
    sample: usize,
    /// `ln L` after every sample.
    course: Vec<f64>,
    worst: f64,
}

impl<'a> Run<'a> {
    /// A run for each of ascending gaps, at the sample at which it separates from those for larger gaps: where a guess may meet the far flank. Guesses on both
    /// flanks are farther apart with a larger gap, and readings correct them differently: then all runs separate together, well before the first flank.
    pub fn before_contact(window: &'a Window, draws: &'a Draws, gaps: &[f64], spread: &Spread) -> Vec<Self> {
        let largest = gaps[gaps.len() - 1];
        let members = guesses(window, draws, largest, spread);
        let on_one_flank = members.iter().all(|one| one.side == members[0].side);
        let torques = Vec::with_capacity(members.len());
        let (spread, sample, course, worst) = (*spread, 0, vec![0.0], 0.0);
        let mut run = Self { window, draws, spread, members, torques, gap: largest, sample, course, worst };
        let separated = |&gap: &f64| {
            let (smaller, margin) = if on_one_flank { (gap, 0.0) } else { (gaps[0], MARGIN * window.count) };
            while !run.may_meet_flank(smaller, margin) && run.step() {}
            run.with(gap)
        };
        gaps.iter().map(separated).collect()
    }

    /// Whether a guess is within a margin [rad or m] of the far flank of a smaller gap, or may meet it in the next sample: within twice what it may move by, at a motor
    /// torque with four standard deviations of noise. A flank that is compressed throws a guess by less than the compression.
    fn may_meet_flank(&self, gap: f64, margin: f64) -> bool {
        let Some((tau, step)) = self.ahead() else { return false };
        let tau = tau.abs() + 4.0 * self.spread.torque;
        self.members.iter().any(|one| {
            let from_flank = 0.5 * self.gap - one.side * (one.theta - one.q);
            let reach = 2.0 * self.window.transmission.reach(one, tau, step);
            gap - from_flank <= margin || gap - from_flank.abs() < reach
        })
    }

    /// Runs the rest of the reversal. It stops once `ln L` is below `floor`: the remaining samples could only lower it.
    pub fn score(&mut self, floor: f64) -> Score {
        let stopped = self.course.iter().copied().find(|log_likelihood| *log_likelihood < floor);
        let log_likelihood = stopped.unwrap_or_else(|| {
            while self.log_likelihood() >= floor && self.step() {}
            self.log_likelihood()
        });
        let share = moments(self.members.iter().map(|member| member.share));
        Score { log_likelihood, worst: self.worst, share }
    }

    /// `ln L` so far.
    fn log_likelihood(&self) -> f64 {
        self.course[self.sample]
    }

    /// A run from here on for the gap `b`.
    fn with(&self, gap: f64) -> Self {
        let mut run = self.clone();
        for member in &mut run.members {
            let compression = member.side * (member.theta - member.q) - 0.5 * run.gap;
            member.q = member.theta - member.side * between(compression, gap);
        }
        run.gap = gap;
        run
    }

    /// Motor torque [N·m or N] and time [s] to the next sample; `None` at the end of the window.
    fn ahead(&self) -> Option<(f64, f64)> {
        let Window { torque, steps, .. } = self.window;
        Some((*torque.get(self.sample)?, *steps.get(self.sample)?))
    }

    /// Advances by one sample; false at the end of the window.
    fn step(&mut self) -> bool {
        let Window { transmission, interval, position, count, coupling, .. } = self.window;
        let Some((tau, step)) = self.ahead() else { return false };
        let sample = self.sample;
        // A longer step is divided, because contact is stable in steps of the median interval.
        let parts = (step / interval - 0.5).ceil().max(1.0);
        let keep = (-step / self.spread.level_time).exp();
        let renew = (1.0 - keep * keep).sqrt() * self.spread.level;
        let from = sample * self.members.len();
        let noise = &self.draws.noise[from..from + self.members.len()];
        self.torques.clear();
        for (member, [z_torque, z_level]) in self.members.iter_mut().zip(noise) {
            member.level = 1.0 + keep * (member.level - 1.0) + renew * z_level;
            self.torques.push(tau + self.spread.torque * z_torque);
        }
        for _ in 0..parts as usize {
            transmission.advance(&mut self.members, self.gap, &self.torques, coupling[sample], step / parts);
        }
        let log_mass = assimilate(&mut self.members, position[sample + 1], *count, self.spread.blur * count);
        self.worst = self.worst.min(log_mass);
        self.course.push(self.log_likelihood() + log_mass.max(WORST_SAMPLE));
        self.sample += 1;
        true
    }
}

/// How far a rotor is ahead of its link [rad or m] with a gap `b`, where the flank that it pushes is compressed by `p`. Flanks that overlap, `b < 0`, are those
/// of no machine, and explain a motion nearly as well as none between them: they begin without a load and ring, so that values scatter evenly around none.
fn between(p: f64, gap: f64) -> f64 {
    0.5 * gap + if gap < 0.0 { p.min(0.0) } else { p }
}

/// Guesses at the first sample: anywhere in the count, in contact on the side that pushes, the gear wound up by that.
fn guesses(window: &Window, draws: &Draws, gap: f64, spread: &Spread) -> Vec<Member> {
    let machine = &window.transmission;
    let direction = window.velocity.signum();
    let v_sd = 0.1 * window.velocity.abs() + 2.0 * window.count;
    draws
        .start
        .iter()
        .map(|[z_theta, z_v, z_share, z_level]| {
            // The same variance as a uniform position in the count has.
            let theta = window.position[0] + window.count * z_theta / 12f64.sqrt();
            let v = window.velocity + v_sd * z_v;
            let share = (spread.share[0] + spread.share[1] * z_share).clamp(0.0, 1.0);
            let level = 1.0 + spread.level * z_level;
            let pushed =
                direction * share * machine.friction.kinetic(window.velocity).abs() + machine.gravity_at(theta);
            // Nothing pushes a link without friction and weight: it lies where the motor that accelerated it left it.
            let side = if pushed == 0.0 { direction } else { pushed.signum() };
            let q = theta - side * between(pushed.abs() / machine.dead_zone.stiffness, gap);
            Member { theta, v, q, w: v, share, level, side }
        })
        .collect()
}

/// Corrects the guesses by an encoder reading; returns `ln Z` of that reading.
fn assimilate(members: &mut [Member], middle: f64, count: f64, blur: f64) -> f64 {
    let [mean, deviation] = moments(members.iter().map(|member| member.theta));
    let variance = deviation * deviation;
    let total = variance + blur * blur;
    let s = total.sqrt();
    let seen = Truncated::new((middle - 0.5 * count - mean) / s, (middle + 0.5 * count - mean) / s);
    if seen.reduction < 1e-6 || variance == 0.0 {
        return seen.log_mass;
    }
    let shift = variance / s * seen.mean;
    let shrink = (1.0 - variance / total * seen.reduction.min(1.0)).max(0.0).sqrt() - 1.0;
    let gains = covariances(members, mean).map(|c| c / variance);
    for member in members.iter_mut() {
        let step = shift + shrink * (member.theta - mean);
        member.theta += step;
        member.v += gains[0] * step;
        member.q += gains[1] * step;
        member.w += gains[2] * step;
        member.share = (member.share + gains[3] * step).clamp(0.0, 1.0);
        member.level += gains[4] * step;
    }
    seen.log_mass
}

/// Covariance of v, q, w, s and the level with θ.
fn covariances(members: &[Member], mean_theta: f64) -> [f64; 5] {
    let n = members.len() as f64;
    // Σ(θ − mean) = 0, so any reference value gives the same sum; a close one keeps the precision.
    let states = |m: &Member| [m.v, m.q, m.w, m.share, m.level];
    let mut products = [0.0; 5];
    let first = states(&members[0]);
    for member in members {
        let e = member.theta - mean_theta;
        for (i, (x, x0)) in states(member).iter().zip(first).enumerate() {
            products[i] += e * (x - x0);
        }
    }
    std::array::from_fn(|i| products[i] / (n - 1.0))
}

/// Mean and standard deviation.
fn moments(values: impl ExactSizeIterator<Item = f64> + Clone) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let variance = values.map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, variance.sqrt()]
}
