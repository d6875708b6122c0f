//! The planar arm with both gearheads in closed loop, along motions that the tests and `benches/peers` share.
#![allow(dead_code)]

use super::machines::{C1, C2, I1, I2, L1, M1, M2};
use super::reference;

/// The machine of `scara` as the reference wants it.
pub fn arm() -> reference::Arm {
    let gears = [
        (5.375, 6.29e-4, 0.0103, 0.442, 0.509, 0.0603, 0.407),
        (10.0 / 3.0, 1.903e-3, 0.0064, 0.173, 0.187, 0.0408, 0.187),
    ]
    .map(|(ratio, rotor, gap, coulomb, breakaway, stribeck, viscous)| reference::Gearhead {
        rotor: ratio * ratio * rotor,
        k: 3000.0,
        d: 2.0,
        gap,
        coulomb,
        breakaway,
        stribeck,
        viscous,
        link_share: 0.4,
        kt: ratio * 0.023,
        r: 0.5,
        l: 0.0005,
        volts: 24.0,
        amperes: 18.0,
        loop_time: 4e-4,
    });
    reference::Arm { a: I1 + M1 * C1 * C1 + M2 * L1 * L1, b: I2 + M2 * C2 * C2, c: M2 * L1 * C2, gears }
}

/// A PI velocity controller a joint, sampled at 1 kHz.
#[derive(Default)]
pub struct Loop {
    integral: [f64; 2],
}

impl Loop {
    /// Currents [A] for these velocities [rad/s].
    pub fn command(&mut self, wanted: [f64; 2], velocity: [f64; 2]) -> [f64; 2] {
        let (kp, ki, kt) = ([5.0, 1.5], [50.0, 15.0], [5.375 * 0.023, 10.0 / 3.0 * 0.023]);
        let mut command = [0.0; 2];
        for j in 0..2 {
            let error = wanted[j] - velocity[j];
            self.integral[j] += ki[j] * error * 1e-3;
            command[j] = (kp[j] * error + self.integral[j]) / kt[j];
        }
        command
    }
}

/// Velocities wanted of both joints [rad/s] at a time.
pub type Motion = fn(f64) -> [f64; 2];

/// Motor and link angles, a row a millisecond.
pub type Trace = Vec<[f64; 4]>;

/// Up to 120 deg/s on both joints, with reversals.
pub fn fast(t: f64) -> [f64; 2] {
    [2.0 * (3.1 * t).sin() * (0.7 * t).cos(), 2.0 * (4.3 * t + 0.4).sin() * (0.5 * t + 0.3).sin()]
}

/// One joint at a time to and fro, at rest in between: it sticks, breaks away, crosses the gap.
pub fn slow(t: f64) -> [f64; 2] {
    let speed = [0.009, -0.009, 0.03, -0.03, 0.0, 0.1, -0.1, 0.0][(2.0 * t) as usize % 8];
    if t < 2.0 { [speed, 0.0] } else { [0.0, speed] }
}

/// What the reference says.
pub fn truth(motion: Motion, seconds: f64, tolerance: f64) -> Trace {
    let mut run = reference::Run::at_rest(arm(), [0.0, 0.0], tolerance);
    let mut control = Loop::default();
    let step = |k: usize| {
        run.advance(&control.command(motion(k as f64 * 1e-3), [run.y[1], run.y[6]]), 1e-3);
        [run.y[0], run.y[2], run.y[5], run.y[7]]
    };
    (0..(seconds * 1e3) as usize).map(step).collect()
}
