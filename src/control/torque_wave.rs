//! Torque of a motor that is imposed instead of controlled: a wave about zero.
//!
//! ```text
//!   square    ┌──┐  ┌──┐  +A          triangle   /\    /\    +A
//!           __│  │  │  │__                   ___/  \  /  \___
//!                └──┘  └──┘ −A                      \/    \/  −A
//!             |  P  |                             |  P  |
//! ```
//! Sign: positive torque drives the joint positively. The last quarter of a triangle returns to zero.

/// Shape of a wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// `+A`, then `−A`, half a period each.
    Square,
    /// From 0 to `+A`, `−A` and back to 0 at a constant rate.
    Triangle,
}

/// A wave of torque; outside it the joint is controlled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueWave {
    /// Its shape.
    pub shape: Shape,
    /// `A` [N·m or N] > 0, at the joint.
    pub amplitude: f64,
    /// `P` [s] > 0.
    pub period: f64,
    /// Number of periods, > 0.
    pub cycles: f64,
    /// [s] Start, ≥ 0.
    pub start: f64,
}

impl TorqueWave {
    /// [s] Duration.
    pub fn duration(&self) -> f64 {
        self.period * self.cycles
    }

    /// [N·m or N] The torque at a time [s]; `None` before the wave and after it.
    pub fn at(&self, time: f64) -> Option<f64> {
        let since = time - self.start;
        if !(0.0..self.duration()).contains(&since) {
            return None;
        }
        let phase = (since / self.period).fract();
        Some(match self.shape {
            Shape::Square if phase < 0.5 => self.amplitude,
            Shape::Square => -self.amplitude,
            Shape::Triangle if phase < 0.25 => 4.0 * phase * self.amplitude,
            Shape::Triangle if phase < 0.75 => (2.0 - 4.0 * phase) * self.amplitude,
            Shape::Triangle => (4.0 * phase - 4.0) * self.amplitude,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_waves_have_their_values() {
        let wave = TorqueWave { shape: Shape::Triangle, amplitude: 2.0, period: 4.0, cycles: 2.0, start: 1.0 };
        let expected =
            [(0.5, None), (1.0, Some(0.0)), (2.0, Some(2.0)), (3.0, Some(0.0)), (4.0, Some(-2.0)), (4.5, Some(-1.0))];
        for (time, torque) in expected {
            assert_eq!(wave.at(time), torque, "{time}");
        }
        assert_eq!((wave.at(8.9).is_some(), wave.at(9.0)), (true, None));
        let square = TorqueWave { shape: Shape::Square, ..wave };
        assert_eq!([1.0, 2.9, 3.1].map(|time| square.at(time)), [Some(2.0), Some(2.0), Some(-2.0)]);
    }
}
