//! Rigid-body algorithms against closed forms, against each other, and against the laws of mechanics.

mod support;

use lostmotion::dynamics::Dynamics;
use lostmotion::robot::{Model, Robot};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use support::{numbers, random, random_tree};

/// Rounding of sums of up to twelve bodies' terms against each other, relative to the largest term.
const ROUNDING: f64 = 1e-12;

fn from_urdf(urdf: &str, joints: &[&str]) -> Robot {
    let mut model = "schema = 'lostmotion/model/1'\nname = 'm'\nurdf = 'm.urdf'\n".to_owned();
    for joint in joints {
        model += &format!(
            "[joints.{joint}]\ngear_ratio = 1\nrotor_inertia = 1\ngear_stiffness = 1\nmotor = {{ torque_constant = 1 }}\n"
        );
    }
    Model::from_texts(&model, urdf, "m.toml".as_ref()).unwrap().robot
}

#[track_caller]
fn close(a: &[f64], b: &[f64], tolerance: f64) {
    let scale = a.iter().chain(b).fold(1.0, |scale: f64, x| scale.max(x.abs()));
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() <= tolerance * scale, "{a:?} against {b:?}, scale {scale}");
    }
}

/// A physical pendulum turned in its frames: its axis is y, gravity −z, and the inertial frame is rolled by 90°.
const PENDULUM: &str = r#"<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5" rpy="1.5707963267948966 0 0"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.11"/></inertial></link>
  <joint name="pivot" type="continuous"><parent link="base"/><child link="rod"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint>
</robot>"#;

#[test]
fn analytic_pendulum() {
    // After the roll by 90° the tensor's y is the file's z: I_yy = 0.11.
    let (m, l, i) = (2.0, 0.5, 0.11);
    let mut dynamics = Dynamics::new(&from_urdf(PENDULUM, &["pivot"]));
    for q in [-3.0, -0.4, 0.0, 0.7, 2.2] {
        let mut tau = [0.0];
        dynamics.inverse(&[q], &[1.3], &[0.8], &mut tau);
        close(&tau, &[(i + m * l * l) * 0.8 + m * 9.81 * l * q.sin()], ROUNDING);
    }
}

/// A planar arm in the plane x–z with its axes along −y, so that positive angles lift it from +x towards +z.
const PLANAR: &str = r#"<robot name="planar">
  <link name="base"/>
  <link name="one"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
  <link name="two"><inertial><origin xyz="0.15 0 0"/><mass value="2"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
  <joint name="a" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="b" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0.4 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"#;

/// `H`, `C v` and `G` of a planar arm with two joints (every textbook).
fn planar_closed_form(q: [f64; 2], v: [f64; 2]) -> ([[f64; 2]; 2], [f64; 2], [f64; 2]) {
    let (m1, m2, l1, c1, c2, i1, i2, g) = (3.0, 2.0, 0.4, 0.2, 0.15, 0.05, 0.03, 9.81);
    let h22 = i2 + m2 * c2 * c2;
    let h12 = h22 + m2 * l1 * c2 * q[1].cos();
    let h11 = i1 + m1 * c1 * c1 + m2 * l1 * l1 + 2.0 * m2 * l1 * c2 * q[1].cos() + h22;
    let s = m2 * l1 * c2 * q[1].sin();
    let coriolis = [-s * (2.0 * v[0] * v[1] + v[1] * v[1]), s * v[0] * v[0]];
    let tip = m2 * g * c2 * (q[0] + q[1]).cos();
    ([[h11, h12], [h12, h22]], coriolis, [(m1 * c1 + m2 * l1) * g * q[0].cos() + tip, tip])
}

#[test]
fn analytic_planar_arm_of_two_joints() {
    let mut dynamics = Dynamics::new(&from_urdf(PLANAR, &["a", "b"]));
    let mut rng = random(1);
    for _ in 0..50 {
        let [q, v] = [3.0, 5.0].map(|size| <[f64; 2]>::try_from(numbers(&mut rng, 2, size)).unwrap());
        let (h, coriolis, gravity) = planar_closed_form(q, v);
        let mut mass = DMatrix::zeros(2, 2);
        dynamics.mass_matrix(&q, &mut mass);
        close(mass.as_slice(), h.as_flattened(), ROUNDING);
        let mut tau = [0.0; 2];
        dynamics.gravity(&q, &mut tau);
        close(&tau, &gravity, ROUNDING);
        dynamics.bias(&q, &v, &mut tau);
        close(&tau, &[coriolis[0] + gravity[0], coriolis[1] + gravity[1]], ROUNDING);
    }
}

/// Trees of 1 to 12 joints with a random state: robot, `q`, `v`, `a`.
fn trees(seed: u64) -> impl Iterator<Item = (Robot, Vec<f64>, Vec<f64>, Vec<f64>)> {
    let mut rng = random(seed);
    (0..60).map(move |k| {
        let n = 1 + k % 12;
        let mut robot = random_tree(&mut rng, n);
        robot.gravity = nalgebra::Vector3::from_vec(numbers(&mut rng, 3, 10.0));
        let [q, v, a] = [3.0, 3.0, 10.0].map(|size| numbers(&mut rng, n, size));
        (robot, q, v, a)
    })
}

#[test]
fn equivalent_inverse_dynamics_mass_matrix_and_bias_on_random_trees() {
    for (robot, q, v, a) in trees(2) {
        let n = robot.dof();
        let mut dynamics = Dynamics::new(&robot);
        let [mut tau, mut bias, mut both] = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let [mut h, mut again] = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        dynamics.inverse(&q, &v, &a, &mut tau);
        dynamics.mass_matrix(&q, &mut h);
        dynamics.bias(&q, &v, &mut bias);
        let sum = &h * DVector::from_column_slice(&a) + DVector::from_column_slice(&bias);
        close(sum.as_slice(), &tau, ROUNDING);
        dynamics.mass_matrix_and_bias(&q, &v, &mut again, &mut both);
        assert_eq!((again, both), (h, bias));
    }
}

#[test]
fn equivalent_articulated_bodies_undo_inverse_dynamics_on_random_trees() {
    for (robot, q, v, a) in trees(3) {
        let n = robot.dof();
        let mut dynamics = Dynamics::new(&robot);
        let [mut tau, mut found] = [vec![0.0; n], vec![0.0; n]];
        dynamics.inverse(&q, &v, &a, &mut tau);
        dynamics.forward(&q, &v, &tau, &mut found);
        let mut h = DMatrix::zeros(n, n);
        dynamics.mass_matrix(&q, &mut h);
        let eigenvalues = h.symmetric_eigenvalues();
        // The efforts are right to rounding; the accelerations follow with the condition number of the mass matrix,
        // which reaches 10⁴ where twelve bodies hang on a light one.
        let condition = eigenvalues.max() / eigenvalues.min();
        close(&found, &a, 1e-14 * condition.max(100.0));
    }
}

#[test]
fn property_mass_matrix_is_symmetric_and_positive_definite() {
    for (robot, q, ..) in trees(4) {
        let n = robot.dof();
        let mut h = DMatrix::zeros(n, n);
        Dynamics::new(&robot).mass_matrix(&q, &mut h);
        assert_eq!(h, h.transpose());
        assert!(h.cholesky().is_some());
    }
}

#[test]
fn property_coriolis_matrix_gives_the_bias_and_leaves_h_dot_minus_2c_skew() {
    for (robot, q, v, _) in trees(5) {
        let n = robot.dof();
        let mut dynamics = Dynamics::new(&robot);
        let mut c = DMatrix::zeros(n, n);
        dynamics.coriolis_matrix(&q, &v, &mut c);
        let [mut bias, mut gravity] = [vec![0.0; n], vec![0.0; n]];
        dynamics.bias(&q, &v, &mut bias);
        dynamics.gravity(&q, &mut gravity);
        let sum = &c * DVector::from_column_slice(&v) + DVector::from_column_slice(&gravity);
        close(sum.as_slice(), &bias, ROUNDING);

        let at = |dynamics: &mut Dynamics, t: f64| {
            let moved: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + v * t).collect();
            let mut h = DMatrix::zeros(n, n);
            dynamics.mass_matrix(&moved, &mut h);
            h
        };
        // Central differences of fourth order: truncation t⁴ |v|⁵ H and rounding 1e-16 H / t are both below 1e-9 of C.
        let t = 1e-3;
        let [a, b] = [t, 2.0 * t].map(|t| at(&mut dynamics, t) - at(&mut dynamics, -t));
        let h_dot = (a * 8.0 - b) / (12.0 * t);
        let skew = &h_dot - &c * 2.0;
        let symmetric = &skew + skew.transpose();
        assert!(symmetric.amax() <= 1e-8 * h_dot.amax().max(1.0), "{}", symmetric.amax());
    }
}

#[test]
fn equivalent_regressor_times_parameters_is_inverse_dynamics() {
    for (robot, q, v, a) in trees(6) {
        let n = robot.dof();
        let mut dynamics = Dynamics::new(&robot);
        let mut y = DMatrix::zeros(n, 10 * n);
        dynamics.regressor(&q, &v, &a, &mut y);
        let parameters: Vec<f64> = robot.bodies.iter().flat_map(|body| body.inertia.parameters()).collect();
        let mut tau = vec![0.0; n];
        dynamics.inverse(&q, &v, &a, &mut tau);
        close((y * DVector::from_vec(parameters)).as_slice(), &tau, ROUNDING);
    }
}

#[test]
fn property_energy_is_kept_and_work_is_accounted_for() {
    let mut rng = random(7);
    for n in [1, 2, 3, 5] {
        let robot = random_tree(&mut rng, n);
        let mut dynamics = Dynamics::new(&robot);
        let mut state = DVector::from_vec(numbers(&mut rng, 2 * n, 1.0));
        let energy = |state: &DVector<f64>, dynamics: &mut Dynamics| {
            let (q, v) = state.as_slice().split_at(n);
            dynamics.kinetic_energy(q, v) + dynamics.potential_energy(q)
        };
        let before = energy(&state, &mut dynamics);
        let rate = |state: &DVector<f64>, dynamics: &mut Dynamics| {
            let (q, v) = state.as_slice().split_at(n);
            let mut a = vec![0.0; n];
            dynamics.forward(q, v, &vec![0.0; n], &mut a);
            DVector::from_iterator(2 * n, v.iter().copied().chain(a))
        };
        // Runge-Kutta of fourth order over 1 s: 1e-4 s keeps its own error far below the bound.
        let dt = 1e-4;
        for _ in 0..10_000 {
            let k1 = rate(&state, &mut dynamics);
            let k2 = rate(&(&state + &k1 * (dt / 2.0)), &mut dynamics);
            let k3 = rate(&(&state + &k2 * (dt / 2.0)), &mut dynamics);
            let k4 = rate(&(&state + &k3 * dt), &mut dynamics);
            state += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (dt / 6.0);
        }
        let after = energy(&state, &mut dynamics);
        let (q, v) = state.as_slice().split_at(n);
        let scale = dynamics.kinetic_energy(q, v).max(1.0);
        assert!((after - before).abs() < 1e-9 * scale, "{n} joints: {before} J, then {after} J");
    }
}

#[test]
fn property_gravity_is_the_gradient_of_the_potential_energy() {
    for (robot, q, ..) in trees(8) {
        let n = robot.dof();
        let mut dynamics = Dynamics::new(&robot);
        let mut tau = vec![0.0; n];
        dynamics.gravity(&q, &mut tau);
        let k = random(n as u64).random_range(0..n);
        let mut at = |step: f64| {
            let mut q = q.clone();
            q[k] += step;
            dynamics.potential_energy(&q)
        };
        // Central difference: truncation step² and rounding 1e-16 U / step, both near 1e-9 of the energies.
        let step = 1e-5;
        let slope = (at(step) - at(-step)) / (2.0 * step);
        assert!((slope - tau[k]).abs() < 1e-7 * tau[k].abs().max(100.0), "{slope} against {}", tau[k]);
    }
}

#[test]
fn analytic_poses_follow_the_joints() {
    let mut dynamics = Dynamics::new(&from_urdf(PLANAR, &["a", "b"]));
    let q = [0.3, 0.5];
    let poses = dynamics.poses(&q);
    let elbow = [0.4 * q[0].cos(), 0.0, 0.4 * q[0].sin()];
    close(poses[1].translation.vector.as_slice(), &elbow, ROUNDING);
    let tip = poses[1] * nalgebra::Point3::new(1.0, 0.0, 0.0);
    let (sin, cos) = (q[0] + q[1]).sin_cos();
    close(tip.coords.as_slice(), &[elbow[0] + cos, 0.0, elbow[2] + sin], ROUNDING);
}

mod motion {
    use super::from_urdf;
    use lostmotion::dynamics::{MotionCheck, STEP};
    use lostmotion::error::MotionFault;

    /// Two arms of 0.5 m, 4 cm thick, that turn about the vertical in one plane, beside a pillar at (0.3, 0.7).
    const ARM: &str = r#"<robot name="arm">
      <link name="floor"><collision><origin xyz="0.3 0.7 0"/><geometry><cylinder radius="0.05" length="1"/></geometry></collision></link>
      <link name="one"><inertial><origin xyz="0.25 0 0"/><mass value="1"/>
        <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
        <collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision></link>
      <link name="two"><inertial><origin xyz="0.25 0 0"/><mass value="1"/>
        <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
        <collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision></link>
      <link name="hand"><inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
        <collision><geometry><sphere radius="0.03"/></geometry></collision></link>
      <joint name="a" type="revolute"><parent link="floor"/><child link="one"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
      <joint name="b" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
        <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>
      <joint name="c" type="prismatic"><parent link="two"/><child link="hand"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
        <limit lower="-0.2" upper="0.2" effort="1" velocity="1"/></joint>
    </robot>"#;

    /// From 0 to the given angles in one second.
    fn swing(to: [f64; 3], samples: usize) -> Result<(), lostmotion::error::MotionError> {
        let mut check = MotionCheck::new(&from_urdf(ARM, &["a", "b", "c"])).unwrap();
        let times: Vec<f64> = (0..samples).map(|k| k as f64 / (samples - 1) as f64).collect();
        let paths = to.map(|to| times.iter().map(|t| to * t).collect::<Vec<f64>>());
        check.check(&times, &[&paths[0], &paths[1], &paths[2]])
    }

    #[test]
    fn analytic_limit_is_refused_at_the_time_it_is_passed() {
        let error = swing([0.0, 0.0, 0.4], 1001).unwrap_err();
        assert!((error.time - 0.501).abs() < 1e-9, "{error}");
        assert_eq!(
            error.to_string(),
            "planned motion refused at t = 0.501 s: c at 0.2004 leaves its range [-0.2000, 0.2000] (rad or m)"
        );
        // Up to the limit itself is allowed.
        assert_eq!(swing([0.0, 0.0, 0.2], 1001), Ok(()));
    }

    #[test]
    fn analytic_straight_arm_meets_the_pillar_when_its_edge_reaches_it() {
        // The pillar stands at atan2(0.7, 0.3) = 1.1659 rad, 0.7616 m out; the straight arm is 4 cm wide, so that they
        // touch once the distance of the pillar's axis from the arm's is 0.07 m: at 1.1659 − asin(0.07/0.7616) = 1.0738.
        let expected = 0.7_f64.atan2(0.3) - (0.07 / 0.7_f64.hypot(0.3)).asin();
        for samples in [2, 40, 2001] {
            let error = swing([1.5, 0.0, 0.0], samples).unwrap_err();
            let angle = 1.5 * error.time;
            assert!(angle >= expected - 1e-6 && angle <= expected + 2.0 * STEP, "{angle} against {expected}");
            assert_eq!(error.cause, MotionFault::Collision { first: "floor".into(), second: "two".into() });
        }
    }

    #[test]
    fn property_a_motion_that_passes_close_by_is_accepted() {
        // 4 mm before the arm would touch the pillar.
        let touch = 0.7_f64.atan2(0.3) - (0.07 / 0.7_f64.hypot(0.3)).asin();
        assert_eq!(swing([touch - 0.004 / 0.7616, 0.0, 0.0], 500), Ok(()));
        assert!(swing([touch + 0.004 / 0.7616, 0.0, 0.0], 500).is_err());
        // Lifted hand, folded arm: the hand passes 2 cm above the first arm, whose neighbour's neighbour it is.
        assert_eq!(swing([0.0, -3.1, 0.07], 500), Ok(()));
        let error = swing([0.0, -3.1, 0.04], 500).unwrap_err();
        assert_eq!(error.cause, MotionFault::Collision { first: "one".into(), second: "hand".into() });
    }
}
