//! How errors of a state grow: the derivative of the motion over an interval, carried beside it.
//!
//! ```text
//!   δẏ = A δy + B δτ,     δθ̈_i = ∂θ̈_i/∂y_i δy_i + δτ_i/J_i        δq̈ = W' (∂load/∂y δy + δτ_l)
//!   X ← X + h (A X + B) + h²/2 A (A X + B) + h³/6 A² (A X + B)
//! ```
//! `X` has a column for each state at the start of the interval (the transition matrix `F`), one for a torque on each rotor and one for a torque on each
//! link that is constant over the interval (the response `G`). A side at rest does not respond: its velocity has no error. `W'` is `W` with the
//! links that stick held: `W' = W − W_:S W_SS⁻¹ W_S:`.
//! The third order leaves `(ω h)⁴/24` of an oscillation: 3e-4 at the longest step of a gear.
//! Sign: as the torques and states themselves. States are in the order `4 i + (θ, θ̇, q, q̇)`.
//! Reference: M. di Bernardo et al. (2008), Piecewise-smooth dynamical systems, section 2.5, for what happens at events.

use super::carried::slopes_of;
use super::machine::Machine;
use super::state::State;
use crate::gearhead::Slip;

/// Slopes of all laws at a state.
pub(super) struct Slopes {
    /// `∂(θ̈, load)/∂(θ, θ̇, q, q̇)`, one per joint.
    own: Vec<[[f64; 4]; 2]>,
    /// `1/J`, zero for a rotor that sticks.
    rotor: Vec<f64>,
    /// `W'` row by row, zero for links that stick.
    mobility: Vec<f64>,
}

impl Slopes {
    /// For so many joints.
    pub fn new(n: usize) -> Self {
        Self { own: vec![[[0.0; 4]; 2]; n], rotor: vec![0.0; n], mobility: vec![0.0; n * n] }
    }

    /// Takes the slopes at the state, under the response found last.
    pub fn take(&mut self, machine: &Machine, state: &State, currents: &[f64]) {
        let n = self.rotor.len();
        for (i, current) in currents.iter().enumerate() {
            self.own[i] = slopes_of(machine, state, i, *current);
            let stuck = state.modes[i].rotor == Slip::Stuck;
            self.rotor[i] = if stuck { 0.0 } else { 1.0 / machine.coupled.laws[i].rotor_inertia };
            self.mobility[i * n..(i + 1) * n].copy_from_slice(machine.response.row(i));
        }
        for s in (0..n).filter(|s| state.modes[*s].link == Slip::Stuck) {
            self.hold(s);
        }
    }

    /// Holds a link.
    fn hold(&mut self, s: usize) {
        let n = self.rotor.len();
        let pivot = self.mobility[s * n + s];
        let row: Vec<f64> = self.mobility[s * n..(s + 1) * n].to_vec();
        for i in 0..n {
            let factor = self.mobility[i * n + s] / pivot;
            let held = self.mobility[i * n..(i + 1) * n].iter_mut().zip(&row);
            held.for_each(|(w, row)| *w -= factor * row);
        }
        for k in 0..n {
            self.mobility[s * n + k] = 0.0;
            self.mobility[k * n + s] = 0.0;
        }
    }
}

/// The derivative of a motion over an interval.
#[derive(Debug, Clone)]
pub struct Tangent {
    n: usize,
    width: usize,
    x: Vec<f64>,
    /// `h^k/k! A^{k−1} (A X + B)`, and the product after it.
    terms: [Vec<f64>; 2],
    loads: Vec<f64>,
}

impl Tangent {
    /// For so many joints, at the start of an interval.
    pub fn new(n: usize) -> Self {
        let width = 6 * n;
        let zeros = || vec![0.0; 4 * n * width];
        let mut tangent = Self { n, width, x: zeros(), terms: [zeros(), zeros()], loads: vec![0.0; n * width] };
        tangent.restart();
        tangent
    }

    /// Begins an interval: errors are what they are.
    pub fn restart(&mut self) {
        self.x.fill(0.0);
        for k in 0..4 * self.n {
            self.x[k * self.width + k] = 1.0;
        }
    }

    /// `∂y_row/∂y_column`, the change of a state at the end per change at the start, then the change per torque [N·m or N] on each rotor.
    #[inline]
    pub fn response(&self, row: usize) -> &[f64] {
        &self.x[row * self.width..row * self.width + 5 * self.n]
    }

    /// Change of a state at the end per torque [N·m or N] on each rotor.
    #[inline]
    pub fn of_rotors(&self, row: usize) -> &[f64] {
        &self.x[row * self.width + 4 * self.n..row * self.width + 5 * self.n]
    }

    /// Change of a state at the end per torque [N·m or N] on each link.
    #[inline]
    pub fn of_links(&self, row: usize) -> &[f64] {
        &self.x[row * self.width + 5 * self.n..(row + 1) * self.width]
    }

    /// Multiplies the errors of a velocity by a factor.
    pub(super) fn scale_velocity(&mut self, joint: usize, link: bool, factor: f64) {
        let row = 4 * joint + if link { 3 } else { 1 };
        self.x[row * self.width..(row + 1) * self.width].iter_mut().for_each(|value| *value *= factor);
    }

    /// Advances by `h` [s] under these slopes.
    pub(super) fn advance(&mut self, h: f64, slopes: &Slopes) {
        let Self { n, width, x, terms: [term, next], loads } = self;
        let (n, width) = (*n, *width);
        times(n, width, h, slopes, x, term, loads, true);
        for order in [2.0, 3.0] {
            x.iter_mut().zip(term.iter()).for_each(|(x, term)| *x += term);
            times(n, width, h / order, slopes, term, next, loads, false);
            std::mem::swap(term, next);
        }
        x.iter_mut().zip(term.iter()).for_each(|(x, term)| *x += term);
    }
}

/// `out = h (A x + B)`, without `B` where `driven` is false.
#[allow(clippy::too_many_arguments, reason = "the innermost product, on borrowed parts")]
fn times(n: usize, width: usize, h: f64, slopes: &Slopes, x: &[f64], out: &mut [f64], loads: &mut [f64], driven: bool) {
    for i in 0..n {
        let [acceleration, load] = &slopes.own[i];
        let rows = &x[4 * i * width..4 * (i + 1) * width];
        let moves = slopes.rotor[i] > 0.0;
        for c in 0..width {
            let [theta, omega, q, v] = [rows[c], rows[width + c], rows[2 * width + c], rows[3 * width + c]];
            let along = |slope: &[f64; 4]| slope[0] * theta + slope[1] * omega + slope[2] * q + slope[3] * v;
            out[4 * i * width + c] = h * omega;
            out[(4 * i + 1) * width + c] = if moves { h * along(acceleration) } else { 0.0 };
            out[(4 * i + 2) * width + c] = h * v;
            loads[i * width + c] = along(load);
        }
        if driven {
            out[(4 * i + 1) * width + 4 * n + i] += h * slopes.rotor[i];
            loads[i * width + 5 * n + i] += 1.0;
        }
    }
    for i in 0..n {
        let row = &mut out[(4 * i + 3) * width..(4 * i + 4) * width];
        row.fill(0.0);
        for j in 0..n {
            let w = h * slopes.mobility[i * n + j];
            row.iter_mut().zip(&loads[j * width..(j + 1) * width]).for_each(|(row, load)| *row += w * load);
        }
    }
}
