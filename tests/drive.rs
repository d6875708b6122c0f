//! Motor, power stage, encoder, velocity and current sensor.

#[path = "support/machines.rs"]
mod machines;

use lostmotion::drive::{
    Amplifier, Counter, CurrentSensor, Encoder, Motor, Noise, PowerStage, Sensing, Stretch, VelocityMeter,
    VelocitySensor,
};
use lostmotion::effects::JointState;
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::JointModel;
use machines::*;

const MOTOR: Motor = Motor { torque_constant: 0.05, resistance: Some(0.5), inductance: Some(0.0005) };

fn amplifier(voltage_limit: f64) -> Amplifier {
    Amplifier { voltage_limit, current_limit: 18.0, current_time_constant: 4e-4 }
}

/// A joint whose rotor is too heavy to move: the winding alone.
fn blocked(voltage_limit: f64) -> Plant {
    let joint = JointModel {
        rotor_inertia: Some(1e9),
        motor: Some(MOTOR),
        amplifier: amplifier(voltage_limit),
        ..plain_joint("joint1")
    };
    Plant::new(&model(turntable(0.05), vec![joint]), &Options { ideal_sensors: true, ..Options::default() }).unwrap()
}

#[test]
fn analytic_current_loop_approaches_its_command() {
    let mut plant = blocked(f64::INFINITY);
    for step in 1..=5 {
        plant.advance(&[3.0], 3e-4).unwrap();
        let expected = 3.0 * (1.0 - (-f64::from(step) * 3e-4 / 4e-4).exp());
        // The course is put in as it is: rounding.
        assert!((plant.states()[0].current - expected).abs() < 1e-12);
    }
    plant.advance(&[100.0], 0.1).unwrap();
    assert!((plant.states()[0].current - 18.0).abs() < 1e-12, "the command is clamped");
}

#[test]
fn analytic_current_rises_at_the_voltage_limit_and_leaves_it() {
    // 4 V, 6 A wanted: i = V/R (1 − e^{−tR/L}) while u* = R i + L (i_cmd − i)/T_i > V, then the loop's own exponential.
    let (r, l, volts, wanted, ti) = (0.5, 0.0005, 4.0, 6.0, 4e-4);
    let mut plant = blocked(volts);
    let leaves_at = (l * wanted / ti - volts) / (l / ti - r);
    let leaves = -(1.0_f64 - leaves_at * r / volts).ln() * l / r;
    for step in 1..=40 {
        plant.advance(&[wanted], 1e-4).unwrap();
        let t = f64::from(step) * 1e-4;
        let expected = if t < leaves {
            volts / r * (1.0 - (-t * r / l).exp())
        } else {
            wanted + (leaves_at - wanted) * (-(t - leaves) / ti).exp()
        };
        // Runge-Kutta 4 at hR/L = 0.1: 8 A (hR/L)⁵/120 = 7e-7 A a step, for the few steps at the limit.
        assert!((plant.states()[0].current - expected).abs() < 5e-6, "{t} {} {expected}", plant.states()[0].current);
    }
}

#[test]
fn analytic_motor_without_load_runs_up_to_its_voltage() {
    // No inductance, a command beyond reach: J ω̇ = K (V − K ω)/R.
    let joint = JointModel {
        motor: Some(Motor { inductance: None, ..MOTOR }),
        amplifier: Amplifier { current_limit: 1e3, ..amplifier(12.0) },
        gear_ratio: 5.0,
        rotor_inertia: Some(0.001),
        backlash: Some(1e9),
        ..plain_joint("joint1")
    };
    let (k, j) = (0.25, 0.025);
    let options = Options { ideal_sensors: true, ..Options::default() };
    let mut plant = Plant::new(&model(turntable(0.05), vec![joint]), &options).unwrap();
    let time_constant = j * 0.5 / (k * k);
    for step in 1..=20 {
        plant.advance(&[500.0], 0.02).unwrap();
        let expected = 12.0 / k * (1.0 - (-f64::from(step) * 0.02 / time_constant).exp());
        // Runge-Kutta 4 at h/T = 1.7e-3.
        assert!((plant.states()[0].motor_velocity - expected).abs() < 1e-9 * expected);
    }
}

#[test]
fn property_without_resistance_the_current_obeys_at_once() {
    let stage = PowerStage::new(Some(&Motor { resistance: None, ..MOTOR }), &amplifier(1.0), 0.25);
    let demand = stage.demand(7.0, 0.0, 100.0);
    assert_eq!(stage.current(7.0, 0.0, 100.0, stage.saturation(demand)), 7.0);
}

#[test]
fn property_encoder_is_unbiased_and_off_by_half_a_count_at_most() {
    let mut noise = Noise::new(11, 0);
    let mut mean = 0.0;
    let rounds = 20_000;
    for _ in 0..rounds {
        let counter = Counter::new(&Encoder { counts_per_turn: 2000.0 }, 5.375, noise.uniform());
        let angle = 4.0 * (noise.uniform() - 0.5);
        let count = counter.count(angle);
        let error = counter.position(count) - angle;
        assert!(error.abs() <= 0.5 * counter.step * (1.0 + 1e-9));
        assert!(counter.edge(count) <= angle + 1e-12 && angle < counter.edge(count + 1.0) + 1e-12);
        mean += error / counter.step / f64::from(rounds);
    }
    // Uniform error of standard deviation 0.29 counts: 4 σ of the mean of 20 000.
    assert!(mean.abs() < 4.0 * 0.29 / f64::from(rounds).sqrt(), "{mean}");
}

/// Reads a pulse-period meter along a motion, at 1 kHz.
fn measured(motion: impl Fn(f64) -> (f64, f64), seconds: f64) -> Vec<(f64, f64)> {
    let counter = Counter::new(&Encoder { counts_per_turn: 500.0 }, 5.375, 0.3);
    let mut meter = VelocityMeter::new(VelocitySensor::PulsePeriod);
    let mut count = counter.count(motion(0.0).0);
    let mut readings = Vec::new();
    for k in 0..(seconds * 1e3) as usize {
        let time = [k as f64 * 1e-3, (k + 1) as f64 * 1e-3];
        let [(p0, v0), (p1, v1)] = time.map(&motion);
        let now = counter.count(p1);
        meter.watch(&counter, &Stretch { time, position: [p0, p1], velocity: [v0, v1] }, count, now);
        count = now;
        readings.push((time[1], meter.read(&counter, time[1], counter.position(count))));
    }
    readings
}

#[test]
fn analytic_pulse_period_is_exact_at_constant_speed() {
    // 0.5 deg/s of joint 1 are 3.7 pulses a second: nothing before the second pulse, the true speed after it.
    for speed in [0.5_f64.to_radians(), -10.0_f64.to_radians(), 2.0] {
        let readings = measured(|t| (speed * t, speed), 2.0);
        let counter = Counter::new(&Encoder { counts_per_turn: 500.0 }, 5.375, 0.3);
        let defined = 2.0 * counter.step / speed.abs();
        for &(t, v) in &readings {
            if t > defined + 1e-3 {
                // Edges are located to 1e-13 of a millisecond.
                assert!((v / speed - 1.0).abs() < 1e-9, "{t} {v} {speed}");
            } else {
                assert!(v == 0.0 || (v / speed - 1.0).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn property_pulse_period_is_bounded_by_the_time_since_the_last_edge() {
    // Stops at t = 0.5 s: what is read then falls as one count over the time since the last edge.
    let counter = Counter::new(&Encoder { counts_per_turn: 500.0 }, 5.375, 0.3);
    let speed = 0.2;
    let readings = measured(|t| if t < 0.5 { (speed * t, speed) } else { (0.5 * speed, 0.0) }, 2.0);
    for &(t, v) in readings.iter().filter(|(t, _)| *t > 0.5 + counter.step / speed) {
        assert!(v >= 0.0 && v <= counter.step / (t - 0.5) * (1.0 + 1e-9), "{t} {v}");
    }
    assert!(readings.last().is_some_and(|&(_, v)| v > 0.0));
}

#[test]
fn property_pulse_period_is_zero_after_a_reversal_until_two_edges() {
    let counter = Counter::new(&Encoder { counts_per_turn: 500.0 }, 5.375, 0.3);
    let speed = 0.2;
    let motion = |t: f64| if t < 0.5 { (speed * t, speed) } else { (speed * (1.0 - t), -speed) };
    let readings = measured(motion, 1.0);
    let one_count = counter.step / speed;
    assert!(readings.iter().all(|&(t, v)| t > 0.5 || v >= 0.0));
    // After the first edge of the new direction, at most a count later, zero; after two counts the new speed.
    assert!(readings.iter().any(|&(t, v)| t > 0.5 && t < 0.5 + 2.0 * one_count && v == 0.0));
    for &(t, v) in readings.iter().filter(|(t, _)| *t > 0.5 + 3.0 * one_count) {
        assert!((v + speed).abs() < 1e-9, "{t} {v}");
    }
}

#[test]
fn analytic_low_pass_of_a_ramp_lags_and_then_reads_its_speed() {
    let counter = Counter::new(&Encoder { counts_per_turn: 1e9 }, 1.0, 0.0);
    let mut meter = VelocityMeter::new(VelocitySensor::LowPass(0.02));
    for k in 0..=100 {
        let t = f64::from(k) * 1e-3;
        let v = meter.read(&counter, t, 3.0 * t);
        // Rounding of differences of 1e-3 s.
        assert!((v - 3.0 * (1.0 - (-t / 0.02).exp())).abs() < 1e-9);
    }
}

#[test]
fn property_current_noise_has_its_deviation_and_the_converter_its_step() {
    let sensor = CurrentSensor { noise: 0.03, resolution: 0.0098, sensing: Sensing::Signed };
    let mut noise = Noise::new(5, 2);
    let n = 40_000;
    let readings: Vec<f64> = (0..n).map(|_| sensor.read(1.234, &mut noise)).collect();
    let mean = readings.iter().sum::<f64>() / f64::from(n);
    let variance = readings.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / f64::from(n);
    let expected = 0.03_f64.powi(2) + 0.0098_f64.powi(2) / 12.0;
    // 4 σ of the mean and of the variance of 40 000 draws.
    assert!((mean - 1.234).abs() < 4.0 * (expected / f64::from(n)).sqrt(), "{mean}");
    assert!((variance / expected - 1.0).abs() < 4.0 * (2.0 / f64::from(n)).sqrt(), "{variance} {expected}");
    assert!(readings.iter().all(|r| (r / 0.0098 - (r / 0.0098).round()).abs() < 1e-9));
}

#[test]
fn analytic_rectified_noise_has_a_mean_of_its_own() {
    let sensor = CurrentSensor { noise: 0.03, resolution: 0.0, sensing: Sensing::Absolute };
    let mut noise = Noise::new(5, 3);
    let n = 40_000;
    let mean_at = |current: f64, noise: &mut Noise| {
        (0..n).map(|_| sensor.read(current, noise)).inspect(|r| assert!(*r >= 0.0)).sum::<f64>() / f64::from(n)
    };
    let at_zero = mean_at(0.0, &mut noise);
    let expected = 0.03 * (2.0 / std::f64::consts::PI).sqrt();
    // Standard deviation of |n| is 0.6 σ: 4 of the mean's.
    assert!((at_zero - expected).abs() < 4.0 * 0.6 * 0.03 / f64::from(n).sqrt(), "{at_zero}");
    let far = mean_at(-2.0, &mut noise);
    assert!((far - 2.0).abs() < 4.0 * 0.03 / f64::from(n).sqrt(), "{far}");
}

#[test]
fn property_plant_reads_what_its_sensors_see() {
    let mut model = scara();
    for joint in &mut model.joints {
        joint.velocity_sensor = Some(VelocitySensor::PulsePeriod);
    }
    let mut plant = Plant::new(&model, &Options::default()).unwrap();
    for k in 0..2000 {
        let t = f64::from(k) * 1e-3;
        plant.advance(&[5.0, 3.0 * (4.0 * t).sin()], 1e-3).unwrap();
        let states: Vec<JointState> = plant.states().to_vec();
        for (joint, (reading, state)) in model.joints.iter().zip(plant.read().iter().zip(&states)) {
            assert!((reading.position - state.motor_position).abs() <= 0.5001 * joint.encoder_step());
            assert!((reading.current - state.current).abs() < 6.0 * 0.03 + 0.0098);
            // A count in a millisecond is the coarsest that a reading can be off while the speed changes.
            assert!((reading.velocity - state.motor_velocity).abs() < 1.0, "{t}");
        }
    }
    let last = plant.states()[0].motor_velocity;
    let reading = plant.read()[0].velocity;
    assert!((reading / last - 1.0).abs() < 0.02, "{reading} {last}");
}
