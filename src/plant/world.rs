//! The arm as a multibody in rapier's world, asked for `M(q)` and `h(q, q̇)`.
//!
//! A step of `dt = 1e-12 s` without forces of its own leaves the machine where it is and yields the acceleration
//! `a = −M⁻¹ h`; the same step leaves the factors of `M`, so `h = −M a` without a second formulation of the dynamics.
//! The body frame of a link is its joint frame after the motion; the free axis is the `x` axis of the joint's frames.
//! The bodies in the world are at the last evaluated state, so that they can be displayed, together with obstacles (`obstacle`).

use nalgebra::{DMatrix, Isometry3, Matrix6xX, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};
use rapier3d_f64::dynamics::{
    CCDSolver, GenericJointBuilder, ImpulseJointSet, IntegrationParameters, IslandManager, JointAxesMask, JointAxis,
    MassProperties, Multibody, MultibodyJointHandle, MultibodyJointSet, RigidBodyBuilder, RigidBodyHandle,
    RigidBodySet, SoftBodySet,
};
use rapier3d_f64::geometry::{BroadPhaseBvh, ColliderHandle, ColliderSet, NarrowPhase};
use rapier3d_f64::math::{Pose, Rotation, Vector};
use rapier3d_f64::pipeline::PhysicsPipeline;

use super::rigid_body::RigidBody;
use crate::robot::{Body, Inertia, Robot};
use crate::units::JointKind;

/// [s] Step of the oracle: short enough that nothing moves, long enough that nothing is lost to rounding.
const ORACLE_STEP: f64 = 1e-12;

/// A link's shape and an obstacle, which may meet.
#[derive(Debug, Clone)]
pub struct Pair {
    /// Index of the link's body.
    pub body: usize,
    /// Index of the obstacle.
    pub obstacle: usize,
    pub(super) link_collider: ColliderHandle,
    pub(super) obstacle_collider: ColliderHandle,
    /// [m] Thickness of the obstacle's skin.
    pub(super) skin: f64,
    /// The multibody's links from the base to the body.
    pub(super) branch: Vec<usize>,
}

/// rapier's world with the arm in it.
pub struct World {
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    gravity: Vector,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    pub(super) bodies: RigidBodySet,
    pub(super) colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    pub(super) multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
    pub(super) links: Vec<RigidBodyHandle>,
    pub(super) joints: Vec<Option<MultibodyJointHandle>>,
    /// Position of a joint in rapier's generalized vectors, and the axis of its coordinate.
    pub(super) columns: Vec<usize>,
    axes: Vec<usize>,
    pub(super) displacement: Vec<f64>,
    pub(super) pairs: Vec<Pair>,
    /// Jacobian of the link whose distance was computed last.
    pub(super) jacobian: Matrix6xX<f64>,
}

impl World {
    /// Builds the multibody of a robot on a fixed base, without colliders.
    pub fn new(robot: &Robot) -> Self {
        let mut bodies = RigidBodySet::new();
        let mut multibody_joints = MultibodyJointSet::new();
        let base = bodies.insert(RigidBodyBuilder::fixed());
        let mut links: Vec<RigidBodyHandle> = Vec::with_capacity(robot.dof());
        let mut joints = Vec::with_capacity(robot.dof());
        for body in &robot.bodies {
            let parent = body.parent.map_or(base, |parent| links[parent]);
            let link = bodies.insert(
                RigidBodyBuilder::dynamic()
                    .additional_mass_properties(mass_properties(&body.inertia))
                    .linear_damping(0.0)
                    .angular_damping(0.0)
                    .can_sleep(false),
            );
            joints.push(multibody_joints.insert(parent, link, joint_data(body), true));
            links.push(link);
        }
        let parameters =
            IntegrationParameters { dt: ORACLE_STEP, num_solver_iterations: 1, ..IntegrationParameters::default() };
        let axes = robot.bodies.iter().map(|body| free_axis(body.joint.kind) as usize).collect();
        let mut world = Self {
            pipeline: PhysicsPipeline::new(),
            parameters,
            gravity: vector(&robot.gravity),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies,
            colliders: ColliderSet::new(),
            impulse_joints: ImpulseJointSet::new(),
            multibody_joints,
            soft_bodies: SoftBodySet::new(),
            ccd: CCDSolver::new(),
            links,
            joints,
            columns: Vec::new(),
            axes,
            displacement: vec![0.0; robot.dof()],
            pairs: Vec::new(),
            jacobian: Matrix6xX::zeros(robot.dof()),
        };
        world.settle();
        world
    }

    /// Lets rapier set up the multibody, and removes the damping that rapier adds by default.
    fn settle(&mut self) {
        for handle in self.joints.iter().flatten() {
            if let Some((multibody, _)) = self.multibody_joints.get_mut(*handle) {
                multibody.forward_kinematics(&self.bodies, true);
                multibody.damping_mut().fill(0.0);
            }
        }
        self.step();
        self.columns = (self.joints.iter().flatten())
            .filter_map(|handle| self.multibody_joints.get(*handle))
            .filter_map(|(multibody, link)| multibody.link(link).map(|link| link.assembly_id()))
            .collect();
    }

    fn step(&mut self) {
        self.pipeline.step(
            self.gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd,
            &(),
            &(),
        );
    }

    /// Pose of every link's joint frame in the base frame, at the last evaluated state.
    pub fn poses(&self) -> impl Iterator<Item = Isometry3<f64>> + '_ {
        self.links.iter().map(|handle| isometry(self.bodies[*handle].position()))
    }

    /// The multibody; `None` for a robot without joints.
    pub(super) fn multibody(&self) -> Option<&Multibody> {
        let handle = self.joints.first().copied().flatten()?;
        self.multibody_joints.get(handle).map(|(multibody, _)| multibody)
    }

    /// Writes how far the joints are from `q`.
    pub(super) fn displace(&mut self, q: &[f64]) {
        let Self { joints, multibody_joints, columns, axes, displacement, .. } = self;
        let Some((multibody, _)) = joints.first().copied().flatten().and_then(|h| multibody_joints.get(h)) else {
            return;
        };
        displacement.fill(0.0);
        for (i, &column) in columns.iter().enumerate() {
            if let Some(link) = multibody.link(i + 1) {
                displacement[column] = q[i] - link.joint().coords()[axes[i]];
            }
        }
    }

    fn set_state(&mut self, q: &[f64], v: &[f64]) {
        self.displace(q);
        let Self { joints, multibody_joints, bodies, columns, displacement, .. } = self;
        let Some((multibody, _)) = joints.first().copied().flatten().and_then(|h| multibody_joints.get_mut(h)) else {
            return;
        };
        for (i, &column) in columns.iter().enumerate() {
            multibody.generalized_velocity_mut()[column] = v[i];
        }
        multibody.apply_displacements(displacement);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
    }
}

impl RigidBody for World {
    fn evaluate(&mut self, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]) {
        self.set_state(q, v);
        self.step();
        let Some(multibody) = self.multibody() else { return };
        // M = Pᵀ L U from the factors that the step leaves; LU is stored packed, L with a unit diagonal.
        let factors = multibody.inv_augmented_mass();
        let packed = factors.lu_internal();
        let n = self.columns.len();
        for i in 0..n {
            for j in 0..n {
                let upto = i.min(j + 1);
                let mut sum: f64 = (0..upto).map(|k| packed[(i, k)] * packed[(k, j)]).sum();
                if i <= j {
                    sum += packed[(i, j)];
                }
                mass[(i, j)] = sum;
            }
        }
        factors.p().inv_permute_rows(mass);
        let acceleration = multibody.generalized_acceleration();
        for (i, bias) in h.iter_mut().enumerate() {
            *bias = -(0..n).map(|j| mass[(i, j)] * acceleration[j]).sum::<f64>();
        }
    }

    fn distance(&mut self, pair: usize, q: &[f64], reach: f64, gradient: &mut [f64]) -> Option<f64> {
        self.pair_distance(pair, q, reach, gradient)
    }
}

fn free_axis(kind: JointKind) -> JointAxis {
    match kind {
        JointKind::Revolute => JointAxis::AngX,
        JointKind::Prismatic => JointAxis::LinX,
    }
}

fn joint_data(body: &Body) -> rapier3d_f64::dynamics::GenericJoint {
    let axis = free_axis(body.joint.kind);
    let to_axis = UnitQuaternion::rotation_between_axis(&Vector3::x_axis(), &body.joint.axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
    let aligned = Isometry3::from_parts(nalgebra::Translation3::identity(), to_axis);
    GenericJointBuilder::new(JointAxesMask::all() & !JointAxesMask::from(axis))
        .local_frame1(pose(&(body.joint.origin * aligned)))
        .local_frame2(pose(&aligned))
        .contacts_enabled(false)
        .into()
}

fn mass_properties(inertia: &Inertia) -> MassProperties {
    let eigen = SymmetricEigen::new(inertia.tensor);
    let mut frame = eigen.eigenvectors;
    if frame.determinant() < 0.0 {
        frame.column_mut(0).neg_mut();
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame));
    MassProperties::with_principal_inertia_frame(
        vector(&inertia.com),
        inertia.mass,
        vector(&eigen.eigenvalues),
        quaternion(&rotation),
    )
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn quaternion(rotation: &UnitQuaternion<f64>) -> Rotation {
    Rotation::from_xyzw(rotation.i, rotation.j, rotation.k, rotation.w)
}

pub(super) fn pose(isometry: &Isometry3<f64>) -> Pose {
    Pose::from_parts(vector(&isometry.translation.vector), quaternion(&isometry.rotation))
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let (t, r) = (pose.translation, pose.rotation);
    Isometry3::from_parts(
        nalgebra::Translation3::new(t.x, t.y, t.z),
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(r.w, r.x, r.y, r.z)),
    )
}
