//! A reduced copy of a long recording for display: a few thousand samples of each signal.

use std::collections::BTreeMap;

use super::{Channel, TimeSeries};

/// Number of stretches of a signal; of each, the lowest and the highest sample are kept.
const STRETCHES: usize = 2500;
/// Largest number of poses of a motion.
const POSES: usize = 1500;

/// The lowest and the highest sample of each of `STRETCHES` equal stretches of a signal, in their order. A signal of at
/// most twice as many samples is kept completely.
#[derive(Debug, Clone, PartialEq)]
pub struct Envelope {
    /// [s] Times of the samples that are kept.
    pub time: Vec<f64>,
    /// The samples that are kept.
    pub values: Vec<f64>,
    /// Number of samples in a stretch.
    size: usize,
    /// The present stretch: number of its samples, and time and value of its lowest and highest.
    seen: usize,
    low: (usize, f64, f64),
    high: (usize, f64, f64),
}

impl Envelope {
    /// For a signal of this many samples.
    pub fn new(samples: usize) -> Self {
        let size = samples.div_ceil(STRETCHES).max(1);
        let size = if size <= 2 { 1 } else { size };
        let nothing = (0, 0.0, 0.0);
        Self { time: Vec::new(), values: Vec::new(), size, seen: 0, low: nothing, high: nothing }
    }

    /// From a complete signal.
    pub fn of(time: &[f64], values: impl ExactSizeIterator<Item = f64>) -> Self {
        let mut envelope = Self::new(values.len());
        time.iter().zip(values).for_each(|(time, value)| envelope.push(*time, value));
        envelope.finish();
        envelope
    }

    /// Adds the next sample.
    pub fn push(&mut self, time: f64, value: f64) {
        let sample = (self.seen, time, value);
        // Of equal samples, the first counts as the lowest and the last as the highest.
        if self.seen == 0 || value.total_cmp(&self.low.2).is_lt() {
            self.low = sample;
        }
        if self.seen == 0 || value.total_cmp(&self.high.2).is_ge() {
            self.high = sample;
        }
        self.seen += 1;
        if self.seen == self.size {
            self.finish();
        }
    }

    /// Ends the last stretch, which may be shorter than the others.
    pub fn finish(&mut self) {
        if self.seen == 0 {
            return;
        }
        let (first, second) = if self.low.0 <= self.high.0 { (self.low, self.high) } else { (self.high, self.low) };
        self.keep(first);
        if first.0 != second.0 {
            self.keep(second);
        }
        self.seen = 0;
    }

    fn keep(&mut self, (_, time, value): (usize, f64, f64)) {
        self.time.push(time);
        self.values.push(value);
    }
}

/// A session, reduced for display.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawn {
    /// Name of the session.
    pub name: String,
    /// [s] Time of the last sample; 0 where there is none.
    pub end: f64,
    /// [s] Times of the machine's poses.
    pub times: Vec<f64>,
    /// The joints that were recorded.
    pub joints: Vec<DrawnJoint>,
}

/// A joint, reduced for display.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DrawnJoint {
    /// Name of the joint in the URDF.
    pub name: String,
    /// The channels, reduced.
    pub channels: BTreeMap<Channel, Envelope>,
    /// [rad or m] Position in the gap, rotor minus link, if both are known.
    pub travel: Option<Envelope>,
    /// [rad or m] Position of the link, else of the motor, at [`Drawn::times`]; empty if neither is known.
    pub pose: Vec<f64>,
}

/// Number of samples from one kept pose to the next, for a session of `samples`.
pub const fn pose_step(samples: usize) -> usize {
    let step = samples.div_ceil(POSES);
    if step == 0 { 1 } else { step }
}

impl Drawn {
    /// Reduces a session.
    pub fn of(session: &TimeSeries) -> Self {
        let step = pose_step(session.len());
        let drawn = |values: &[f64]| Envelope::of(&session.time, values.iter().copied());
        let joints = session.joints.iter().map(|joint| {
            let sides = (joint.get(Channel::TrueMotorPosition), joint.get(Channel::TrueLinkPosition));
            let travel = match sides {
                (Some(motor), Some(link)) => {
                    Some(Envelope::of(&session.time, motor.iter().zip(link).map(|(motor, link)| motor - link)))
                }
                _ => None,
            };
            // A second encoder is left out: the gap is not seen in a picture, and where axes are coupled it reads another angle.
            let pose =
                joint.get(Channel::TrueLinkPosition).or_else(|| joint.get(Channel::Position)).unwrap_or_default();
            DrawnJoint {
                name: joint.name.clone(),
                channels: joint.channels.iter().map(|(channel, values)| (*channel, drawn(values))).collect(),
                travel,
                pose: pose.iter().step_by(step).copied().collect(),
            }
        });
        Self {
            name: session.name.clone(),
            end: session.time.last().copied().unwrap_or(0.0),
            times: session.time.iter().step_by(step).copied().collect(),
            joints: joints.collect(),
        }
    }

    /// The joint of that name.
    pub fn joint(&self, name: &str) -> Option<&DrawnJoint> {
        self.joints.iter().find(|joint| joint.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::{Envelope, STRETCHES};

    fn times(samples: usize) -> Vec<f64> {
        (0..samples).map(|k| k as f64).collect()
    }

    #[test]
    fn property_an_envelope_keeps_the_extremes_of_each_stretch() {
        let values: Vec<f64> = (0..20_000).map(|k| f64::from(k * k % 7919)).collect();
        let kept = Envelope::of(&times(values.len()), values.iter().copied());
        assert!(kept.values.len() <= 2 * STRETCHES);
        assert!(kept.time.windows(2).all(|pair| pair[0] < pair[1]));
        for (stretch, chunk) in values.chunks(8).enumerate() {
            let inside = |time: &f64| (*time / 8.0) as usize == stretch;
            let kept = kept.time.iter().zip(&kept.values).filter(|(time, _)| inside(time)).map(|(_, value)| *value);
            let (low, high) = kept.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
            assert_eq!(low, chunk.iter().copied().fold(f64::MAX, f64::min));
            assert_eq!(high, chunk.iter().copied().fold(f64::MIN, f64::max));
        }
    }

    #[test]
    fn property_a_short_signal_is_kept_whole() {
        let values: Vec<f64> = (0..2 * STRETCHES).map(|k| (k as f64).sin()).collect();
        assert_eq!(Envelope::of(&times(values.len()), values.iter().copied()).values, values);
    }
}
