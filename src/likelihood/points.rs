//! The motion of a Gaussian over an interval in which its laws bend: by cubature points instead of the derivative.
//!
//! ```text
//!   x_j = m ± √N L_j,   L Lᵀ = P,   y_j = f(x_j)        N: number of states
//!   m ← Σ y_j/2N,   P ← Σ (y_j − m)(y_j − m)ᵀ/2N,   F = Σ (y_j⁺ − y_j⁻)/(2 √N) (L⁻¹)_j
//! ```
//! A law bends where a flank may be met, or a velocity may pass zero, within the deviations that are predicted. Points between which and the mean no law bends
//! go where the derivative of the motion carries them; the others are simulated. `F` is the regression of the motion at
//! the end on that at the start, which the sensitivities need.
//! Reference: I. Arasaratnam, S. Haykin (2009), Cubature Kalman filters, IEEE Trans. Automatic Control 54; S. Särkkä, L. Svensson (2023), Bayesian filtering and
//! smoothing, algorithm 8.12 and section 9.3 (statistical linear regression).

/// Points of a Gaussian of `size` states, and what became of them.
#[derive(Debug, Clone)]
pub(super) struct Points {
    size: usize,
    /// `L` row by row, lower triangle.
    factor: Vec<f64>,
    /// `y_j⁺`, then `y_j⁻`, one after the other.
    moved: Vec<f64>,
    /// Which of them have been simulated.
    simulated: Vec<bool>,
}

/// Share of a variance below which a state is known from the others, to rounding.
const KNOWN: f64 = 1e-12;

impl Points {
    /// For so many states.
    pub fn new(size: usize) -> Self {
        Self {
            size,
            factor: vec![0.0; size * size],
            moved: vec![0.0; 2 * size * size],
            simulated: vec![false; 2 * size],
        }
    }

    /// Factors a covariance, given row by row. A state that is known exactly has a row of zeros.
    pub fn factor(&mut self, p: &[f64]) {
        let n = self.size;
        let l = &mut self.factor;
        l.fill(0.0);
        self.simulated.fill(false);
        for j in 0..n {
            let known: f64 = (0..j).map(|k| l[j * n + k] * l[j * n + k]).sum();
            let rest = p[j * n + j] - known;
            if rest <= KNOWN * p[j * n + j] {
                continue;
            }
            let pivot = rest.sqrt();
            l[j * n + j] = pivot;
            for i in j + 1..n {
                let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
                l[i * n + j] = (p[i * n + j] - dot) / pivot;
            }
        }
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        2 * self.size
    }

    /// Distance of a point from the mean in one state.
    pub fn distance(&self, point: usize, state: usize) -> f64 {
        self.way(point) * self.factor[state * self.size + point % self.size]
    }

    /// `±√N`.
    fn way(&self, point: usize) -> f64 {
        (self.size as f64).sqrt().copysign(if point < self.size { 1.0 } else { -1.0 })
    }

    /// Where a point has gone, by simulation.
    pub fn moved(&mut self, point: usize) -> &mut [f64] {
        self.simulated[point] = true;
        &mut self.moved[point * self.size..(point + 1) * self.size]
    }

    /// Points that were not simulated have gone where the derivative `F` (row by row) carries them beside the mean.
    pub fn pass(&mut self, mean: &[f64], f: &[f64]) {
        let n = self.size;
        for point in (0..self.count()).filter(|point| !self.simulated[*point]) {
            let (j, way) = (point % n, self.way(point));
            for row in 0..n {
                let along: f64 = (j..n).map(|k| f[row * n + k] * self.factor[k * n + j]).sum();
                self.moved[point * n + row] = mean[row] + way * along;
            }
        }
    }

    /// Mean and covariance (row by row) of the points, and `F` (row by row).
    pub fn collect(&self, mean: &mut [f64], p: &mut [f64], f: &mut [f64]) {
        let n = self.size;
        let weight = 1.0 / (2 * n) as f64;
        mean.fill(0.0);
        for point in self.moved.chunks_exact(n) {
            mean.iter_mut().zip(point).for_each(|(mean, value)| *mean += weight * value);
        }
        p.fill(0.0);
        for point in self.moved.chunks_exact(n) {
            for row in 0..n {
                let own = weight * (point[row] - mean[row]);
                for column in 0..=row {
                    p[row * n + column] += own * (point[column] - mean[column]);
                }
            }
        }
        for row in 0..n {
            for column in 0..row {
                p[column * n + row] = p[row * n + column];
            }
        }
        self.regress(f);
    }

    /// `F L = D`, `D_j = (y_j⁺ − y_j⁻)/(2 √N)`, from the last column to the first; the columns of known states are zero.
    fn regress(&self, f: &mut [f64]) {
        let n = self.size;
        let scale = 0.5 / (n as f64).sqrt();
        for row in 0..n {
            for j in (0..n).rev() {
                let pivot = self.factor[j * n + j];
                let difference = scale * (self.moved[j * n + row] - self.moved[(n + j) * n + row]);
                let later: f64 = (j + 1..n).map(|i| f[row * n + i] * self.factor[i * n + j]).sum();
                f[row * n + j] = if pivot > 0.0 { (difference - later) / pivot } else { 0.0 };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_points_of_a_linear_motion_give_its_covariance_and_its_matrix() {
        let p = [4.0, 1.0, 0.0, 1.0, 3.0, 0.5, 0.0, 0.5, 2.0];
        let motion = [[1.0, 0.1, 0.0], [-0.2, 0.9, 0.3], [0.0, 0.0, 1.1]];
        let mut points = Points::new(3);
        points.factor(&p);
        let moved = |from: &[f64]| motion.map(|row| row.iter().zip(from).map(|(a, b)| a * b).sum::<f64>());
        // Every second one is simulated, the others go by the matrix.
        for point in (0..points.count()).step_by(2) {
            let from: Vec<f64> = (0..3).map(|state| 5.0 + points.distance(point, state)).collect();
            points.moved(point).copy_from_slice(&moved(&from));
        }
        points.pass(&moved(&[5.0; 3]), motion.as_flattened());
        let (mut mean, mut covariance, mut f) = ([0.0; 3], [0.0; 9], [0.0; 9]);
        points.collect(&mut mean, &mut covariance, &mut f);
        for row in 0..3 {
            // Rounding of numbers of order ten.
            assert!((mean[row] - 5.0 * motion[row].iter().sum::<f64>()).abs() < 1e-13);
            for column in 0..3 {
                let product = (0..9).map(|k| motion[row][k / 3] * p[k] * motion[column][k % 3]).sum::<f64>();
                assert!((covariance[row * 3 + column] - product).abs() < 1e-13);
                assert!((f[row * 3 + column] - motion[row][column]).abs() < 1e-13);
            }
        }
    }
}
