//! Poses of the bodies, and their Jacobians.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::{Dynamics, Twist};

impl Dynamics {
    /// Pose of every body's frame in the base frame.
    pub fn poses(&mut self, q: &[f64]) -> Vec<Isometry3<f64>> {
        let mut poses = vec![Isometry3::identity(); self.dof()];
        self.poses_into(q, &mut poses);
        poses
    }

    /// As [`Dynamics::poses`], without allocating.
    pub fn poses_into(&mut self, q: &[f64], poses: &mut [Isometry3<f64>]) {
        if self.axes.is_some() {
            return self.poses_on_axes(q, poses);
        }
        self.place(q);
        for (i, (frame, link)) in self.frames.iter().zip(&self.links).enumerate() {
            let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame.r));
            let pose = Isometry3::from_parts(Translation3::from(frame.p), rotation);
            poses[i] = link.parent.map_or(pose, |parent| poses[parent] * pose);
        }
    }

    /// Whether joint `k` moves body `i`.
    pub fn moves(&self, k: usize, i: usize) -> bool {
        let mut body = Some(i);
        while let Some(at) = body {
            if at == k {
                return true;
            }
            body = self.links[at].parent;
        }
        false
    }

    /// Columns of every body's Jacobian, in the body's own frame; columns of joints that do not move it are left
    /// unchanged.
    pub(super) fn update_columns(&mut self) {
        let n = self.dof();
        for i in 0..n {
            let mut joint = self.links[i].parent;
            while let (Some(k), Some(parent)) = (joint, self.links[i].parent) {
                self.columns[i * n + k] = self.frames[i].twist_in_child(&self.columns[parent * n + k]);
                joint = self.links[k].parent;
            }
            self.columns[i * n + i] = self.links[i].axis();
        }
    }

    /// Velocity of body `i` in its own frame, from its columns.
    pub(super) fn twist(&self, i: usize, v: &[f64]) -> Twist {
        let n = self.dof();
        let mut twist = Twist { omega: Vector3::zeros(), v: Vector3::zeros() };
        let mut joint = Some(i);
        while let Some(k) = joint {
            twist.omega += self.columns[i * n + k].omega * v[k];
            twist.v += self.columns[i * n + k].v * v[k];
            joint = self.links[k].parent;
        }
        twist
    }
}
