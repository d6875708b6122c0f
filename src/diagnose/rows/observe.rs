//! From recordings to rows of smooth motion and torque.
//!
//! The kernel of a row is as [narrow](super::widths) as the encoder allows: narrow with a fine encoder and wide at low speed; and wide where rotors move
//! faster than their links can [follow](super::resonance). Widths, distances and weights are those of the true times of the samples, see [`Sampling`]; no
//! kernel reaches across a pause.

use super::direction::{direction, sticks};
use super::sampling::Sampling;
use super::signals::Signals;
use super::widths::{HALF_WIDTHS, Noise, Request, Widths, accelerations, ladder, reach, rough};
use crate::effects::{JointMotion, Motion};
use crate::error::{Error, Result};
use crate::robot::Model;
use crate::timeseries::{TimeSeries, give_back_memory};

/// [1] Distance of rows as a share of the narrowest half width.
const ROW_SPACING: f64 = 0.6;
/// Largest number of rows of a recording, so that the computing time grows slowly with its length.
const MOST_ROWS: usize = 24_000;

/// Converts sessions to rows, with as much noise of the acceleration as is permitted. `inertia` [kg·m² or kg] is a typical inertia of each joint with its rotor.
///
/// # Errors
/// A session lacks a channel of a joint, or is too short.
pub fn observe<'a>(model: &'a Model, sessions: &[&TimeSeries], inertia: &[f64], noise: Noise) -> Result<Motion<'a>> {
    let dof = model.joints.len();
    let mut motion = Motion {
        model,
        sessions: sessions.len(),
        start: sessions.iter().map(|session| session.time.first().copied().unwrap_or(0.0)).collect(),
        interval: sessions.iter().map(|session| session.sample_interval()).fold(0.0, f64::max),
        session: Vec::new(),
        part: Vec::new(),
        time: Vec::new(),
        half_width: Vec::new(),
        joints: vec![JointMotion::default(); dof],
    };
    let total: f64 = sessions.iter().filter_map(|s| Some(s.time.last()? - s.time.first()?)).sum();
    let accelerations = accelerations(model, sessions);
    let asked = Request { inertia, noise, accelerations: &accelerations, shortest_step: total / MOST_ROWS as f64 };
    for (number, session) in sessions.iter().enumerate() {
        let signals = Signals::of_session(model, session)?;
        let dt = session.sample_interval();
        // A coarse recording has few samples in a kernel, but never fewer than a kernel needs.
        let widest = reach(HALF_WIDTHS[1], dt);
        let sampling = Sampling::new(&session.time, dt);
        let longest = sampling.parts.iter().map(std::ops::Range::len).max().unwrap_or(0);
        if dt.is_nan() || dt <= 0.0 || longest < 4 * widest {
            return Err(Error::TooLittleData {
                quantity: "motion",
                joint: session.name.clone(),
                found: longest,
                unit: "samples without a pause",
                needed: 4 * widest,
                advice: "record at least a second without a pause",
            });
        }
        append(&mut motion, (number, session), &sampling, &signals, &asked);
        drop(signals);
        give_back_memory();
    }
    let names: Vec<&str> = sessions.iter().map(|session| session.name.as_str()).collect();
    load_gears(&mut motion, &names);
    if wind_up(&mut motion) {
        load_gears(&mut motion, &names);
    }
    Ok(motion)
}

/// Sets the torques and inertias of the nominal machine along the motion of its links.
fn load_gears(motion: &mut Motion, sessions: &[&str]) {
    let robot = &motion.model.robot;
    let (links, inertias) = (motion.inverse_dynamics(robot, false), motion.link_inertias(robot));
    for (index, (torque, inertia)) in links.into_iter().zip(inertias).enumerate() {
        let reflected = motion.model.joints[index].reflected_inertia();
        let joint = &mut motion.joints[index];
        joint.rigid = joint.a.iter().zip(&torque).map(|(a, link)| reflected * a + link).collect();
        (joint.link_torque, joint.link_inertia) = (torque, inertia);
    }
    motion.damp();
    motion.carry(sessions.iter().copied());
}

/// Winds up the gears whose stiffness is known under these torques; whether there are any. A gear that yields by 2 mrad under the weight of an
/// arm moves that weight by as much as friction changes. The links' motion relative to the rotors is left out.
fn wind_up(motion: &mut Motion) -> bool {
    for (joint, nominal) in motion.joints.iter_mut().zip(&motion.model.joints) {
        let softness = nominal.gear_stiffness.map_or(0.0, f64::recip);
        joint.wind_up = joint.link_torque.iter().map(|torque| softness * torque).collect();
    }
    motion.model.joints.iter().any(|joint| joint.gear_stiffness.is_some())
}

/// Appends the rows of a session, given with its number.
fn append(
    motion: &mut Motion,
    (number, session): (usize, &TimeSeries),
    sampling: &Sampling,
    signals: &Signals<'_>,
    asked: &Request,
) {
    let dt = sampling.median;
    let ladder = ladder(dt);
    let edge = ladder.last().map_or(rough(dt).half_width, |kernel| kernel.half_width);
    let widths = Widths::new(motion.model, signals, asked, sampling, edge);
    let of_rates: Vec<usize> = (0..signals.torque.len()).map(|joint| widths.rate_rung(joint, &ladder, edge)).collect();
    let mut noise = vec![Vec::new(); signals.torque.len()];
    let parts_before = motion.part.last().map_or(0, |last| last + 1);
    // The narrowest kernel that this machine can need sets the distance of the rows.
    let step = ((ROW_SPACING * widths.narrowest).max(asked.shortest_step) / dt).round().max(1.0) as usize;
    for (centre, part) in sampling.centres(edge, step) {
        let width = widths.at(centre, part);
        let rung = ladder.partition_point(|kernel| kernel.half_width < width).min(ladder.len() - 1);
        let window = sampling.window(&ladder[rung], centre, part);
        motion.session.push(number);
        motion.part.push(parts_before + part);
        motion.time.push(session.time[centre]);
        motion.half_width.push(window.half_width());
        for (joint, rest) in widths.rest.iter().enumerate() {
            let position = window.averages(signals.position[joint]);
            let torque = window.averages(&signals.torque[joint]);
            let row = &mut motion.joints[joint];
            row.q.push(position.value);
            row.v.push(position.rate);
            row.a.push(position.curvature);
            let averages = [position.rate, position.curvature, window.half_width()];
            let positions = &signals.position[joint][window.samples()];
            let step = motion.model.joints[joint].encoder_step();
            row.direction.push(direction(averages, *rest));
            row.sticks.push(f64::from(u8::from(sticks(averages, positions, step))));
            row.torque.push(torque.value);
            let of_rate = rung.max(of_rates[joint]);
            let rate = match of_rate > rung {
                true => sampling.window(&ladder[of_rate], centre, part).averages(&signals.torque[joint]).rate,
                false => torque.rate,
            };
            row.torque_rate.push(rate);
            noise[joint].push(ladder[of_rate].rate_noise_gain() * widths.white[joint]);
            row.has_current = signals.has_current[joint];
            row.left_out = row.left_out.or(signals.left_out[joint]);
        }
    }
    for (row, noise) in motion.joints.iter_mut().zip(&noise) {
        let first = row.torque_rate.len() - noise.len();
        shrink(&mut row.torque_rate[first..], noise, &row.direction[first..]);
    }
}

/// What rates [N·m/s] are likely to be, whose noise has the variance `N`: `λ x` with their reliability `λ = S/(S + N)` and the mean square `S` of what is no
/// noise, of rows that move in one direction. A regression on `λ x` has the coefficient of one on rates without noise.
/// Reference: R. J. Carroll, D. Ruppert, L. A. Stefanski, C. M. Crainiceanu (2006), Measurement Error in Nonlinear Models, ch. 4 (regression calibration).
fn shrink(rates: &mut [f64], noise: &[f64], direction: &[f64]) {
    let moving: Vec<usize> = (0..rates.len()).filter(|row| direction[*row].abs() == 1.0).collect();
    let mean = |of: &dyn Fn(usize) -> f64| moving.iter().map(|row| of(*row)).sum::<f64>() / moving.len().max(1) as f64;
    let signal = mean(&|row| rates[row].powi(2) - noise[row]).max(0.0);
    for (rate, noise) in rates.iter_mut().zip(noise).filter(|(_, noise)| **noise > 0.0) {
        *rate *= signal / (signal + noise);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::diagnose::rows::widths::FAITHFUL;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::timeseries::{Channel, JointSeries, root_mean_square};

    /// Rates of the rows of a torque `3 sin(2π f t)` N·m with noise [N·m] at 500 Hz, and the true ones.
    fn rates(frequency: f64, noise: f64) -> [Vec<f64>; 2] {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let omega = TAU * frequency;
        let time: Vec<f64> = (0..60_000).map(|k| 0.002 * f64::from(k)).collect();
        let position: Vec<f64> = time.iter().map(|t| 0.8 * (TAU * 0.3 * t).sin()).collect();
        let per_ampere = model.joints[0].torque_per_ampere();
        let current: Vec<f64> =
            time.iter().map(|t| (3.0 * (omega * t).sin() + noise * normal()) / per_ampere).collect();
        let channels = [(Channel::Position, position.into()), (Channel::Current, current.into())];
        let joint = JointSeries { name: "joint1".to_owned(), channels: channels.into() };
        let session = TimeSeries { name: "one".to_owned(), time, joints: vec![joint] };
        let mut motion = observe(&model, &[&session], &[0.25], FAITHFUL).expect("enough motion");
        let truth = motion.time.iter().map(|t| 3.0 * omega * (omega * t).cos()).collect();
        [std::mem::take(&mut motion.joints[0].torque_rate), truth]
    }

    /// RMS error of such rates, relative to their RMS.
    fn error_of_rates(frequency: f64, noise: f64) -> f64 {
        let [rates, truth] = rates(frequency, noise);
        let errors: Vec<f64> = rates.iter().zip(&truth).map(|(rate, truth)| rate - truth).collect();
        root_mean_square(&errors) / root_mean_square(&truth)
    }

    /// Even the widest kernel, of 0.2 s, leaves noise. Some 300 kernels lie in the recording: the mean square that is left of it is known within 8 %, of which
    /// the share of the noise, a fourth, counts for the slope; five times that.
    #[test]
    fn property_noise_in_rates_does_not_lower_a_coefficient() {
        let [rates, truth] = rates(0.05, 0.5);
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let slope = sum(&rates, &truth) / sum(&rates, &rates);
        assert!((slope - 1.0).abs() < 0.1, "{slope}");
        // The correlation says that there is noise.
        let reliability = sum(&rates, &truth).powi(2) / (sum(&rates, &rates) * sum(&truth, &truth));
        assert!(reliability < 0.9, "{reliability}");
    }

    #[test]
    fn property_the_rate_of_a_torque_has_little_noise_and_is_no_slower_than_that_needs() {
        // Noise is at most 0.02 of the square of the typical rate, which is 1.1 times the amplitude of a sine: 0.044 of its mean square, 21 %.
        assert!(error_of_rates(0.4, 0.15) < 0.21);
        // The narrowest kernel, of 7 ms, lowers a wave of 10 Hz by (62.8 · 0.007)²/14 = 1.4 %.
        assert!(error_of_rates(10.0, 0.0) < 0.02);
    }
}
