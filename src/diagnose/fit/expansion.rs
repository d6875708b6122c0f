//! The torque of a joint whose torque constant and links deviate together: a product, linear near the last fit.
//!
//! A current shows `1 − s u` of the torque `τ̄ + L z + E` that nominal links, their deviations and effects that load the machine need, where the torque
//! constant is larger by `s u`, `u = c z`. Near the `s u₀`, `L z₀` and `E₀` of the last fit, to first order,
//!
//! ```text
//!   (1 − s u)(τ̄ + L z + E) − τ̄ ≈ s u₀ (L z₀ + E₀) + [(1 − s u₀) L − s (τ̄ + L z₀ + E₀) c] z + (1 − s u₀) E
//! ```
//! The last part is that of the effects' own columns ([`Cause`](super::cause::Cause)). What `E₀` adds belongs to fits that contain the effect: its
//! [`Term`](super::term::Term) knows it.
//! A fit with these columns, expanded again near its result, is a step of Gauss and Newton. With the links or the load of the last fit in the product, their
//! error would be multiplied by `s u` or `E/τ̄` from fit to fit, and grow where the constant of a model is a guess, or a wrist carries more than itself.
//! Reference: J. Nocedal, S. J. Wright (2006), Numerical Optimization, ch. 10.3.

use nalgebra::DVector;

use super::view::combined;
use crate::robot::LEAST_FACTOR;

/// [1] What a step leaves at least of `1 − s u`. A whole step may lead to none, where a current would show nothing of the links.
const LEAST_LEFT: f64 = 0.2;
/// [1] Least and largest `1 − s u`: beyond them a corrected model does not follow ([`Model::torque_factor`](crate::robot::Model::torque_factor)), and a fit
/// would lose its digits.
const POSSIBLE: [f64; 2] = [LEAST_FACTOR, 1.0 / LEAST_FACTOR];

/// Where the columns of a joint are linear.
#[derive(Debug, Clone)]
pub struct Expansion {
    /// `s u₀` [1]
    scale: f64,
    /// `L z₀` [N·m or N] in all rows.
    links: Vec<f64>,
    /// `s u₀ L z₀` [N·m or N] in all rows.
    shift: Vec<f64>,
}

impl Expansion {
    /// At the nominal model.
    pub fn nominal(rows: usize) -> Self {
        let none = vec![0.0; rows];
        Self { scale: 0.0, links: none.clone(), shift: none }
    }

    /// The torque that is added to that of the columns.
    pub fn shift(&self) -> &[f64] {
        &self.shift
    }

    /// `s u₀`
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Torque that the constant scales, without that of the columns.
    fn expected<'s>(&'s self, rigid: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        rigid.iter().zip(&self.links).map(|(rigid, links)| rigid + links)
    }

    /// Makes the torque of links, one column of `L`, one of the product; `constant` is `s c`.
    pub fn scale_column(&self, column: &mut [f64], rigid: &[f64], constant: f64) {
        for (x, expected) in column.iter_mut().zip(self.expected(rigid)) {
            *x = (1.0 - self.scale) * *x - constant * expected;
        }
    }

    /// Adds what a load `E₀` does to the columns and to the torque that is known; `constant` is `s c`.
    pub fn add_load(&self, columns: &mut [Vec<f64>], shift: &mut [f64], load: &[f64], constant: &DVector<f64>) {
        for (column, constant) in columns.iter_mut().zip(constant) {
            column.iter_mut().zip(load).for_each(|(x, load)| *x -= constant * load);
        }
        shift.iter_mut().zip(load).for_each(|(x, load)| *x += self.scale * load);
    }

    /// The inverse of [`scale_column`](Self::scale_column).
    fn unscale_column(&self, column: &mut [f64], rigid: &[f64], constant: f64) {
        for (x, expected) in column.iter_mut().zip(self.expected(rigid)) {
            *x = (*x + constant * expected) / (1.0 - self.scale);
        }
    }

    /// Expands near the deviations `z` of a fit with these columns, or as near as [`LEAST_LEFT`] and [`POSSIBLE`] allow. Returns the relative change of `1 − s u₀`.
    pub fn step(&mut self, columns: &mut [Vec<f64>], rigid: &[f64], constant: &DVector<f64>, z: &DVector<f64>) -> f64 {
        let each = || constant.iter().copied();
        columns.iter_mut().zip(each()).for_each(|(column, c)| self.unscale_column(column, rigid, c));
        let before = 1.0 - self.scale;
        let [least, largest] = POSSIBLE;
        let after = (1.0 - constant.dot(z)).max(LEAST_LEFT * before).clamp(least, largest);
        self.scale = 1.0 - after;
        self.links = combined(columns, z);
        self.shift = self.links.iter().map(|links| self.scale * links).collect();
        columns.iter_mut().zip(each()).for_each(|(column, c)| self.scale_column(column, rigid, c));
        after / before - 1.0
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    /// `s c` of two deviations: of the torque constant and of the links.
    fn constant() -> DVector<f64> {
        DVector::from_column_slice(&[1.0, 0.0])
    }

    /// Torque of the nominal links and of one deviation of them, which is five times as large.
    fn links() -> [Vec<f64>; 2] {
        let rows = || (0..200).map(|row| 0.05 * f64::from(row));
        [rows().map(|t| (1.3 * t).sin()).collect(), rows().map(|t| 5.0 * t.cos()).collect()]
    }

    /// `(1 − s u)(τ̄ + L z + E) − τ̄` with `E = e τ̄`
    fn product([rigid, links]: &[Vec<f64>; 2], e: f64, z: &DVector<f64>) -> DVector<f64> {
        let of = |(rigid, links): (&f64, &f64)| (1.0 - z[0]) * ((1.0 + e) * rigid + z[1] * links) - rigid;
        DVector::from_iterator(rigid.len(), rigid.iter().zip(links).map(of))
    }

    fn start([rigid, links]: &[Vec<f64>; 2]) -> (Expansion, Vec<Vec<f64>>) {
        let expansion = Expansion::nominal(rigid.len());
        let mut columns = vec![vec![0.0; rigid.len()], links.clone()];
        columns.iter_mut().zip(&constant()).for_each(|(column, c)| expansion.scale_column(column, rigid, *c));
        (expansion, columns)
    }

    /// Where it was expanded, the torque is the product, and so is every slope.
    #[test]
    fn analytic_an_expansion_is_the_product_to_first_order() {
        let both = links();
        for e in [0.0, 2.0] {
            let (mut expansion, mut columns) = start(&both);
            let load: Vec<f64> = both[0].iter().map(|rigid| e * rigid).collect();
            let torque = |expansion: &Expansion, columns: &[Vec<f64>], z: &DVector<f64>| {
                let (mut columns, mut shift) = (columns.to_vec(), expansion.shift().to_vec());
                expansion.add_load(&mut columns, &mut shift, &load, &constant());
                let known = load.iter().zip(shift).map(|(load, shift)| (1.0 - expansion.scale()) * load + shift);
                DVector::from_vec(combined(&columns, z)) + DVector::from_iterator(both[0].len(), known)
            };
            for z in [[-1.5, 0.7], [0.4, -2.0], [0.3, 0.1]].map(|z| DVector::from_column_slice(&z)) {
                expansion.step(&mut columns, &both[0], &constant(), &z);
                // Rounding of torques of 10 N·m.
                assert!((torque(&expansion, &columns, &z) - product(&both, e, &z)).amax() < 1e-12);
                for k in 0..2 {
                    let mut near = z.clone();
                    near[k] += 1e-6;
                    // The product has no square of either deviation.
                    assert!((torque(&expansion, &columns, &near) - product(&both, e, &near)).amax() < 1e-12);
                }
            }
        }
    }

    /// A constant that is 2.5 times too small for what its current shows, or three times too large, with links that deviate by several times their nominal
    /// torque: fits by least squares, each expanded near the last, find both. With the links as the last fit has them the error grew by 1.5 from fit to
    /// fit. No step takes more of `1 − s u` than it may.
    #[test]
    fn recover_a_guessed_constant_beside_links_of_larger_torque() {
        let both = links();
        for truth in [[-1.5, 0.7], [2.0 / 3.0, -2.0]].map(|z| DVector::from_column_slice(&z)) {
            let measured = product(&both, 0.0, &truth);
            let (mut expansion, mut columns) = start(&both);
            let mut found = DVector::zeros(2);
            for _ in 0..8 {
                let x = DMatrix::from_fn(measured.len(), 2, |row, k| columns[k][row]);
                let y = &measured - DVector::from_column_slice(expansion.shift());
                found = (x.tr_mul(&x)).lu().solve(&x.tr_mul(&y)).expect("two directions");
                let change = expansion.step(&mut columns, &both[0], &constant(), &found);
                assert!(change >= LEAST_LEFT - 1.0 - 1e-12, "{change}");
            }
            // Steps of Gauss and Newton without a residual converge quadratically.
            assert!((&found - &truth).amax() < 1e-9, "{found} {truth}");
        }
    }
}
