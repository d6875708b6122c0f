//! Energy of the links.

use super::Dynamics;

impl Dynamics {
    /// `½ vᵀ H(q) v` [J].
    pub fn kinetic_energy(&mut self, q: &[f64], v: &[f64]) -> f64 {
        if self.axes.is_some() {
            return self.kinetic_energy_on_axes(q, v);
        }
        self.place(q);
        self.update_columns();
        let energy = |i: usize| {
            let twist = self.twist(i, v);
            0.5 * twist.dot(&self.links[i].moments.times(&twist))
        };
        (0..self.dof()).map(energy).sum()
    }

    /// `−Σ m g · c` [J], zero if all centres of mass are at the base's origin.
    pub fn potential_energy(&mut self, q: &[f64]) -> f64 {
        let gravity = self.gravity;
        let poses = self.poses(q);
        let moments = self.links.iter().map(|link| &link.moments);
        poses
            .iter()
            .zip(moments)
            .map(|(pose, body)| -gravity.dot(&(pose.rotation * body.h + pose.translation.vector * body.m)))
            .sum()
    }
}
