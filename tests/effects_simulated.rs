//! The catalogue in a moving machine: each effect against its closed form, the books of energy with every effect at work, and the
//! negative control: an effect of size zero does not change a bit.

#[path = "support/machines.rs"]
mod machines;

use std::f64::consts::PI;

use lostmotion::drive::LinkEncoder;
use lostmotion::effects::{CATALOGUE, JointState, Scope};
use lostmotion::gearhead::Friction;
use lostmotion::plant::{Engine, Options, Plant};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use machines::*;

/// [rad] 1e-4 degrees: what is promised of a motion.
const EXACT: f64 = 1.7e-6;

/// [N·m] Friction that nothing here overcomes.
const VICE: f64 = 1e9;

/// [kg·m²] A rotor that nothing here slows down.
const FLYWHEEL: f64 = 1e12;

/// `J` [kg·m²] of the plain joint's rotor.
const J: f64 = 0.02;

/// `I` [kg·m²] of the link.
const I: f64 = 0.05;

fn with(mut model: Model, effect: &str, parameters: &[(&str, f64)]) -> Model {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let machine = lostmotion::effects::find(effect).unwrap().about().scope == Scope::Machine;
    let joint = (!machine).then(|| model.joints[0].name.clone());
    model.effects.push(EffectEntry { effect: effect.to_owned(), joint, parameters });
    model
}

fn ideal(model: &Model) -> Plant {
    let options = Options { engine: Engine::Reduced, ideal_sensors: true, ..Options::default() };
    Plant::new(model, &options).unwrap()
}

/// Rotor and link on a gear without gap and friction.
fn two_inertias() -> Model {
    model(turntable(I), vec![plain_joint("joint1")])
}

/// A rotor in a gap so wide that it never meets its link, with its friction.
fn rotor_alone(friction: Option<Friction>) -> Model {
    model(turntable(I), vec![JointModel { backlash: Some(1e6), friction, ..plain_joint("joint1") }])
}

/// A link on the gear of a rotor that stands still, whatever happens.
fn rotor_in_a_vice(joint: JointModel) -> Model {
    model(turntable(I), vec![JointModel { friction: Some(friction(VICE, VICE, 1.0, 0.0, 0.0)), ..joint }])
}

fn turning(velocity: f64) -> JointState {
    JointState { motor_velocity: velocity, link_velocity: velocity, ..JointState::default() }
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    println!("{what}: {found:.9}, off by {error:.1e}");
    assert!(error <= tolerance, "{what}: {found:e} instead of {expected:e}, off by {error:e}");
}

/// An effect, its parameters, and the parameter whose value makes it nothing.
type Amount = (&'static str, Vec<(&'static str, f64)>, Option<(&'static str, f64)>);

/// Every effect at a size that matters in the planar arm.
fn sizes() -> Vec<Amount> {
    vec![
        ("base_tilt", vec![("tilt", 0.1), ("azimuth", 0.5)], Some(("tilt", 0.0))),
        ("cable_spring", vec![("stiffness", 0.4), ("rest_position", 0.1)], Some(("stiffness", 0.0))),
        ("cogging", vec![("amplitude", 0.05), ("order", 4.0)], Some(("amplitude", 0.0))),
        ("coulomb_asymmetry", vec![("asymmetry", 0.3)], Some(("asymmetry", 0.0))),
        ("counterbalance", vec![("amplitude", 0.6), ("angle", 0.4)], Some(("amplitude", 0.0))),
        ("coupling_slip", vec![("jump", 0.02), ("time", 0.5), ("duration", 0.02)], Some(("jump", 0.0))),
        ("current_offset", vec![("offset", 0.3)], Some(("offset", 0.0))),
        ("drive_dead_band", vec![("width", 0.8)], Some(("width", 0.0))),
        (
            "dwell_stiction",
            vec![("growth", 0.3), ("time_constant", 0.5), ("slip_distance", 0.01)],
            Some(("growth", 0.0)),
        ),
        ("encoder_eccentricity", vec![("amplitude", 0.01)], Some(("amplitude", 0.0))),
        // Size zero: out of reach.
        ("external_contact", vec![("angle", 0.35), ("stiffness", 200.0), ("damping", 0.5)], Some(("angle", 1e3))),
        ("joint_compliance", vec![("stiffness", 400.0)], Some(("stiffness", 3000.0))),
        // As with a payload, a difference of zero rounds the link's inertia.
        ("link_inertia", vec![("mass", 0.2), ("moment_x", 0.02), ("inertia_zz", 0.01)], None),
        ("load_dependent_friction", vec![("coefficient", 0.2)], Some(("coefficient", 0.0))),
        // A mass of zero is joined with the link's inertia, and rounds it.
        ("payload", vec![("mass", 0.5), ("x", 0.2)], None),
        ("periodic_disturbance", vec![("amplitude", 0.3), ("frequency", 17.0)], Some(("amplitude", 0.0))),
        ("position_dependent_backlash", vec![("amplitude", 0.009), ("order", 20.0)], Some(("amplitude", 0.0))),
        ("position_dependent_friction", vec![("amplitude", 0.3), ("order", 3.0)], Some(("amplitude", 0.0))),
        // It replaces the law of friction: there is no size at which it is that law.
        ("presliding", vec![("stiffness", 2000.0), ("damping", 3.0)], None),
        ("quadratic_drag", vec![("coefficient", 0.1)], Some(("coefficient", 0.0))),
        // The steeper, the nearer to the law; as steep as that takes steps below a microsecond.
        ("regularised_friction", vec![("velocity", 0.05)], None),
        ("rotor_inertia", vec![("error", 0.3)], Some(("error", 0.0))),
        ("sensor_delay", vec![("current_delay", 0.003)], Some(("current_delay", 0.0))),
        ("stribeck", vec![("breakaway", 0.6), ("stribeck_velocity", 0.05)], None),
        ("thermal_friction_drift", vec![("excess", 0.8), ("time_constant", 2.0)], Some(("excess", 0.0))),
        ("torque_constant_error", vec![("error", 0.2)], Some(("error", 0.0))),
        ("torque_ripple", vec![("amplitude", 0.2), ("order", 6.0)], Some(("amplitude", 0.0))),
        ("transmission_error", vec![("amplitude", 0.002), ("teeth", 60.0)], Some(("amplitude", 0.0))),
        ("velocity_lag", vec![("delay", 0.005)], Some(("delay", 0.0))),
        ("viscous_asymmetry", vec![("positive", 0.5), ("negative", 0.3)], None),
    ]
}

/// A vigorous motion of the planar arm with reversals; returns every bit of its states and readings.
fn exercise(plant: &mut Plant, seconds: f64) -> Vec<u64> {
    plant.place(&[0.3, -0.5]);
    let mut bits = Vec::new();
    for k in 0..(seconds * 1e3) as usize {
        let t = k as f64 * 1e-3;
        bits.extend(plant.read().iter().flat_map(|r| [r.position, r.velocity, r.current].map(f64::to_bits)));
        plant.advance(&[9.0 * (3.0 * t).sin(), 5.0 * (5.0 * t + 1.0).sin()], 1e-3).unwrap();
        let states = plant.states().iter();
        bits.extend(states.flat_map(|s| [s.motor_position, s.link_position, s.link_velocity].map(f64::to_bits)));
    }
    bits
}

#[test]
fn property_sizes_name_the_whole_catalogue() {
    let named: Vec<&str> = sizes().iter().map(|(name, ..)| *name).collect();
    let catalogue: Vec<&str> = CATALOGUE.iter().map(|effect| effect.name()).collect();
    assert_eq!(named, catalogue);
    assert_eq!(catalogue.len(), 30, "as many as the catalogue is said to have");
}

#[test]
fn property_an_effect_of_no_size_changes_no_bit_and_one_of_some_size_does() {
    let run = |model: &Model| exercise(&mut Plant::new(model, &Options::default()).unwrap(), 1.0);
    let nominal = run(&scara());
    for (effect, mut parameters, zero) in sizes() {
        assert_ne!(run(&with(scara(), effect, &parameters)), nominal, "{effect} does nothing");
        let Some((name, value)) = zero else { continue };
        // What wears off slowly does not ask for shorter steps.
        parameters.retain(|(key, _)| *key != name && *key != "slip_distance");
        parameters.push((name, value));
        if effect == "dwell_stiction" {
            parameters.push(("slip_distance", 1.0));
        }
        assert_eq!(run(&with(scara(), effect, &parameters)), nominal, "{effect} with {name} = {value}");
    }
}

#[test]
fn property_energy_closes_with_every_effect() {
    for (effect, parameters, _) in sizes() {
        let mut plant = ideal(&with(scara(), effect, &parameters));
        plant.place(&[0.3, -0.5]);
        let start = plant.energy();
        exercise(&mut plant, 3.0);
        let end = plant.energy();
        let gap = end.work - end.dissipated - (end.stored - start.stored);
        println!("{effect}: {gap:.1e} of {:.3} J", end.work);
        // 1e-4: what is asked of the plant without effects.
        assert!(gap.abs() < 1e-4 * end.work, "{effect}: {gap:e} of {} J", end.work);
    }
}

/// `v = v_r artanh(τ/F)` under half of the friction, after the time `v_r J/F = 0.5 ms` many times over.
#[test]
fn analytic_a_joint_of_regularised_friction_creeps() {
    let (f, v_r, torque) = (0.4, 0.01, 0.2);
    let machine = rotor_alone(Some(friction(f, f, 1.0, 0.0, 0.0)));
    let mut plant = ideal(&with(machine.clone(), "regularised_friction", &[("velocity", v_r)]));
    plant.advance(&[torque], 0.5).unwrap();
    let before = plant.states()[0].motor_position;
    plant.advance(&[torque], 1.0).unwrap();
    let state = plant.states()[0];
    let creep = v_r * (torque / f).atanh();
    near("creep", state.motor_velocity, creep, 1e-9);
    near("way", state.motor_position - before, creep, EXACT);
    // The law of a machine holds.
    let mut machine = ideal(&machine);
    machine.advance(&[torque], 1.5).unwrap();
    near("held", machine.states()[0].motor_position, 0.0, 0.0);
}

/// `I q̈ = −c sin(q − q0)` for a link that swings with its rotor: the energy `c (1 − cos(q − q0))` becomes speed.
#[test]
fn analytic_a_counterbalance_pulls_towards_its_angle() {
    let (c, q0) = (0.8, 0.7);
    let mut plant = ideal(&with(two_inertias(), "counterbalance", &[("amplitude", c), ("angle", q0)]));
    plant.place(&[0.1]);
    let mut fastest = 0.0_f64;
    for _ in 0..1500 {
        plant.advance(&[0.0], 1e-3).unwrap();
        fastest = fastest.max(plant.states()[0].link_velocity);
    }
    let expected = (2.0 * c * (1.0 - (0.1_f64 - q0).cos()) / (I + J)).sqrt();
    // The gear of 3000 N·m/rad swings with c sin/k = 0.2 mrad at sqrt(k/J), 0.05 rad/s at most; a sample a millisecond.
    near("speed at q0", fastest, expected, 0.05);
}

/// `(J + I) s̈ = τ` for the centre of inertia, however the gear swings.
#[test]
fn analytic_rotor_inertia_and_torque_constant_scale_what_they_are() {
    let (torque, a) = (0.4, 0.25);
    let centre = |model: &Model, j: f64| {
        let mut plant = ideal(model);
        plant.advance(&[torque], 0.5).unwrap();
        let current = plant.read()[0].current;
        let state = plant.states()[0];
        near("the sensor reads amperes", current, torque, 0.0);
        (j * state.motor_position + I * state.link_position) / (j + I)
    };
    let heavy = (1.0 + a) * J;
    let s = centre(&with(two_inertias(), "rotor_inertia", &[("error", a)]), heavy);
    near("heavier rotor [rad]", s, 0.5 * torque / (heavy + I) * 0.25, EXACT);
    let s = centre(&with(two_inertias(), "torque_constant_error", &[("error", a)]), J);
    near("stronger motor [rad]", s, 0.5 * (1.0 + a) * torque / (J + I) * 0.25, EXACT);
}

/// `x = v₀/ω_d e^{−δt} sin ω_d t`, `ω² = k (1/J + 1/I)`, `2δ = d (1/J + 1/I)`, `d` in the nominal proportion to `k`.
#[test]
fn analytic_a_soft_gear_swings_slowly() {
    let (k, v0) = (200.0, 0.5);
    let inverse = 1.0 / J + 1.0 / I;
    let (omega, delta) = ((k * inverse).sqrt(), 0.5 * 2.0 * k / 3000.0 * inverse);
    let omega_d = (omega * omega - delta * delta).sqrt();
    let mut plant = ideal(&with(two_inertias(), "joint_compliance", &[("stiffness", k)]));
    plant.launch(&[JointState { motor_velocity: v0, ..JointState::default() }]);
    for step in 1..=200 {
        plant.advance(&[0.0], 1e-3).unwrap();
        let t = 1e-3 * f64::from(step);
        let state = plant.states()[0];
        let x = v0 / omega_d * (-delta * t).exp() * (omega_d * t).sin();
        assert!((state.motor_position - state.link_position - x).abs() < EXACT, "at {t} s");
    }
}

/// The work of a ripple is an integral over the angle: `K i (Δθ − a/n (cos(nθ₁ + φ) − cos(nθ₀ + φ)))`, however the rotor moves; that of
/// cogging, `−τ_c/n (cos(nθ₁ + φ) − …)`, does not know of the current.
#[test]
fn analytic_ripple_works_with_the_current_and_cogging_without() {
    let (n, phi) = (5.0, 0.7);
    let wave = |theta: f64| ((n * theta + phi).cos() - phi.cos()) / n;
    for current in [0.0, 0.5, 1.0] {
        let shared = [("order", n), ("phase", phi)];
        let run = |effect: &str, amplitude: f64| {
            let parameters = [&[("amplitude", amplitude)], &shared[..]].concat();
            let mut plant = ideal(&with(two_inertias(), effect, &parameters));
            plant.launch(&[turning(2.0)]);
            plant.advance(&[current], 0.8).unwrap();
            (plant.energy().work, plant.states()[0].motor_position)
        };
        // 1e-7 J of 2 J: the rotor turns 0.01 rad of the wave a step, and Simpson's rule sums its work up.
        let (work, theta) = run("torque_ripple", 0.3);
        near("work of ripple [J]", work, current * (theta - 0.3 * wave(theta)), 1e-7);
        let (work, theta) = run("cogging", 0.05);
        near("work of cogging [J]", work, current * theta - 0.05 * wave(theta), 1e-7);
    }
}

/// A rotor that passes a tooth in the time between two stages of a step would feel the same torque at all of them, and run away at
/// `τ_c/J`. Its energy `J ω²/2 + τ_c/n cos nθ` belongs to the state alone.
#[test]
fn analytic_a_ripple_faster_than_the_steps_is_not_a_constant_torque() {
    let (omega, amplitude) = (8.0, 0.05);
    let n = (2.0 * PI / (0.25e-3 * omega)).round();
    let parameters = [("amplitude", amplitude), ("order", n), ("phase", 0.5 * PI)];
    let mut plant = ideal(&with(rotor_alone(None), "cogging", &parameters));
    plant.launch(&[turning(omega)]);
    plant.advance(&[0.0], 0.3).unwrap();
    // 2 τ_c/(n J ω) is what the energy allows; 1e-6 what Simpson's rule makes of a radian a step, amplitude/J · h/2880 a step.
    let allowed = 2.0 * amplitude / (n * J * omega) + 1e-6;
    near("velocity [rad/s]", plant.states()[0].motor_velocity, omega, allowed);
}

/// A rotor that coasts: `ω = ω₀ exp(−F_V/J (t + a T (1 − e^{−t/T})))`.
#[test]
fn analytic_a_cold_gear_brakes_more() {
    let (viscous, a, warming, omega) = (0.01, 3.0, 0.8, 4.0);
    let model = rotor_alone(Some(friction(0.0, 0.0, 1.0, viscous, 0.0)));
    let mut plant = ideal(&with(model, "thermal_friction_drift", &[("excess", a), ("time_constant", warming)]));
    plant.launch(&[turning(omega)]);
    for t in [0.5_f64, 1.0, 3.0] {
        plant.advance(&[0.0], t - plant.time()).unwrap();
        let expected = omega * (-viscous / J * (t + a * warming * (1.0 - (-t / warming).exp()))).exp();
        near("coasting [rad/s]", plant.states()[0].motor_velocity, expected, 1e-9);
    }
}

/// `J ω̇ = a sin(2πft + φ)`: `ω = a/(2πf J) (cos φ − cos(2πft + φ))`.
#[test]
fn analytic_a_hum_shakes_a_free_rotor() {
    let (a, f, phi) = (0.2, 31.0, 0.4);
    let parameters = [("amplitude", a), ("frequency", f), ("phase", phi)];
    let mut plant = ideal(&with(rotor_alone(None), "periodic_disturbance", &parameters));
    // The friction that effects might bring is zero: nothing holds the rotor.
    let expected = |t: f64| a / (2.0 * PI * f * J) * (f64::cos(phi) - (2.0 * PI * f * t + phi).cos());
    for k in 1..=300 {
        let t = f64::from(k) * 1e-3;
        plant.advance(&[0.0], 1e-3).unwrap();
        // Simpson's rule over half a millisecond: (ωh)⁴/2880 of the amplitude.
        near("hum [rad/s]", plant.states()[0].motor_velocity, expected(t), 1e-6);
    }
}

/// A rotor at constant speed shakes its link through its teeth: `I q̈ = k p + d ṗ`, `p = ωt + e sin Ωt − q`, `Ω = zω`. With
/// `H = (k + idΩ)/(k + idΩ − IΩ²)` the link runs at `q = ωt + e Im(H e^{iΩt})`.
#[test]
fn analytic_teeth_shake_the_link_with_the_square_of_speed() {
    let (e, z, k, d) = (1e-4, 40.0, 3000.0, 2.0);
    let amplitude_at = |omega: f64| {
        let rotor = JointModel { rotor_inertia: Some(FLYWHEEL), ..plain_joint("joint1") };
        let nominal = model(turntable(I), vec![rotor]);
        let mut plant = ideal(&with(nominal, "transmission_error", &[("amplitude", e), ("teeth", z)]));
        let big = z * omega;
        let (above, below) = ((k, d * big), (k - I * big * big, d * big));
        let norm = below.0 * below.0 + below.1 * below.1;
        let h = ((above.0 * below.0 + above.1 * below.1) / norm, (above.1 * below.0 - above.0 * below.1) / norm);
        let link = |t: f64| {
            let (sin, cos) = (big * t).sin_cos();
            (omega * t + e * (h.0 * sin + h.1 * cos), omega + e * big * (h.0 * cos - h.1 * sin))
        };
        let (link_position, link_velocity) = link(0.0);
        let start = JointState { motor_velocity: omega, link_position, link_velocity, ..JointState::default() };
        plant.launch(&[start]);
        let mut most = 0.0_f64;
        for step in 1..=1000 {
            plant.advance(&[0.0], 1e-3).unwrap();
            let (q, v) = link(1e-3 * f64::from(step));
            let state = plant.states()[0];
            assert!((state.link_position - q).abs() < 1e-9, "q {} {q}", state.link_position);
            assert!((state.link_velocity - v).abs() < 1e-7, "v {} {v}", state.link_velocity);
            most = most.max(state.gear_torque.abs());
        }
        // 1 %: the largest of a thousand samples of a sine.
        near("torque at tooth order [N·m]", most, I * e * big * big * h.0.hypot(h.1), 0.01 * most);
        most
    };
    // Well below the resonance at 245 rad/s |H| is 1.007 and 1.03: four times the torque at twice the speed, within that.
    let ratio = amplitude_at(1.0) / amplitude_at(0.5);
    assert!((3.8..4.3).contains(&ratio), "{ratio}");
}

/// A link that bounces between the flanks of a rotor in a vice: `2π/ω + 2 b(θ)/v` a period, `ω² = k/I`, with the gap of that place.
#[test]
fn analytic_the_gap_is_that_of_the_place() {
    let (gap, a, n, phi, v, k) = (0.02, 0.012, 3.0, 0.3, 0.8, 500.0);
    let joint =
        JointModel { backlash: Some(gap), gear_stiffness: Some(k), gear_damping: Some(0.0), ..plain_joint("joint1") };
    let parameters = [("amplitude", a), ("order", n), ("phase", phi)];
    let mut plant = ideal(&with(rotor_in_a_vice(joint), "position_dependent_backlash", &parameters));
    for theta in [0.0_f64, 0.4, 1.1, -2.0] {
        let b = gap + a * (n * theta + phi).cos();
        let period = 2.0 * PI / (k / I).sqrt() + 2.0 * b / v;
        let start =
            JointState { motor_position: theta, link_position: theta, link_velocity: v, ..JointState::default() };
        plant.launch(&[start]);
        plant.advance(&[0.0], 5.0 * period).unwrap();
        near("after five periods [rad]", plant.states()[0].link_position, theta, EXACT);
        plant.advance(&[0.0], 0.25 * (period - 2.0 * b / v) + 0.5 * b / v).unwrap();
        near("turning point [rad]", plant.states()[0].link_position, theta + 0.5 * b + v / (k / I).sqrt(), EXACT);
    }
}

#[test]
fn analytic_a_slip_shifts_the_link_for_good() {
    let (jump, start) = (0.03, 0.2);
    let parameters = [("jump", jump), ("time", start)];
    let mut plant = ideal(&with(rotor_in_a_vice(plain_joint("joint1")), "coupling_slip", &parameters));
    plant.advance(&[0.0], start).unwrap();
    near("before [rad]", plant.states()[0].link_position, 0.0, 0.0);
    // The link swings out at δ = d/2I = 20/s: e⁻⁴⁰ after 2 s.
    plant.advance(&[0.0], 2.0).unwrap();
    near("after [rad]", plant.states()[0].link_position, jump, 1e-12);
    near("the rotor [rad]", plant.states()[0].motor_position, 0.0, 0.0);
}

#[test]
fn analytic_no_current_below_the_dead_band() {
    let mut plant = ideal(&with(rotor_alone(None), "drive_dead_band", &[("width", 0.5)]));
    plant.advance(&[0.49], 0.1).unwrap();
    assert_eq!((plant.states()[0].current, plant.states()[0].motor_velocity), (0.0, 0.0));
    plant.advance(&[-0.6], 0.1).unwrap();
    near("beyond it [rad/s]", plant.states()[0].motor_velocity, -0.6 * 0.1 / J, 1e-12);
}

/// `ω (1 + e r cos(r θ + φ))`: a ripple in proportion to speed, and the machine itself moves as ever.
#[test]
fn analytic_a_disc_that_runs_out_reads_a_ripple() {
    let (e, ratio, phi, omega) = (0.004, 8.0, 0.6, 1.5);
    let joint = JointModel { gear_ratio: ratio, rotor_inertia: Some(J / ratio / ratio), ..plain_joint("joint1") };
    let nominal = model(turntable(I), vec![joint]);
    let model = with(nominal.clone(), "encoder_eccentricity", &[("amplitude", e), ("phase", phi)]);
    let (mut plant, mut plain) = (ideal(&model), ideal(&nominal));
    let mut counting = model;
    counting.joints[0].encoder = scara().joints[0].encoder;
    let step = counting.joints[0].encoder_step();
    let mut counting = Plant::new(&counting, &Options::default()).unwrap();
    for plant in [&mut plant, &mut plain, &mut counting] {
        plant.launch(&[turning(omega)]);
    }
    for _ in 0..500 {
        for plant in [&mut plant, &mut plain, &mut counting] {
            plant.advance(&[0.1], 1e-3).unwrap();
        }
        let state = plain.states()[0];
        assert_eq!(plant.states()[0], state, "open loop: nothing acts on the machine");
        let angle = ratio * state.motor_position + phi;
        let reading = plant.read()[0];
        assert!((reading.position - state.motor_position - e * angle.sin()).abs() < 1e-15);
        assert!((reading.velocity - state.motor_velocity * (1.0 + e * ratio * angle.cos())).abs() < 1e-13);
        // Half a count, and rounding.
        assert!((counting.read()[0].position - reading.position).abs() < 0.5001 * step);
    }
}

/// A motor that presses its link against a contact: `q = q_c + τ/k_c`, `θ = q + τ/k`, on either side.
#[test]
fn analytic_a_link_rests_on_what_it_ran_into() {
    let (torque, place, k) = (0.5, 0.1, 80.0);
    for side in [1.0, -1.0] {
        let parameters = [("angle", side * place), ("stiffness", k), ("damping", 1.0), ("side", side)];
        let mut plant = ideal(&with(two_inertias(), "external_contact", &parameters));
        plant.advance(&[side * torque], 0.1).unwrap();
        assert!(plant.touches().next().is_none() || plant.states()[0].link_position * side > place);
        plant.advance(&[side * torque], 5.0).unwrap();
        let state = plant.states()[0];
        // Swinging dies with c/2(I + J) = 7/s: e⁻³⁵ after five seconds.
        near("link [rad]", state.link_position, side * (place + torque / k), 1e-9);
        near("rotor [rad]", state.motor_position, side * (place + torque / k + torque / 3000.0), 1e-9);
        near("force [N·m]", plant.touches().next().unwrap().force, torque, 1e-7);
    }
}

#[test]
fn analytic_a_late_link_encoder_reads_where_the_link_was() {
    const DELAY: f64 = 0.003;
    const RESOLUTION: f64 = 1e-6;
    let joint = JointModel { link_encoder: Some(LinkEncoder { resolution: RESOLUTION }), ..plain_joint("joint1") };
    let machine = with(model(turntable(I), vec![joint]), "sensor_delay", &[("link_delay", DELAY)]);
    let mut plant = Plant::new(&machine, &Options::default()).unwrap();
    let (mut places, mut seen) = (Vec::new(), Vec::new());
    for _ in 0..500 {
        seen.push(plant.read()[0].link_position.expect("there is a second encoder"));
        places.push(plant.states()[0].link_position);
        plant.advance(&[1.0], 1e-3).unwrap();
    }
    for k in 10..500 {
        // Half a count, and the delay is three samples.
        assert!((seen[k] - places[k - 3]).abs() <= 0.5 * RESOLUTION + 1e-12, "{k}: {} {}", seen[k], places[k - 3]);
    }
    assert!(places[499] - places[496] > 100.0 * RESOLUTION, "it moved");
}
