//! References, controllers and the observer, against closed forms.

use lostmotion::control::{
    Controller, EdgeObserver, Excitation, JointRange, Motion, ObserverNoise, Pi, PiGains, Profile, SlidingGains,
    SlidingMode, SpeedSequence, SpeedStep, Staircase, Steps, Target, Terms, Track, sat,
};
use lostmotion::units::DEG;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A two-link arm in a horizontal plane: `H₁₁ = a + 2 b cos q₂`, `H₁₂ = d + b cos q₂`, `H₂₂ = d`.
#[derive(Debug, Clone, Copy)]
struct TwoLinks {
    a: f64,
    b: f64,
    d: f64,
}

impl TwoLinks {
    /// Positive definite for every angle: `a d > d² + b²` and `a > 2 b` hold by construction.
    fn random(random: &mut ChaCha8Rng) -> Self {
        let [m1, m2, l1, c2] = [0; 4].map(|_| 0.3 + random.random::<f64>());
        Self { a: m1 + m2 * (l1 * l1 + c2 * c2), b: m2 * l1 * c2, d: m2 * c2 * c2 + 0.05 }
    }

    fn h(&self, q: &[f64]) -> DMatrix<f64> {
        let c2 = q[1].cos();
        let h12 = self.d + self.b * c2;
        DMatrix::from_row_slice(2, 2, &[self.a + 0.05 + 2.0 * self.b * c2, h12, h12, self.d])
    }

    /// Christoffel's, so that `Ḣ − 2 C` is skew-symmetric.
    fn c(&self, q: &[f64], v: &[f64]) -> DMatrix<f64> {
        let k = -self.b * q[1].sin();
        DMatrix::from_row_slice(2, 2, &[k * v[1], k * (v[0] + v[1]), -k * v[0], 0.0])
    }
}

/// One integration of the arm under equation 18 with a disturbance; the largest relative growth of V in a step outside the
/// boundary layer of both joints, and the number of such steps.
fn largest_growth(random: &mut ChaCha8Rng, switching: f64, bound: f64) -> (f64, usize) {
    const PHI: f64 = 0.02;
    let arm = TwoLinks::random(random);
    let gains = [0, 1].map(|_| SlidingGains { lambda: 0.5 + 5.0 * random.random::<f64>(), switching, boundary: PHI });
    let mut controller = SlidingMode::new(gains.to_vec());
    let mut track = || {
        let mut track = Track::at(random.random::<f64>());
        (0..8).for_each(|_| track.accelerate(4.0 * random.random::<f64>() - 2.0, 0.1));
        track
    };
    let profile = Profile::new(vec![track(), track()]);
    let mut q = [0.4, -0.3].map(|offset: f64| offset + random.random::<f64>());
    let mut v = [1.0, -1.0].map(|offset: f64| offset + random.random::<f64>());
    let (dt, mut targets, mut tau) = (2e-5, [Target::default(); 2], [0.0; 2]);
    let (mut last, mut growth, mut steps) = (None, f64::NEG_INFINITY, 0);
    for step in 0..40_000 {
        profile.sample(f64::from(step) * dt, &mut targets);
        let (h, c) = (arm.h(&q), arm.c(&q, &v));
        let s = DVector::from_fn(2, |i, _| controller.error_metric(i, &targets[i], q[i], v[i]));
        let value = 0.5 * (s.transpose() * &h * &s)[0];
        let outside = s.iter().all(|s| s.abs() > PHI);
        if let (Some(last), true) = (last, outside) {
            growth = growth.max((value - last) / last);
            steps += 1;
        }
        last = outside.then_some(value);
        controller.torque(&targets, Motion { q: &q, v: &v }, &Terms { h: &h, c: &c, g: &[0.0; 2] }, &mut tau);
        // The worst disturbance against V: it drives S away from zero (equation 17 has +d on the left).
        let push = DVector::from_fn(2, |i, _| tau[i] + bound * s[i].signum());
        let rates = h.cholesky().expect("positive definite").solve(&(push - &c * DVector::from_column_slice(&v)));
        for i in 0..2 {
            v[i] += dt * rates[i];
            q[i] += dt * v[i];
        }
    }
    (growth, steps)
}

#[test]
fn property_the_lyapunov_function_never_grows_outside_the_boundary_layer() {
    let mut random = ChaCha8Rng::seed_from_u64(19);
    let mut seen = 0;
    for _ in 0..20 {
        let switching = 2.0 + 3.0 * random.random::<f64>();
        let (growth, steps) = largest_growth(&mut random, switching, 0.9 * switching);
        seen += steps;
        // Steps of 20 µs change V by up to 1e-3; what a first-order step adds to it is 1e-6 and below.
        assert!(growth < 1e-6, "V grew by {growth:.2e} of itself");
    }
    assert!(seen > 10_000, "only {seen} steps outside the boundary layer");
}

#[test]
fn property_negative_control_it_grows_where_the_gain_is_below_the_disturbance() {
    let mut random = ChaCha8Rng::seed_from_u64(19);
    let grew = (0..20).filter(|_| largest_growth(&mut random, 1.0, 3.0).0 > 1e-6).count();
    assert_eq!(grew, 20);
}

#[test]
fn equivalent_the_error_obeys_equation_21() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    for _ in 0..200 {
        let arm = TwoLinks::random(&mut random);
        let mut draw = || 4.0 * random.random::<f64>() - 2.0;
        let gains = [0, 1].map(|_| SlidingGains { lambda: 1.0 + draw().abs(), switching: 3.0, boundary: 0.5 });
        let mut controller = SlidingMode::new(gains.to_vec());
        let target =
            [0, 1].map(|_| Target { position: draw(), velocity: draw(), acceleration: draw(), ..Target::default() });
        let (q, v, d, g) = ([draw(), draw()], [draw(), draw()], [draw(), draw()], [draw(), draw()]);
        let (h, c) = (arm.h(&q), arm.c(&q, &v));
        let mut tau = [0.0; 2];
        controller.torque(&target, Motion { q: &q, v: &v }, &Terms { h: &h, c: &c, g: &g }, &mut tau);
        // Equation 17 solved for the acceleration, then Ṡ = q̈ − q̈_d + Λ ė.
        let push = DVector::from_fn(2, |i, _| tau[i] - d[i] - g[i]) - &c * DVector::from_column_slice(&v);
        let a = h.clone().cholesky().expect("positive definite").solve(&push);
        let s = DVector::from_fn(2, |i, _| controller.error_metric(i, &target[i], q[i], v[i]));
        let s_dot =
            DVector::from_fn(2, |i, _| a[i] - target[i].acceleration + gains[i].lambda * (v[i] - target[i].velocity));
        let switched = DVector::from_fn(2, |i, _| gains[i].switching * sat(s[i] / gains[i].boundary) + d[i]);
        let residual = &h * s_dot + &c * s + switched;
        // Rounding of sums of terms up to 100.
        assert!(residual.amax() < 1e-11, "{residual}");
    }
}

#[test]
fn analytic_pi_is_proportional_and_integral() {
    let mut pi = Pi::new(vec![PiGains { proportional: 2.0, integral: 5.0 }]);
    let target = [Target { position: 1.0, velocity: 0.5, acceleration: 9.0, ..Target::default() }];
    let zero = DMatrix::zeros(1, 1);
    let mut tau = [0.0];
    pi.torque(&target, Motion { q: &[0.8], v: &[0.9] }, &Terms { h: &zero, c: &zero, g: &[7.0] }, &mut tau);
    assert!((tau[0] - (-2.0 * 0.4 + 5.0 * 0.2)).abs() < 1e-15);
}

#[test]
fn published_the_staircase_is_that_of_figure_2() {
    let steps = Steps { first: 0.5 * DEG, last: 10.0 * DEG, increment: 0.5 * DEG };
    assert_eq!(steps.speeds().count(), 20);
    let mut profile = Profile::at_rest(&[0.3, -0.2]);
    let stairs = Staircase {
        joint: 1,
        steps,
        acceleration: 6.0 * DEG,
        deceleration: 2.0 * DEG,
        gentle: None,
        steady_time: 1.0,
        settling_way: 2.0 * DEG,
        advance: 0.0,
        direction: 1.0,
    };
    stairs.append(&mut profile);
    let expected: f64 = (1..=20).map(|k| 0.5 * f64::from(k)).map(|v| 2.0 * (v / 6.0 + v / 2.0 + 1.0 + 2.0 / v)).sum();
    assert!((profile.duration() - expected).abs() < 1e-9, "{} s, expected {expected} s", profile.duration());
    // One joint at a time, back where it began, and every speed in both directions for at least a second.
    assert_eq!(profile.tracks()[0].duration(), 0.0);
    assert!((profile.tracks()[1].end().position + 0.2).abs() < 1e-12);
    for speed in steps.speeds() {
        for signed in [speed, -speed] {
            let steady = (0..(expected * 100.0) as usize)
                .filter(|&k| (profile.tracks()[1].sample(k as f64 * 0.01).velocity - signed).abs() < 1e-9)
                .count();
            assert!(steady >= 100, "{signed} rad/s for {steady} hundredths of a second");
        }
    }
}

#[test]
fn property_references_are_the_integral_of_their_velocity_and_it_of_their_acceleration() {
    let range = |speed| JointRange { positions: [-2.0, 2.0], speed, acceleration: 3.0 };
    let excitation = Excitation {
        joints: vec![Some(range(2.0)), None, Some(range(0.4))],
        duration: 20.0,
        longest_rest: 0.3,
        seed: 4,
    };
    let start = [0.1, 0.2, 0.3];
    let profile = excitation.profile(&start).unwrap();
    assert_eq!(profile.start(), start);
    let (dt, mut last, mut now) = (1e-3, [Target::default(); 3], [Target::default(); 3]);
    profile.sample(0.0, &mut last);
    let mut fastest = [0.0_f64; 3];
    for k in 1..(profile.duration() / dt) as usize + 100 {
        profile.sample(k as f64 * dt, &mut now);
        for i in 0..3 {
            // Trapezoids across a change of acceleration of 6 rad/s² at most.
            let mean = 0.5 * (last[i].velocity + now[i].velocity);
            assert!((now[i].position - last[i].position - dt * mean).abs() < 6.0 * dt * dt);
            assert!((now[i].velocity - last[i].velocity).abs() < 3.0 * dt + 1e-12);
            assert!(now[i].position.abs() < 2.0 + 1e-9);
            fastest[i] = fastest[i].max(now[i].velocity.abs());
        }
        last = now;
    }
    assert!(fastest[0] > 1.0 && fastest[0] <= 2.0 + 1e-12 && fastest[1] == 0.0 && fastest[2] <= 0.4 + 1e-12);
    assert_ne!(profile, Excitation { seed: 5, ..excitation }.profile(&start).unwrap());
}

#[test]
fn analytic_a_move_takes_the_shortest_time() {
    // Far: trapezoid, way/speed + speed/acceleration. Near: triangle, 2 √(way/acceleration).
    for (way, time) in [(3.0, 3.0 / 1.5 + 1.5 / 2.0), (-0.5, 2.0 * (0.25_f64).sqrt()), (0.0, 0.0)] {
        let mut track = Track::at(0.7);
        track.move_to(0.7 + way, 1.5, 2.0);
        assert!((track.duration() - time).abs() < 1e-12, "{way}: {} s", track.duration());
        assert_eq!(track.end().position, 0.7 + way);
        assert_eq!(track.end().velocity, 0.0);
    }
}

/// Joint 1 of the paper's arm: counts of 0.58 mrad.
const COUNT: f64 = 2.0 * std::f64::consts::PI / (2000.0 * 5.375);
const NOISE: ObserverNoise = ObserverNoise { disturbance: 0.1, velocity: 0.01, edge: 0.05 };

/// Reading of an encoder.
fn read(position: f64) -> f64 {
    ((position / COUNT).floor() + 0.5) * COUNT
}

#[test]
fn recover_velocity_and_friction_from_encoder_edges() {
    let (inertia, friction, h) = (2.1, 0.3, 1e-3);
    for speed in [0.5 * DEG, -0.5 * DEG, 5.0 * DEG] {
        let mut observer = EdgeObserver::new(COUNT, NOISE, read(0.0));
        let (mut worst, mut mean) = (0.0_f64, 0.0);
        for k in 1..=20_000 {
            observer.update(read(speed * f64::from(k) * h), friction * speed.signum(), inertia, h);
            if k > 15_000 {
                worst = worst.max((observer.velocity() - speed).abs() / speed.abs());
                mean += observer.disturbance() / 5000.0;
            }
        }
        // The random walk that it allows its disturbance lets the velocity ripple by a few per cent between edges.
        assert!(worst < 0.05, "{speed} rad/s: off by {:.1} %", 100.0 * worst);
        assert!((mean - friction * speed.signum()).abs() < 0.01 * friction, "friction {mean}");
    }
}

#[test]
fn recover_a_velocity_step_sooner_than_two_edges_would_tell() {
    // Torque that accelerates is known to the observer at once; edges come 67 ms apart here.
    let (inertia, h, a) = (2.1, 1e-3, 2.0 * DEG);
    let mut observer = EdgeObserver::new(COUNT, NOISE, read(0.0));
    let (mut q, mut v, mut worst) = (0.0, 0.5 * DEG, 0.0_f64);
    for k in 1..=12_000 {
        let tau = if (10_000..10_500).contains(&k) { inertia * a } else { 0.0 };
        v += h * tau / inertia;
        q += h * v;
        observer.update(read(q), tau, inertia, h);
        if k >= 10_000 {
            worst = worst.max((observer.velocity() - v).abs());
        }
    }
    // A measured period would lag by one edge: 67 ms of 2 deg/s², 0.13 deg/s.
    assert!(worst < 0.05 * DEG, "off by {} deg/s", worst / DEG);
}

#[test]
fn property_a_joint_at_rest_is_seen_at_rest() {
    // Torque below breakaway rises and falls; no edge comes.
    let mut observer = EdgeObserver::new(COUNT, NOISE, read(0.0));
    for k in 0..20_000 {
        let tau = 0.3 * (f64::from(k) * 1e-3).sin();
        observer.update(read(0.0), tau, 2.1, 1e-3);
        assert!((observer.position() - read(0.0)).abs() <= COUNT, "at {} s", f64::from(k) * 1e-3);
    }
    assert!(observer.velocity().abs() < 0.5 * DEG, "{} deg/s", observer.velocity() / DEG);
}

#[test]
fn analytic_a_sequence_of_speeds_goes_on_without_a_stop_and_brakes_as_each_step_says() {
    let step = |velocity, duration, deceleration| SpeedStep { velocity, duration, deceleration };
    let mut profile = Profile::at_rest(&[0.5, 0.0]);
    let steps = vec![step(0.1, 2.0, 0.5), step(0.3, 1.0, 0.1), step(-0.2, 1.0, 0.2), step(-0.1, 1.0, 0.5)];
    SpeedSequence { joint: 0, acceleration: 1.0, steps }.append(&mut profile);
    let at = |time: f64| profile.tracks()[0].sample(time);
    // Exact but for the rounding of the sums of times, 1e-15 s each.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} for {b}");
    near(at(1.0).velocity, 0.1);
    // 0.1 s + 2 s, then from 0.1 to 0.3 in 0.2 s without a stop.
    near(at(2.2).velocity, 0.2);
    near(at(3.0).velocity, 0.3);
    // From 3.3 s on it brakes with 0.1 for 3 s, then accelerates in the other direction with 1.
    near(at(4.8).velocity, 0.15);
    near(at(6.4).velocity, -0.1);
    // From -0.2 at 7.5 s to -0.1 with 0.2, held for 1 s, to rest with 0.5.
    near(at(7.75).velocity, -0.15);
    near(profile.duration(), 9.2);
    assert_eq!(profile.tracks()[0].end().velocity, 0.0);
    let way = 0.005 + 0.2 + 0.04 + 0.3 + 0.45 - 0.02 - 0.2 - 0.075 - 0.1 - 0.01;
    near(profile.tracks()[0].end().position, 0.5 + way);
    assert_eq!(profile.tracks()[1].end().position, 0.0);
}
