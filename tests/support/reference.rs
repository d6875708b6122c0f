//! An independent reference: Dormand-Prince 5(4) with step control, and the planar arm with two gearheads in closed form.
//!
//! It shares no code with the program. Contact and voltage limit are branches that the step control resolves; where a rotor
//! or link comes to rest or breaks away, the instant is bracketed by taking the step again with half its length. Which of the
//! links at rest stick is found by trying all combinations.
#![allow(dead_code)]

/// A step of Dormand-Prince (J. R. Dormand, P. J. Prince 1980): the state after `h`, and the estimated error of each component.
pub fn dormand_prince<const N: usize>(
    rate: impl Fn(&[f64; N]) -> [f64; N],
    start: &[f64; N],
    h: f64,
) -> ([f64; N], [f64; N]) {
    const A: [[f64; 6]; 6] = [
        [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
        [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
        [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
        [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ];
    const E: [f64; 7] =
        [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
    let mut k = [[0.0; N]; 7];
    k[0] = rate(start);
    let mut y = *start;
    for stage in 0..6 {
        y = *start;
        for (slope, a) in k.iter().zip(A[stage]) {
            for (y, slope) in y.iter_mut().zip(slope) {
                *y += h * a * slope;
            }
        }
        k[stage + 1] = rate(&y);
    }
    (y, std::array::from_fn(|c| (0..7).map(|s| h * E[s] * k[s][c]).sum()))
}

/// Integrates smooth equations over a duration, the error of every step and component below the tolerance.
pub fn integrate<const N: usize>(
    rate: impl Fn(&[f64; N]) -> [f64; N],
    start: [f64; N],
    duration: f64,
    tolerance: f64,
) -> [f64; N] {
    let (mut y, mut t, mut h) = (start, 0.0, duration.min(1e-4));
    while duration - t > 1e-15 {
        h = h.min(duration - t);
        let (end, error) = dormand_prince(&rate, &y, h);
        let worst = error.iter().fold(0.0_f64, |worst, e| worst.max(e.abs())) / tolerance;
        if worst <= 1.0 {
            (y, t) = (end, t + h);
        }
        h *= (0.9 * worst.max(1e-6).powf(-0.2)).clamp(0.2, 5.0);
    }
    y
}

/// Numbers of one joint, joint side.
#[derive(Clone, Copy)]
pub struct Gearhead {
    pub rotor: f64,
    pub k: f64,
    pub d: f64,
    pub gap: f64,
    pub coulomb: f64,
    pub breakaway: f64,
    pub stribeck: f64,
    pub viscous: f64,
    pub link_share: f64,
    /// Torque per ampere; back-EMF per velocity.
    pub kt: f64,
    pub r: f64,
    pub l: f64,
    pub volts: f64,
    pub amperes: f64,
    pub loop_time: f64,
}

/// `a + 2c cos q2`, `b + c cos q2`, `b`: the planar arm's mass matrix.
#[derive(Clone, Copy)]
pub struct Arm {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub gears: [Gearhead; 2],
}

/// θ1 ω1 q1 v1 i1 θ2 ω2 q2 v2 i2.
pub type Y = [f64; 10];

/// Direction of slip of rotor 1, link 1, rotor 2, link 2: 0 sticks.
pub type Slips = [i32; 4];

/// Where the velocity of a body stands in the state.
const VELOCITY: [usize; 4] = [1, 3, 6, 8];

pub struct Run {
    pub arm: Arm,
    pub t: f64,
    pub y: Y,
    pub slips: Slips,
    pub h: f64,
    /// [rad] Largest error of a position in a step.
    pub tolerance: f64,
}

struct Forces {
    rate: Y,
    /// What friction would have to be to hold the body.
    hold: [f64; 4],
}

impl Arm {
    fn friction(&self, body: usize, speed: f64) -> f64 {
        let g = &self.gears[body / 2];
        let share = if body.is_multiple_of(2) { 1.0 - g.link_share } else { g.link_share };
        share * (g.coulomb + (g.breakaway - g.coulomb) * (-speed / g.stribeck).exp() + g.viscous * speed)
    }

    fn gear_torque(&self, joint: usize, y: &Y) -> f64 {
        let g = &self.gears[joint];
        let s = 5 * joint;
        let (x, xd) = (y[s] - y[s + 2], y[s + 1] - y[s + 3]);
        if x > 0.5 * g.gap {
            (g.k * (x - 0.5 * g.gap) + g.d * xd).max(0.0)
        } else if x < -0.5 * g.gap {
            (g.k * (x + 0.5 * g.gap) + g.d * xd).min(0.0)
        } else {
            0.0
        }
    }

    fn forces(&self, y: &Y, command: &[f64; 2], slips: &Slips) -> Forces {
        let mut rate = [0.0; 10];
        let mut hold = [0.0; 4];
        let mut load = [0.0; 2];
        for j in 0..2 {
            let g = &self.gears[j];
            let s = 5 * j;
            let torque = self.gear_torque(j, y);
            let i = y[s + 4];
            let wanted = g.r * i + g.kt * y[s + 1] + g.l * (command[j].clamp(-g.amperes, g.amperes) - i) / g.loop_time;
            rate[s + 4] = (wanted.clamp(-g.volts, g.volts) - g.r * i - g.kt * y[s + 1]) / g.l;
            rate[s] = y[s + 1];
            rate[s + 2] = y[s + 3];
            hold[2 * j] = g.kt * i - torque;
            let sign = f64::from(slips[2 * j]);
            let slip = self.friction(2 * j, sign * y[s + 1]);
            rate[s + 1] = if slips[2 * j] == 0 { 0.0 } else { (hold[2 * j] - sign * slip) / g.rotor };
            let sign = f64::from(slips[2 * j + 1]);
            load[j] = torque;
            if slips[2 * j + 1] != 0 {
                load[j] -= sign * self.friction(2 * j + 1, sign * y[s + 3]);
            }
        }
        let (cos, sin) = (y[7].cos(), y[7].sin());
        let (m11, m12, m22) = (self.a + self.b + 2.0 * self.c * cos, self.b + self.c * cos, self.b);
        let (v1, v2) = (y[3], y[8]);
        let r1 = load[0] + self.c * sin * (2.0 * v1 * v2 + v2 * v2);
        let r2 = load[1] - self.c * sin * v1 * v1;
        match (slips[1] == 0, slips[3] == 0) {
            (false, false) => {
                let det = m11 * m22 - m12 * m12;
                rate[3] = (m22 * r1 - m12 * r2) / det;
                rate[8] = (m11 * r2 - m12 * r1) / det;
            }
            (true, false) => {
                rate[8] = r2 / m22;
                hold[1] = r1 - m12 * rate[8];
            }
            (false, true) => {
                rate[3] = r1 / m11;
                hold[3] = r2 - m12 * rate[3];
            }
            (true, true) => {
                hold[1] = r1;
                hold[3] = r2;
            }
        }
        Forces { rate, hold }
    }

    /// The only combination of slips of the bodies at rest that contradicts nothing.
    fn decide(&self, y: &Y, command: &[f64; 2], slips: &Slips) -> Slips {
        let resting: Vec<usize> = (0..4).filter(|&b| y[VELOCITY[b]] == 0.0).collect();
        for code in 0..3_usize.pow(resting.len() as u32) {
            let mut trial = *slips;
            let mut rest = code;
            for &b in &resting {
                trial[b] = [0, 1, -1][rest % 3];
                rest /= 3;
            }
            let forces = self.forces(y, command, &trial);
            let fits = resting.iter().all(|&b| match trial[b] {
                0 => forces.hold[b].abs() <= self.friction(b, 0.0),
                s => f64::from(s) * forces.rate[VELOCITY[b]] > 0.0,
            });
            if fits {
                return trial;
            }
        }
        *slips
    }

    /// Bodies whose slip has ended.
    fn violated(&self, y: &Y, command: &[f64; 2], slips: &Slips) -> Option<usize> {
        let forces = self.forces(y, command, slips);
        (0..4).find(|&b| match slips[b] {
            0 => forces.hold[b].abs() > self.friction(b, 0.0),
            s => f64::from(s) * y[VELOCITY[b]] < 0.0,
        })
    }
}

impl Run {
    pub fn at_rest(arm: Arm, q: [f64; 2], tolerance: f64) -> Self {
        let mut y = [0.0; 10];
        (y[0], y[2], y[5], y[7]) = (q[0], q[0], q[1], q[1]);
        Self { arm, t: 0.0, y, slips: [0; 4], h: 1e-6, tolerance }
    }

    /// One step: the state, and the estimate of its error against the tolerance.
    fn step(&self, command: &[f64; 2], h: f64) -> (Y, f64) {
        let (y, error) = dormand_prince(|y| self.arm.forces(y, command, &self.slips).rate, &self.y, h);
        // Positions weigh as much as velocities over a millisecond; currents over an ampere.
        let scale = [1.0, 10.0, 1.0, 10.0, 10.0];
        let worst = (0..10).fold(0.0_f64, |worst, c| worst.max(error[c].abs() / scale[c % 5]));
        (y, worst / self.tolerance)
    }

    /// Integrates for a duration under a constant command.
    pub fn advance(&mut self, command: &[f64; 2], duration: f64) {
        const SHORTEST: f64 = 1e-10;
        let until = self.t + duration;
        self.slips = self.arm.decide(&self.y, command, &self.slips);
        while until - self.t > 1e-13 {
            let mut h = self.h.min(until - self.t);
            let (mut y, mut error) = self.step(command, h);
            while error > 1.0 && h > SHORTEST {
                h = (h * (0.9 * error.powf(-0.2)).clamp(0.1, 0.9)).max(SHORTEST);
                (y, error) = self.step(command, h);
            }
            if self.arm.violated(&y, command, &self.slips).is_some() {
                // The last instant at which nothing is violated, then the body concerned comes to rest or may break away.
                let (mut low, mut high) = (0.0, h);
                while high - low > 1e-14 {
                    let middle = 0.5 * (low + high);
                    let (trial, _) = self.step(command, middle);
                    if self.arm.violated(&trial, command, &self.slips).is_some() { high = middle } else { low = middle }
                }
                y = self.step(command, high).0;
                self.t += high;
                self.y = y;
                if let Some(body) = self.arm.violated(&y, command, &self.slips) {
                    if self.slips[body] == 0 {
                        let hold = self.arm.forces(&y, command, &self.slips).hold[body];
                        self.slips[body] = if hold > 0.0 { 1 } else { -1 };
                    } else {
                        self.y[VELOCITY[body]] = 0.0;
                        self.slips = self.arm.decide(&self.y, command, &self.slips);
                    }
                }
                self.h = 1e-6;
                continue;
            }
            self.t += h;
            self.y = y;
            self.h = h * (0.9 * error.max(1e-6).powf(-0.2)).clamp(0.2, 5.0);
        }
        self.t = until;
    }
}
