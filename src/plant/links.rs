//! The links between two answers of their engine: built-in algorithms, corrected by their difference from the engine.
//!
//! ```text
//!   M(q) = M_own(q) + δM(t)          δM = M_engine − M_own, δh = h_engine − h_own, where the engine was asked
//!   h(q, q̇) = h_own(q, q̇) + δh(t)    in between: along the line through the last two
//! ```
//! An engine with a world around it costs twenty times as much as the bare algorithms. The two agree to rounding, so that the
//! difference hardly changes. Its change is measured whenever the engine is asked, and decides when the engine is asked again.
//! If the engine differs, by a payload for instance, the motion is that of the engine, which is then asked more often.

use nalgebra::DMatrix;

use super::rigid_body::RigidBody;
use crate::dynamics::Dynamics;

/// [rad/s² or m/s²] Largest change of the difference that counts as none, as the acceleration that it causes.
const AGREES: f64 = 1e-6;

/// [rad/s² or m/s²] Accelerations at which a difference in `M` is judged.
const TYPICAL: f64 = 10.0;

/// The links, as an engine sees them.
pub struct Links {
    /// The engine, which corrects the built-in algorithms.
    pub engine: Box<dyn RigidBody>,
    carrier: Option<Carrier>,
}

/// The built-in algorithms, and the engine's difference from them.
struct Carrier {
    own: Dynamics,
    /// [s] of the last two answers, newest first; both the same after the first.
    times: [f64; 2],
    /// `δM` column by column, then `δh`.
    differences: [Vec<f64>; 2],
    mass: DMatrix<f64>,
    h: Vec<f64>,
    /// [s] from one answer to the next, and the longest.
    interval: f64,
    longest: f64,
}

impl Links {
    /// Asks the engine at every evaluation.
    pub fn asked(engine: Box<dyn RigidBody>) -> Self {
        Self { engine, carrier: None }
    }

    /// Asks the engine from time to time, every `longest` [s] at least, and in between uses these algorithms, corrected by its answers.
    pub fn carried(engine: Box<dyn RigidBody>, own: Dynamics, longest: f64) -> Self {
        let n = own.dof();
        let differences = [vec![0.0; n * n + n], vec![0.0; n * n + n]];
        let (mass, h) = (DMatrix::zeros(n, n), vec![0.0; n]);
        Self { engine, carrier: Some(Carrier { own, times: [0.0; 2], differences, mass, h, interval: 0.0, longest }) }
    }

    /// Whether the engine should be asked at a time.
    pub fn is_due(&self, time: f64) -> bool {
        self.carrier.as_ref().is_some_and(|carrier| time >= carrier.times[0] + carrier.interval - 1e-9)
    }

    /// Asks the engine at the first state of a motion.
    pub fn start(&mut self, time: f64, q: &[f64], v: &[f64]) {
        self.ask(time, q, v);
        if let Some(carrier) = &mut self.carrier {
            carrier.times[1] = time;
            carrier.interval = 0.0;
        }
    }

    /// Asks the engine at a state that the motion has reached.
    pub fn ask(&mut self, time: f64, q: &[f64], v: &[f64]) {
        let Self { engine, carrier: Some(carrier) } = self else { return };
        engine.evaluate(q, v, &mut carrier.mass, &mut carrier.h);
        carrier.take(time, q, v);
    }

    /// Writes `M(q)` and `h(q, q̇)` at a time.
    pub fn evaluate(&mut self, time: f64, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]) {
        match &mut self.carrier {
            None => self.engine.evaluate(q, v, mass, h),
            Some(carrier) => carrier.evaluate(time, q, v, mass, h),
        }
    }
}

impl Carrier {
    fn evaluate(&mut self, time: f64, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]) {
        self.own.mass_matrix_and_bias(q, v, mass, h);
        let [newest, oldest] = self.times;
        let share = if newest > oldest { (time - newest) / (newest - oldest) } else { 0.0 };
        let differences = self.differences[0].iter().zip(&self.differences[1]);
        for (value, (new, old)) in mass.iter_mut().chain(h).zip(differences) {
            *value += new + share * (new - old);
        }
    }

    /// Stores the engine's answer, and decides when to ask again.
    fn take(&mut self, time: f64, q: &[f64], v: &[f64]) {
        let n = self.h.len();
        let mut mass = std::mem::replace(&mut self.mass, DMatrix::zeros(0, 0));
        let mut h = std::mem::take(&mut self.h);
        let said = mass.iter().chain(&h);
        self.differences.swap(0, 1);
        self.differences[0].iter_mut().zip(said).for_each(|(difference, said)| *difference = *said);
        self.own.mass_matrix_and_bias(q, v, &mut mass, &mut h);
        self.differences[0].iter_mut().zip(mass.iter().chain(&h)).for_each(|(difference, own)| *difference -= own);
        let changed = |entry: usize| (self.differences[0][entry] - self.differences[1][entry]).abs();
        let miss = (0..n).map(|i| {
            let torque: f64 = (0..n).map(|j| changed(j * n + i) * TYPICAL).sum::<f64>() + changed(n * n + i);
            torque / mass[(i, i)]
        });
        let agrees = miss.fold(0.0, f64::max) <= AGREES;
        let passed = time - self.times[0];
        self.interval = if agrees { (2.0 * passed).min(self.longest) } else { 0.0 };
        self.times = [time, self.times[0]];
        (self.mass, self.h) = (mass, h);
    }
}
