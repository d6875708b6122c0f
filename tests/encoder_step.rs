//! The step of an encoder, found from recorded positions.

use lostmotion::dataset::encoder_step;

/// A motion with slow and fast parts, both directions.
fn motion(sample: usize) -> f64 {
    let t = 1e-3 * sample as f64;
    0.8 * (1.3 * t).sin() + 0.2 * (3.7 * t).cos()
}

/// Positions of 20 s, as an encoder, file or sensor gives them.
fn recorded(reading: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    (0..20_000).map(|sample| reading(sample, motion(sample))).collect()
}

#[test]
fn recover_the_step_of_an_encoder() {
    for step in [1e-5, 1.534e-4, 3e-3] {
        let quantised = recorded(|_, q| (q / step).floor() * step);
        let found = encoder_step(&[&quantised]).expect("a step");
        assert!((found / step - 1.0).abs() < 1e-6, "{found} for {step}");
    }
}

/// Decimals of a tenth of a step, and one sample in a thousand that is none.
#[test]
fn recover_the_step_in_decimals_with_outliers() {
    let step = 1.534e-4;
    let written = recorded(|sample, q| match sample % 1000 {
        0 => q + 0.3 * step,
        _ => ((q / step).floor() * step * 1e5).round() / 1e5,
    });
    let found = encoder_step(&[&written]).expect("a step");
    // The mean of thousands of differences, each rounded by at most 7 %.
    assert!((found / step - 1.0).abs() < 0.01, "{found}");
}

#[test]
fn property_no_step_in_exact_noisy_or_single_precision_positions() {
    assert_eq!(encoder_step(&[&recorded(|_, q| q)]), None);
    let noise = |sample: usize| 1e-4 * (sample as f64 * 12.9898).sin() * (sample as f64 * 78.233).cos();
    assert_eq!(encoder_step(&[&recorded(|sample, q| q + noise(sample))]), None);
    assert_eq!(encoder_step(&[&recorded(|_, q| f64::from(q as f32))]), None);
    assert_eq!(encoder_step(&[&recorded(|_, _| 0.3)]), None);
}

/// A triangle between 0 and 1 at one speed, recorded exactly.
#[test]
fn property_no_step_in_exact_positions_of_constant_speed() {
    let triangle: Vec<f64> = (0..20_000).map(|sample| 1e-3 * (f64::from(sample % 2000) - 1000.0).abs()).collect();
    assert_eq!(encoder_step(&[&triangle]), None);
}
