//! Checks whether a planned motion stays within the joint limits and keeps the links apart; the only place that names
//! `parry3d_f64`.
//!
//! Two shapes of one body never collide. Shapes of neighbouring bodies that touch at q = 0 belong together (a hinge and
//! its bearing) and are never checked; all other pairs are. The motion between two samples is taken as straight, and
//! checked in steps of at most [`STEP`].

use nalgebra::Isometry3;
use parry3d_f64::query::{distance, intersection_test};
use parry3d_f64::shape::SharedShape;

use super::Dynamics;
use super::solid::{pose_of, solid};
use crate::error::{Error, MotionError, MotionFault, Place, Result};
use crate::robot::{Geometry, Limits, Robot, Shape};

/// [rad or m] Largest motion of a joint between two checks.
pub const STEP: f64 = 0.005;

/// [m] Shapes of neighbouring bodies that are this close at q = 0 belong together.
const TOUCH: f64 = 1e-3;

/// [rad or m] Tolerance for rounding of a motion up to its limit.
const SLACK: f64 = 1e-9;

/// A robot's limits and shapes, prepared for checking motions.
pub struct MotionCheck {
    dynamics: Dynamics,
    joints: Vec<(String, Limits)>,
    solids: Vec<Solid>,
    /// Pairs of solids that must not meet.
    pairs: Vec<(usize, usize)>,
    poses: Vec<Isometry3<f64>>,
}

struct Solid {
    link: String,
    /// Body that carries it; `None`: the base.
    body: Option<usize>,
    pose: Isometry3<f64>,
    shape: SharedShape,
    /// [m] Largest distance of its points from the origin of its pose.
    radius: f64,
}

impl MotionCheck {
    /// Prepares a robot.
    ///
    /// # Errors
    /// A collision mesh was not read, or its points span no volume.
    pub fn new(robot: &Robot) -> Result<Self> {
        if let Some(unread) = robot.unread_shapes.first() {
            let key = format!("collision mesh of link {}", unread.link);
            return Err(Error::input(&unread.file, Place::File, key, "", &unread.expected));
        }
        let mut solids = Vec::new();
        let bodies = robot.bodies.iter().enumerate().map(|(index, body)| (Some(index), &body.shapes));
        for (body, shapes) in std::iter::once((None, &robot.base_shapes)).chain(bodies) {
            for shape in shapes {
                solids.push(Solid::new(robot, body, shape)?);
            }
        }
        let mut check = Self {
            dynamics: Dynamics::new(robot),
            joints: robot.bodies.iter().map(|body| (body.joint.name.clone(), body.joint.limits)).collect(),
            poses: vec![Isometry3::identity(); robot.dof()],
            solids,
            pairs: Vec::new(),
        };
        check.choose_pairs(robot);
        Ok(check)
    }

    /// Checks a motion: one time per sample [s], and the samples of each joint, or axis where axes are coupled, in the order of the robot's joints [rad
    /// or m].
    ///
    /// # Errors
    /// The first time at which a joint leaves its range, or two links meet.
    pub fn check(&mut self, times: &[f64], positions: &[&[f64]]) -> Result<(), MotionError> {
        let samples = positions.iter().map(|joint| joint.len()).min().unwrap_or(0).min(times.len());
        let sample = |k: usize| positions.iter().map(|joint| joint[k]).collect::<Vec<f64>>();
        if samples == 0 {
            return Ok(());
        }
        let mut seen = (times[0], sample(0));
        self.check_limits(seen.0, &seen.1)?;
        self.check_links(seen.0, &seen.1)?;
        for (k, &time) in times.iter().enumerate().take(samples).skip(1) {
            let q = sample(k);
            // A fault between here and the last check comes first.
            let outside = self.check_limits(time, &q);
            let moved = |joint| self.dynamics.joint_position(joint, &q) - self.dynamics.joint_position(joint, &seen.1);
            let motion = (0..q.len()).fold(0.0, |most: f64, joint| most.max(moved(joint).abs()));
            if motion >= STEP || k + 1 == samples || outside.is_err() {
                self.look_between(&seen, (time, &q), (motion / STEP).ceil())?;
                seen = (time, q);
            }
            outside?;
        }
        Ok(())
    }

    /// Checks the links in equal steps after `from` up to `to`.
    fn look_between(&mut self, from: &(f64, Vec<f64>), to: (f64, &[f64]), steps: f64) -> Result<(), MotionError> {
        let at = |part: f64| {
            let q: Vec<f64> = from.1.iter().zip(to.1).map(|(a, b)| a + (b - a) * part).collect();
            (from.0 + (to.0 - from.0) * part, q)
        };
        let mut k = 1.0;
        while k <= steps {
            let (time, q) = at(k / steps);
            self.check_links(time, &q)?;
            k += 1.0;
        }
        Ok(())
    }

    fn check_limits(&self, time: f64, axes: &[f64]) -> Result<(), MotionError> {
        for (index, (joint, limits)) in self.joints.iter().enumerate() {
            let position = self.dynamics.joint_position(index, axes);
            let Limits { lower, upper, .. } = *limits;
            // Not `position < lower`: NaN counts as outside too.
            if !(lower - SLACK..=upper + SLACK).contains(&position) {
                return Err(MotionError {
                    time,
                    cause: MotionFault::Limit { joint: joint.clone(), position, lower, upper },
                });
            }
        }
        Ok(())
    }

    fn check_links(&mut self, time: f64, q: &[f64]) -> Result<(), MotionError> {
        self.dynamics.poses_into(q, &mut self.poses);
        for &(a, b) in &self.pairs {
            let (a, b) = (&self.solids[a], &self.solids[b]);
            let (pose_a, pose_b) = (a.placed(&self.poses), b.placed(&self.poses));
            let apart = (pose_a.translation.vector - pose_b.translation.vector).norm();
            if apart > a.radius + b.radius {
                continue;
            }
            // All shapes are convex, and all pairs of them are supported; an unsupported pair would count as a
            // collision.
            let met = intersection_test(&pose_of(&pose_a), &*a.shape, &pose_of(&pose_b), &*b.shape);
            if met.is_ok_and(|met| !met.intersecting) {
                continue;
            }
            let cause = MotionFault::Collision { first: a.link.clone(), second: b.link.clone() };
            return Err(MotionError { time, cause });
        }
        Ok(())
    }

    fn choose_pairs(&mut self, robot: &Robot) {
        let parent = |body: Option<usize>| body.map(|index| robot.bodies[index].parent);
        self.dynamics.poses_into(&vec![0.0; robot.dof()], &mut self.poses);
        for (j, b) in self.solids.iter().enumerate() {
            for (i, a) in self.solids[..j].iter().enumerate() {
                let neighbours = parent(b.body) == Some(a.body) || parent(a.body) == Some(b.body);
                if a.body != b.body && !(neighbours && self.touch(a, b)) {
                    self.pairs.push((i, j));
                }
            }
        }
    }

    fn touch(&self, a: &Solid, b: &Solid) -> bool {
        let [pose_a, pose_b] = [a, b].map(|solid| pose_of(&solid.placed(&self.poses)));
        distance(&pose_a, &*a.shape, &pose_b, &*b.shape).is_ok_and(|found| found.distance <= TOUCH)
    }
}

impl Solid {
    fn new(robot: &Robot, body: Option<usize>, shape: &Shape) -> Result<Self> {
        let half = |length: f64| 0.5 * length;
        let (pose, solid) = solid(robot, shape)?;
        let radius = match &shape.geometry {
            Geometry::Box(size) => half(size.norm()),
            Geometry::Sphere(radius) => *radius,
            Geometry::Capsule(radius, length) => radius + half(*length),
            Geometry::Cylinder(radius, length) => radius.hypot(half(*length)),
            Geometry::ConvexHull(points) => points.iter().map(|point| point.norm()).fold(0.0, f64::max),
        };
        Ok(Self { link: shape.link.clone(), body, pose, shape: solid, radius })
    }

    fn placed(&self, bodies: &[Isometry3<f64>]) -> Isometry3<f64> {
        self.body.map_or(self.pose, |body| bodies[body] * self.pose)
    }
}
