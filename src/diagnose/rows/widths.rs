//! How wide the kernel of a row has to be.
//!
//! Quantisation of step `δ` causes the acceleration noise `σ_a ≈ 6.7/w² · δ/√12 · √(max(Δt, δ/|v|)/(2 w))`. With the inertia `J` of its joint it is a torque
//! `J σ_a`, and noise of a regressor: it makes the coefficient of the acceleration too small by `σ_a²/a²`, on this joint and on those that its inertia couples.
//! The half width `w` leaves as much of both as [`Noise`] permits, between 6 ms and 200 ms.
//! Reference: R. J. Carroll, D. Ruppert, L. A. Stefanski, C. M. Crainiceanu (2006), Measurement Error in Nonlinear Models, ch. 3 (attenuation).

use std::ops::Range;

use super::kernel::Kernel;
use super::resonance;
use super::sampling::Sampling;
use super::signals::Signals;
use crate::identify::statistics::typical;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries, root_mean_square, white_noise};

/// [s] Narrowest and widest half width.
pub const HALF_WIDTHS: [f64; 2] = [0.006, 0.2];
/// [1] Largest share of noise in the square of a torque's typical rate. A regressor with noise of its own makes the coefficient too small, by this share and
/// more, since rows differ in their rates: on a six-joint arm at 500 Hz a delay of 20 ms was estimated as 0.15 ms with the rows' own kernels of 7 to
/// 11 ms, and as 16.7 ± 1.3 ms with this share. What a wider kernel leaves out of the rate is nearly uncorrelated with the rest, and does
/// not bias it (J. Berkson 1950, Are there two regressions?), but its information is lost.
const RATE_NOISE: f64 = 0.02;
/// Number of places in a session at which rates are compared with their noise.
const RATE_PLACES: usize = 500;
/// Neighbouring half widths differ by this factor.
const WIDTH_STEP: f64 = 1.3;

/// Noise that an encoder's counts may leave in the acceleration of a row.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    /// `J σ_a/τ` [1] As a share of the RMS torque of its joint.
    pub of_torque: f64,
    /// `σ_a²/a²` [1] As a share of the mean square acceleration of its joint.
    pub of_acceleration: f64,
}

/// [1] Noise of the acceleration as a share of the RMS torque.
pub const NOISE_SHARE: f64 = 0.015;
/// Where single rows have to be accurate, and coefficients of accelerations: an inertia that is too small by 0.5 % is a twentieth of the accuracy of a usual
/// rotor inertia. A simulated Kinova arm of 328 000 counts per turn of a joint seemed to have links that are off
/// by 8 times their accuracy.
pub const FAITHFUL: Noise = Noise { of_torque: NOISE_SHARE, of_acceleration: 0.005 };
/// [1] Least share of [`Noise::of_torque`] to which the acceleration lowers the noise: a joint that hardly accelerates makes no row wider than
/// `0.1^(−2/5)` = 2.5 times.
const LEAST_SHARE: f64 = 0.1;
/// Samples between those at which speeds and accelerations are looked at: a mean over hundreds does not need all.
const STRIDE: usize = 16;

/// [rad/s or m/s] Speed below which a joint counts as at rest: less than one count in a wide window.
pub fn rest_speed(model: &Model, joint: usize, fastest: f64) -> f64 {
    (model.joints[joint].encoder_step() / 0.3).max(1e-3 * fastest)
}

/// Samples on either side for a half width [s]; at least three, for a curvature.
pub fn reach(width: f64, dt: f64) -> usize {
    ((width / dt).round() as usize).max(3)
}

/// Requirements on the rows.
pub struct Request<'i> {
    /// [kg·m² or kg] Typical inertia of each joint with its rotor.
    pub inertia: &'i [f64],
    /// Permitted noise of the acceleration.
    pub noise: Noise,
    /// [rad/s² or m/s²] RMS acceleration of each joint.
    pub accelerations: &'i [f64],
    /// [s] Least distance of rows.
    pub shortest_step: f64,
}

/// [rad/s² or m/s²] RMS acceleration of each joint in all sessions.
pub fn accelerations(model: &Model, sessions: &[&TimeSeries]) -> Vec<f64> {
    let of_session = |session: &TimeSeries, name: &str| -> Vec<f64> {
        let Some(position) = session.joint(name).and_then(|series| series.get(Channel::Position)) else {
            return Vec::new();
        };
        let sampling = Sampling::new(&session.time, session.sample_interval());
        let rough = rough(sampling.median);
        let centres = sampling.centres(rough.half_width, STRIDE).into_iter();
        centres.map(|(centre, part)| sampling.window(&rough, centre, part).averages(position).curvature).collect()
    };
    let of_joint = |name: &str| {
        let all: Vec<f64> = sessions.iter().flat_map(|session| of_session(session, name)).collect();
        root_mean_square(&all)
    };
    model.joints.iter().map(|joint| of_joint(&joint.name)).collect()
}

/// [s] Half width that a joint's encoder needs at a given speed.
fn wanted_half_width(step: f64, speed: f64, inertia: f64, torque_noise: f64, dt: f64) -> f64 {
    if step <= 0.0 || torque_noise <= 0.0 {
        return HALF_WIDTHS[0];
    }
    let between_counts = dt.max(step / speed.max(1e-12));
    (6.7 * inertia * step / 12.0_f64.sqrt() / torque_noise * (0.5 * between_counts).sqrt()).powf(0.4)
}

/// The half width that each row of a session needs.
pub struct Widths<'s> {
    model: &'s Model,
    signals: &'s Signals<'s>,
    inertia: &'s [f64],
    /// [N·m or N] Permitted noise of each joint.
    noise: Vec<f64>,
    /// [(N·m)² or N²] Variance of the white noise of each recorded torque.
    pub white: Vec<f64>,
    /// [rad/s or m/s] Speed below which each joint counts as resting.
    pub rest: Vec<f64>,
    /// Kernel from which the speed is computed.
    rough: Kernel,
    /// [s] Smallest half width that this machine can need.
    pub narrowest: f64,
    sampling: &'s Sampling<'s>,
}

impl<'s> Widths<'s> {
    /// For a session in which samples nearer than `edge` [s] to the ends of their part get no row.
    pub fn new(
        model: &'s Model,
        signals: &'s Signals<'s>,
        asked: &Request<'s>,
        sampling: &'s Sampling<'s>,
        edge: f64,
    ) -> Self {
        let rough = rough(sampling.median);
        let speeds = |q: &&[f64]| {
            let of_part = |(number, part): (usize, &Range<usize>)| {
                let inner = sampling.inner(part, edge).step_by(STRIDE);
                inner.map(|i| sampling.window(&rough, i, number).averages(q).rate.abs()).fold(0.0, f64::max)
            };
            sampling.parts.iter().enumerate().map(of_part).fold(0.0, f64::max)
        };
        let fastest: Vec<f64> = signals.position.iter().map(speeds).collect();
        let rest = fastest.iter().enumerate().map(|(joint, fastest)| rest_speed(model, joint, *fastest)).collect();
        let permitted = |(joint, torque): (usize, &Vec<f64>)| {
            let of_torque = asked.noise.of_torque * root_mean_square(torque);
            let inertial = asked.inertia[joint] * asked.accelerations[joint];
            of_torque.min((asked.noise.of_acceleration.sqrt() * inertial).max(LEAST_SHARE * of_torque))
        };
        let noise = signals.torque.iter().enumerate().map(permitted).collect();
        let white = signals.torque.iter().map(|torque| white_noise(torque).powi(2)).collect();
        let mut widths = Self {
            model,
            signals,
            inertia: asked.inertia,
            noise,
            white,
            rest,
            rough,
            narrowest: HALF_WIDTHS[0],
            sampling,
        };
        // Counts of a joint that stands still are far apart in time, and would require the widest kernel.
        let moving = |joint: &usize| fastest[*joint] > widths.rest[*joint];
        for joint in (0..fastest.len()).filter(moving).collect::<Vec<_>>() {
            widths.narrowest = widths.narrowest.max(widths.wanted(joint, fastest[joint]));
        }
        let too_fast = (0..fastest.len()).filter_map(|joint| widths.too_fast(joint, edge));
        widths.narrowest = too_fast.fold(widths.narrowest, f64::max);
        widths
    }

    /// [s] Half width that one joint needs at a speed.
    fn wanted(&self, joint: usize, speed: f64) -> f64 {
        let step = self.model.joints[joint].encoder_step();
        wanted_half_width(step, speed, self.inertia[joint], self.noise[joint], self.sampling.median)
    }

    /// [s] Half width of rows without the motion of a joint that its link cannot follow, if there is such motion.
    fn too_fast(&self, joint: usize, edge: f64) -> Option<f64> {
        let nominal = &self.model.joints[joint];
        let link_inertia = self.inertia[joint] - nominal.reflected_inertia();
        let wide = resonance::half_width(nominal.resonance(link_inertia)).min(edge);
        if wide <= self.narrowest {
            return None;
        }
        let dt = self.sampling.median;
        let [narrow, wide] = [self.narrowest, wide].map(|width| Kernel::new(reach(width, dt), dt));
        let torque = root_mean_square(&self.signals.torque[joint]);
        let position = self.signals.position[joint];
        resonance::is_too_fast(position, self.sampling, [&narrow, &wide], edge, (link_inertia, torque))
            .then_some(wide.half_width)
    }

    /// The narrowest kernel of a ladder that leaves little noise in the typical rate of a joint's torque while it moves, or the widest. At reversals, which
    /// give no rows, rates are far larger.
    pub fn rate_rung(&self, joint: usize, ladder: &[Kernel], edge: f64) -> usize {
        let (position, torque) = (self.signals.position[joint], &self.signals.torque[joint]);
        let mut centres = self.sampling.centres(edge, (torque.len() / RATE_PLACES).max(1));
        let speed = |centre, part| self.sampling.window(&self.rough, centre, part).averages(position).rate.abs();
        centres.retain(|(centre, part)| speed(*centre, *part) > self.rest[joint]);
        let is_clear = |kernel: &Kernel| {
            let rate =
                |(centre, part): &(usize, usize)| self.sampling.window(kernel, *centre, *part).averages(torque).rate;
            kernel.rate_noise_gain() * self.white[joint] <= RATE_NOISE * typical(centres.iter().map(rate)).powi(2)
        };
        ladder.iter().position(is_clear).unwrap_or(ladder.len() - 1)
    }

    /// [s] Half width of the row at a sample of a part: the largest that a moving joint needs.
    pub fn at(&self, centre: usize, part: usize) -> f64 {
        let mut width = self.narrowest;
        let window = self.sampling.window(&self.rough, centre, part);
        for (joint, rest) in self.rest.iter().enumerate() {
            let speed = window.averages(self.signals.position[joint]).rate.abs();
            if speed > *rest {
                width = width.max(self.wanted(joint, speed));
            }
        }
        width
    }
}

/// Kernel of 30 ms to either side.
pub fn rough(dt: f64) -> Kernel {
    Kernel::new(reach(0.03, dt), dt)
}

/// Kernels of all half widths, the narrowest first.
pub fn ladder(dt: f64) -> Vec<Kernel> {
    let widths = std::iter::successors(Some(HALF_WIDTHS[0]), |width| Some(width * WIDTH_STEP));
    widths.take_while(|width| *width < HALF_WIDTHS[1]).map(|width| Kernel::new(reach(width, dt), dt)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::path::Path;

    use super::*;
    use crate::diagnose::rows::observe::observe;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::timeseries::JointSeries;

    /// `J` [kg·m²] of a regression of torque `J a + G sin q` on the rows' accelerations and weights, seen by an encoder of 45000 counts per turn of the joint, at
    /// 500 Hz.
    fn inertia_found(noise: Noise) -> f64 {
        const J: f64 = 0.25;
        const WEIGHT: f64 = 40.0;
        let text = format!("{MODEL}[joints.joint1.encoder]\ncounts_per_turn = 1000.0\n");
        let model = Model::from_texts(&text, ROBOT, Path::new("model.toml")).expect("a good model");
        let step = model.joints[0].encoder_step();
        let waves = [(0.5, 0.31 * TAU), (0.3, 0.13 * TAU), (0.02, 1.3 * TAU)];
        let time: Vec<f64> = (0..30_000).map(|k| 0.002 * f64::from(k)).collect();
        let (mut position, mut current) = (Vec::new(), Vec::new());
        for t in &time {
            let q: f64 = waves.iter().map(|(size, omega)| size * (omega * t).sin()).sum();
            let a: f64 = waves.iter().map(|(size, omega)| -size * omega * omega * (omega * t).sin()).sum();
            position.push((q / step).round() * step);
            current.push((J * a + WEIGHT * q.sin()) / model.joints[0].torque_per_ampere());
        }
        let channels = [(Channel::Position, position.into()), (Channel::Current, current.into())];
        let joint = JointSeries { name: "joint1".to_owned(), channels: channels.into() };
        let session = TimeSeries { name: "one".to_owned(), time, joints: vec![joint] };
        let motion = observe(&model, &[&session], &[J], noise).expect("enough motion");
        let m = &motion.joints[0];
        let sum = |x: &dyn Fn(usize) -> f64, y: &dyn Fn(usize) -> f64| (0..m.q.len()).map(|k| x(k) * y(k)).sum::<f64>();
        let (a, weight, torque) = (|k: usize| m.a[k], |k: usize| m.q[k].sin(), |k: usize| m.torque[k]);
        let [aa, aw, ww] = [sum(&a, &a), sum(&a, &weight), sum(&weight, &weight)];
        let [at, wt] = [sum(&a, &torque), sum(&weight, &torque)];
        (at * ww - wt * aw) / (aa * ww - aw * aw) / J
    }

    /// Noise of the acceleration lowers the inertia that a regression finds, however small it is beside a weight. Of the waves' mean square acceleration
    /// 0.42 is not in proportion to the position, as the weight nearly is: 0.5 % of the whole are 1.2 % of it. A quarter more for the formula of the noise.
    #[test]
    fn property_counts_of_an_encoder_do_not_lower_an_inertia() {
        let found = inertia_found(FAITHFUL);
        assert!((found - 1.0).abs() < 0.015, "{found}");
        let of_torque_alone = Noise { of_acceleration: f64::INFINITY, ..FAITHFUL };
        assert!(inertia_found(of_torque_alone) < 0.9, "{}", inertia_found(of_torque_alone));
    }
}
