//! Held-out sessions without training rows: what may differ there is freed before their residual is judged.

use nalgebra::DVector;

use super::problem::{Part, Problem};
use super::regression::{Block, NU, System};
use super::term::Term;

impl Problem<'_> {
    /// On held-out rows, frees what may differ in sessions without training rows: the Coulomb level (with a prior of 5 %), the offset of a torque,
    /// and the phase of torques that repeat with the motor angle.
    pub fn free_new_sessions(
        &self,
        joint: usize,
        terms: &[&Term],
        coefficients: &DVector<f64>,
        term_at: &[usize],
        residual: &mut [f64],
    ) {
        let rows = self.rows(joint, Part::HeldOut);
        for session in 0..self.motion.sessions {
            let trained = self.motion.session.iter().zip(&self.held_out).any(|(s, held)| *s == session && !held);
            let picked: Vec<usize> =
                (0..rows.len()).filter(|index| self.motion.session[rows[*index]] == session).collect();
            if trained || picked.is_empty() {
                continue;
            }
            let own_rows: Vec<usize> = picked.iter().map(|index| rows[*index]).collect();
            let mut e: Vec<f64> = picked.iter().map(|index| residual[*index]).collect();
            for (term, at) in terms.iter().zip(term_at).filter(|(term, _)| term.effect.harmonic().is_some()) {
                if let Some(place) = term.joints.iter().position(|j| *j == joint) {
                    let trained = [coefficients[*at], coefficients[*at + 1]];
                    e = self.free_phase(joint, &own_rows, e, &term.columns[place], trained);
                }
            }
            let (e, _) = self.free_level(joint, &own_rows, e, Vec::new());
            picked.iter().zip(e).for_each(|(index, e)| residual[*index] = e);
        }
    }

    /// Rotates the phase of a harmonic at constant amplitude, where that fits better.
    fn free_phase(
        &self,
        joint: usize,
        rows: &[usize],
        e: Vec<f64>,
        columns: &[Vec<f64>],
        trained: [f64; 2],
    ) -> Vec<f64> {
        let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let [cos, sin] = [pick(&columns[0]), pick(&columns[1])];
        let bare: Vec<f64> = (0..rows.len()).map(|i| e[i] + trained[0] * cos[i] + trained[1] * sin[i]).collect();
        let (_, found) = self.free_level(joint, rows, bare.clone(), vec![cos.clone(), sin.clone()]);
        let size = found[0].hypot(found[1]);
        if size <= 0.0 {
            return e;
        }
        let scale = trained[0].hypot(trained[1]) / size;
        let turned: Vec<f64> =
            (0..rows.len()).map(|i| bare[i] - scale * (found[0] * cos[i] + found[1] * sin[i])).collect();
        let power = |values: Vec<f64>| -> f64 {
            let (left, _) = self.free_level(joint, rows, values, Vec::new());
            left.iter().map(|e| e * e).sum()
        };
        if power(turned.clone()) < power(e.clone()) { turned } else { e }
    }

    /// The residual after a fit of the session's Coulomb level, its offset and the coefficients of further columns.
    fn free_level(&self, joint: usize, rows: &[usize], y: Vec<f64>, further: Vec<Vec<f64>>) -> (Vec<f64>, Vec<f64>) {
        let m = &self.motion.joints[joint];
        let count = further.len();
        let mut all = further;
        all.push(rows.iter().map(|row| m.direction[*row]).collect());
        if !m.has_current {
            all.push(vec![1.0; rows.len()]);
        }
        let unknowns = all.len();
        let columns = all.into_iter().enumerate().collect();
        let level = 0.05 * m.friction.coulomb.abs().max(1e-9);
        let priors = vec![(count, 1.0 / (self.independence[joint] * level * level))];
        let system = System { blocks: vec![Block { y, columns }], unknowns, priors, ..System::default() };
        match system.solve(NU) {
            Some(mut solution) => {
                (solution.residual.swap_remove(0), solution.coefficients.iter().take(count).copied().collect())
            }
            None => (system.blocks[0].y.clone(), vec![0.0; count]),
        }
    }
}
