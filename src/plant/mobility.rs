//! `W = M⁻¹` and `a₀ = M⁻¹ h` between evaluations of the rigid-body engine.
//!
//! The links are evaluated once per interval. Over the next interval both are extrapolated by the cubic through the last four
//! evaluations. The engine's answer at the end of the interval then gives the error of the cubic.
//! The inverse is interpolated rather than `M`, so that no matrix has to be factored inside a step.

use nalgebra::DMatrix;

/// Evaluations kept: a cubic goes through four.
const NODES: usize = 4;

/// The links' response to torque, `q̈ = W τ − a₀`, as a function of time.
pub struct Mobility {
    joints: usize,
    /// Entries of a node: `W` row by row, then `a₀`.
    width: usize,
    /// Newest first.
    times: Vec<f64>,
    nodes: Vec<Vec<f64>>,
    /// Newton's divided differences over the nodes, in the same order.
    differences: Vec<Vec<f64>>,
    factor: Vec<f64>,
}

impl Mobility {
    /// For that many joints, without evaluations.
    pub fn new(joints: usize) -> Self {
        let width = joints * joints + joints;
        Self {
            joints,
            width,
            times: Vec::with_capacity(NODES + 1),
            nodes: vec![vec![0.0; width]; NODES],
            differences: vec![vec![0.0; width]; NODES],
            factor: vec![0.0; joints * joints],
        }
    }

    /// Removes all evaluations.
    pub fn clear(&mut self) {
        self.times.clear();
    }

    /// Whether there are enough evaluations for a cubic.
    pub fn is_full(&self) -> bool {
        self.times.len() == NODES
    }

    /// Adds an engine's answer at a time later than all before.
    pub fn push(&mut self, time: f64, mass: &DMatrix<f64>, h: &[f64]) {
        invert(self.joints, mass, h, &mut self.factor, &mut self.nodes[NODES - 1]);
        self.accept(time);
    }

    /// Stores an engine's answer at a time later than all before; `response` becomes the value of the polynomial there.
    /// The polynomial does not change until the answer is accepted.
    pub fn offer(&mut self, time: f64, mass: &DMatrix<f64>, h: &[f64], response: &mut Response) {
        self.at(time, response);
        // The oldest evaluation is about to be dropped, and the polynomial no longer needs it: its memory is free.
        invert(self.joints, mass, h, &mut self.factor, &mut self.nodes[NODES - 1]);
    }

    /// Error of the acceleration of joint `i` under these torques on the links [rad/s² or m/s²], where `response` is the value of
    /// the polynomial.
    pub fn miss(&self, i: usize, torques: &[f64], response: &Response) -> f64 {
        let n = self.joints;
        let said = &self.nodes[NODES - 1];
        let rows = said[i * n..(i + 1) * n].iter().zip(response.row(i));
        let driven: f64 = rows.zip(torques).map(|((said, guessed), torque)| (said - guessed) * torque).sum();
        driven - (said[n * n + i] - response.free(i))
    }

    /// Accepts the answer that was offered.
    pub fn accept(&mut self, time: f64) {
        self.times.truncate(NODES - 1);
        self.times.insert(0, time);
        self.nodes.rotate_right(1);
        self.draw();
    }

    /// Computes the polynomial through the nodes.
    fn draw(&mut self) {
        let count = self.times.len();
        for (difference, node) in self.differences.iter_mut().zip(&self.nodes).take(count) {
            difference.copy_from_slice(node);
        }
        for order in 1..count {
            for i in (order..count).rev() {
                let span = self.times[i] - self.times[i - order];
                let (before, from) = self.differences.split_at_mut(i);
                for (high, low) in from[0].iter_mut().zip(&before[i - 1]) {
                    *high = (*high - low) / span;
                }
            }
        }
    }

    /// Writes `W` and `a₀` at a time.
    #[inline]
    pub fn at(&self, time: f64, response: &mut Response) {
        let count = self.times.len();
        let out = &mut response.entries[..self.width];
        out.copy_from_slice(&self.differences[count - 1][..self.width]);
        for order in (0..count - 1).rev() {
            let s = time - self.times[order];
            for (value, difference) in out.iter_mut().zip(&self.differences[order]) {
                *value = difference + s * *value;
            }
        }
    }

    /// Writes `W` and `a₀` of the newest evaluation.
    pub fn newest(&self, response: &mut Response) {
        response.entries.copy_from_slice(&self.nodes[0]);
    }

    /// Writes `W` and `a₀` of an engine's answer.
    pub fn exact(&mut self, mass: &DMatrix<f64>, h: &[f64], response: &mut Response) {
        invert(self.joints, mass, h, &mut self.factor, &mut response.entries);
    }
}

/// `W` and `a₀` at an instant.
pub struct Response {
    joints: usize,
    entries: Vec<f64>,
}

impl Response {
    /// For that many joints.
    pub fn new(joints: usize) -> Self {
        Self { joints, entries: vec![0.0; joints * joints + joints] }
    }

    /// Copies another response of as many joints without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.entries.copy_from_slice(&other.entries);
    }

    /// `W[i][j]` [rad/s² per N·m].
    #[inline]
    pub fn w(&self, i: usize, j: usize) -> f64 {
        self.entries[i * self.joints + j]
    }

    /// Row `i` of `W`.
    #[inline]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.entries[i * self.joints..(i + 1) * self.joints]
    }

    /// `a₀` [rad/s²].
    #[inline]
    pub fn free(&self, i: usize) -> f64 {
        self.entries[self.joints * self.joints + i]
    }
}

/// `W = M⁻¹` and `a₀ = W h` by Cholesky: `M = C Cᵀ`.
fn invert(n: usize, mass: &DMatrix<f64>, h: &[f64], c: &mut [f64], out: &mut [f64]) {
    for j in 0..n {
        for i in j..n {
            let dot: f64 = (0..j).map(|k| c[i * n + k] * c[j * n + k]).sum();
            let rest = mass[(i, j)] - dot;
            c[i * n + j] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / c[j * n + j] };
        }
    }
    // Columns of C⁻¹ in the lower triangle, then W = C⁻ᵀ C⁻¹.
    for j in 0..n {
        c[j * n + j] = 1.0 / c[j * n + j];
        for i in j + 1..n {
            let dot: f64 = (j..i).map(|k| c[i * n + k] * c[k * n + j]).sum();
            c[i * n + j] = -dot / c[i * n + i];
        }
    }
    for i in 0..n {
        for j in 0..=i {
            let w: f64 = (i..n).map(|k| c[k * n + i] * c[k * n + j]).sum();
            out[i * n + j] = w;
            out[j * n + i] = w;
        }
    }
    for i in 0..n {
        out[n * n + i] = (0..n).map(|j| out[i * n + j] * h[j]).sum();
    }
}
