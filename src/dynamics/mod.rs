//! Rigid-body algorithms on the tree: one algorithm, one file.
//!
//! ```text
//!   H(q) a + C(q, v) v + G(q) = τ
//! ```
//! `q v a τ`: position, velocity, acceleration and effort of every joint, in the order of [`Robot::bodies`], SI.
//! Positive effort drives the joint in its positive direction. Only links and their gravity are included: no rotors,
//! gears or friction.
//!
//! Quantities of a body are written in its own frame, about the frame's origin: angular velocity `ω`, its derivative `α`,
//! acceleration of the origin `p̈` (gravity is an acceleration of the base by `−g`); mass `m`, first moment `h = m c` and
//! tensor `I` about the origin. `R`, `p`: pose of a body in its parent. The joint's axis is `s`.
//!
//! Where motor axes are [coupled](crate::robot::Coupling), `q v a τ` are those of the axes, `C q` and `C⁻ᵀ τ`: the generalized
//! coordinates in which drives and encoders act. Torques and masses are then those at the motors (`axes`).
//!
//! After a [`Dynamics`] is built, only `poses` and `potential_energy` allocate memory. Reference: R. Featherstone
//! (2008), Rigid Body Dynamics Algorithms.

#![allow(clippy::needless_range_loop, reason = "a body, its parent, frame and motion are visited by one index")]

mod aba;
mod axes;
mod collision;
mod coriolis;
mod crba;
mod energy;
mod kinematics;
mod regressor;
mod rnea;
mod solid;

use nalgebra::{Matrix3, Vector3};

use crate::robot::Robot;
use crate::units::JointKind;

pub use collision::{MotionCheck, STEP};
pub use solid::{closest, convex_hull, solid};

/// A robot prepared for computation, with working memory for its algorithms.
#[derive(Debug, Clone)]
pub struct Dynamics {
    links: Vec<Link>,
    /// [m/s²] `g` seen from the base.
    gravity: Vector3<f64>,
    frames: Vec<Frame>,
    /// Position of each joint that its frame belongs to; NaN at first.
    placed: Vec<f64>,
    motions: Vec<Motion>,
    wrenches: Vec<Wrench>,
    composites: Vec<Moments>,
    articulated: Vec<aba::Articulated>,
    /// Column of joint `k` in the motion of body `i`, at `i · n + k`.
    columns: Vec<Twist>,
    /// Their time derivatives.
    column_rates: Vec<Twist>,
    /// Coupled axes; `None`: every axis moves its own joint.
    axes: Option<Box<axes::Axes>>,
}

/// Constant data of a body and its joint.
#[derive(Debug, Clone)]
struct Link {
    parent: Option<usize>,
    kind: JointKind,
    /// Axis in the joint frame, which is the body's.
    s: Vector3<f64>,
    /// Origin of the joint in the parent.
    p0: Vector3<f64>,
    /// `R(q) = r_fixed + sin q · r_sin + cos q · r_cos` (Rodrigues); a sliding joint has `r_fixed` alone.
    r_fixed: Matrix3<f64>,
    r_sin: Matrix3<f64>,
    r_cos: Matrix3<f64>,
    moments: Moments,
}

/// Mass, first moment `m c` and tensor about the origin.
#[derive(Debug, Clone, Copy)]
struct Moments {
    m: f64,
    h: Vector3<f64>,
    i: Matrix3<f64>,
}

/// Pose of a body in its parent.
#[derive(Debug, Clone, Copy)]
struct Frame {
    r: Matrix3<f64>,
    p: Vector3<f64>,
}

/// How a body moves.
#[derive(Debug, Clone, Copy)]
struct Motion {
    omega: Vector3<f64>,
    alpha: Vector3<f64>,
    /// `p̈` of the origin.
    acceleration: Vector3<f64>,
}

/// Torque about the origin, and force.
#[derive(Debug, Clone, Copy)]
struct Wrench {
    torque: Vector3<f64>,
    force: Vector3<f64>,
}

/// Angular velocity, and velocity of the origin.
#[derive(Debug, Clone, Copy)]
struct Twist {
    omega: Vector3<f64>,
    v: Vector3<f64>,
}

impl Dynamics {
    /// Prepares a robot.
    pub fn new(robot: &Robot) -> Self {
        let n = robot.dof();
        let links: Vec<Link> = robot.bodies.iter().map(Link::new).collect();
        let zero = Vector3::zeros();
        let twists = vec![Twist { omega: zero, v: zero }; n * n];
        Self {
            gravity: robot.gravity,
            frames: vec![Frame { r: Matrix3::identity(), p: zero }; n],
            placed: vec![f64::NAN; n],
            motions: vec![Motion { omega: zero, alpha: zero, acceleration: zero }; n],
            wrenches: vec![Wrench { torque: zero, force: zero }; n],
            composites: links.iter().map(|link| link.moments).collect(),
            articulated: vec![aba::Articulated::zero(); n],
            columns: twists.clone(),
            column_rates: twists,
            axes: robot.coupling.as_ref().map(|coupling| Box::new(axes::Axes::new(coupling))),
            links,
        }
    }

    /// Number of degrees of freedom.
    pub fn dof(&self) -> usize {
        self.links.len()
    }

    /// Sets the gravity [m/s²], seen from the base: for a tilted base.
    pub fn set_gravity(&mut self, gravity: Vector3<f64>) {
        self.gravity = gravity;
    }

    /// Computes the pose of every body in its parent.
    fn place(&mut self, q: &[f64]) {
        let frames = self.frames.iter_mut().zip(&mut self.placed);
        for (((frame, placed), link), &q) in frames.zip(&self.links).zip(q) {
            // A joint at rest, or the next algorithm at the same posture.
            if *placed != q {
                (*frame, *placed) = (link.frame(q), q);
            }
        }
    }
}

impl Link {
    fn new(body: &crate::robot::Body) -> Self {
        let joint = &body.joint;
        let r0 = joint.origin.rotation.to_rotation_matrix().into_inner();
        let s = joint.axis.into_inner();
        let (r_fixed, r_sin, r_cos) = match joint.kind {
            JointKind::Revolute => {
                let along = s * s.transpose();
                (r0 * along, r0 * s.cross_matrix(), r0 * (Matrix3::identity() - along))
            }
            JointKind::Prismatic => (r0, Matrix3::zeros(), Matrix3::zeros()),
        };
        let inertia = &body.inertia;
        Self {
            parent: body.parent,
            kind: joint.kind,
            s,
            p0: joint.origin.translation.vector,
            r_fixed,
            r_sin,
            r_cos,
            moments: Moments {
                m: inertia.mass,
                h: inertia.com * inertia.mass,
                i: inertia.tensor_about(&Vector3::zeros()),
            },
        }
    }

    fn frame(&self, q: f64) -> Frame {
        match self.kind {
            JointKind::Revolute => {
                let (sin, cos) = q.sin_cos();
                Frame { r: self.r_fixed + self.r_sin * sin + self.r_cos * cos, p: self.p0 }
            }
            JointKind::Prismatic => Frame { r: self.r_fixed, p: self.p0 + self.r_fixed * (self.s * q) },
        }
    }

    /// The joint's own motion at unit velocity.
    fn axis(&self) -> Twist {
        match self.kind {
            JointKind::Revolute => Twist { omega: self.s, v: Vector3::zeros() },
            JointKind::Prismatic => Twist { omega: Vector3::zeros(), v: self.s },
        }
    }

    /// The part of a wrench that the joint's drive must supply.
    fn effort(&self, wrench: &Wrench) -> f64 {
        match self.kind {
            JointKind::Revolute => self.s.dot(&wrench.torque),
            JointKind::Prismatic => self.s.dot(&wrench.force),
        }
    }
}

impl Frame {
    /// A wrench on the body, expressed as a wrench on its parent.
    fn wrench_in_parent(&self, wrench: &Wrench) -> Wrench {
        let force = self.r * wrench.force;
        Wrench { torque: self.r * wrench.torque + self.p.cross(&force), force }
    }

    /// A motion of the parent, expressed as the motion of a body that is fixed to it at this pose.
    fn twist_in_child(&self, twist: &Twist) -> Twist {
        Twist { omega: self.r.tr_mul(&twist.omega), v: self.r.tr_mul(&(twist.v + twist.omega.cross(&self.p))) }
    }
}

impl Twist {
    fn dot(&self, wrench: &Wrench) -> f64 {
        self.omega.dot(&wrench.torque) + self.v.dot(&wrench.force)
    }
}

impl Wrench {
    fn add(&mut self, other: &Self) {
        self.torque += other.torque;
        self.force += other.force;
    }
}

impl Moments {
    /// `[N; F] = M [ω̇; v̇]`: the wrench that accelerates the body from rest. For a velocity instead, the result is the momentum.
    fn times(&self, twist: &Twist) -> Wrench {
        Wrench {
            torque: self.i * twist.omega + self.h.cross(&twist.v),
            force: twist.v * self.m + twist.omega.cross(&self.h),
        }
    }
}
