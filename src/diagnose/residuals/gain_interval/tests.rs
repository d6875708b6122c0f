//! Level and coverage of the interval of a gain.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Time [s], errors before and after of a session at 100 Hz. The error contains `part` of a term `d` that acts in every third block of 2 s, in
/// bursts of different size, plus noise with a correlation time of 0.2 s.
fn errors(seed: u64, seconds: usize, part: f64) -> [Vec<f64>; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Sum of twelve uniform draws: approximately normal, variance 1.
    let mut draw = || (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0;
    let (mut burst, mut noise) = (0.0, 0.0);
    let [mut time, mut before, mut after] = <[Vec<f64>; 3]>::default();
    for k in 0..100 * seconds {
        if k % 200 == 0 {
            burst = if (k / 200) % 3 == 0 { 0.5 + draw().abs() } else { 0.0 };
        }
        noise = 0.95 * noise + 0.31 * draw();
        let d = burst * (0.03 * k as f64).sin();
        time.push(k as f64 * 0.01);
        before.push(part * d + noise);
        after.push((part - 1.0) * d + noise);
    }
    [time, before, after]
}

fn gain_of([time, before, after]: &[Vec<f64>; 3]) -> Gain {
    gain(&[Pairs { time, before, after }])
}

#[test]
fn recover_a_term_that_is_right_and_none_that_gains_nothing() {
    let runs = 400;
    let shown =
        |part: f64, seconds: usize| (0..runs).filter(|seed| gain_of(&errors(*seed, seconds, part)).shown).count();
    // With half of the term in the error the expected gain is zero: the level of the test. 2.5 % of 400 are 10; more than 20 occur once in
    // a thousand such tests.
    let at_the_edge = shown(0.5, 40);
    assert!(at_the_edge <= 20, "{at_the_edge}");
    // β has a standard error of 0.15 in 40 s (noise of 1, 29 correlated samples, against Σ d² = 1360): 0.5 is 3.4 standard errors away, with
    // some five degrees of freedom. In 120 s the standard error is 0.085: six standard errors.
    assert_eq!(shown(0.0, 40), 0);
    let right = shown(1.0, 120);
    assert!(right >= 396, "{right}");
}

#[test]
fn recover_the_interval_holds_the_gain_of_this_motion() {
    let runs = 400;
    let covered = (0..runs).filter(|seed| {
        let [time, before, after] = errors(*seed, 40, 1.0);
        // Expected error of other noise of the same size on the same motion: E R = Σ r².
        let d: f64 = before.iter().zip(&after).map(|(b, a)| (b - a).powi(2)).sum();
        let noise: f64 = after.iter().map(|a| a * a).sum();
        let truth = 100.0 * (1.0 - (noise / (noise + d)).sqrt());
        let [low, high] = gain_of(&[time, before, after]).interval_percent;
        (low..=high).contains(&truth)
    });
    // 95 % of 400 are 380; fewer than 362 occur once in a few thousand such tests. A wider interval does no harm.
    let covered = covered.count();
    assert!(covered >= 362, "{covered}");
}

/// The term explains intervals of 0.5 s only, as where a link meets a stop: four of them show a gain, one alone does not.
#[test]
fn property_what_happens_once_decides_nothing() {
    let [time, _, noise] = errors(3, 60, 1.0);
    let with_stretches = |starts: &[usize]| {
        let inside = |k: usize| starts.iter().any(|start| (*start..start + 50).contains(&k));
        let before = noise.iter().enumerate().map(|(k, e)| if inside(k) { 30.0 + e } else { *e }).collect();
        gain_of(&[time.clone(), before, noise.clone()])
    };
    let once = with_stretches(&[1000]);
    assert!(!once.shown && once.gain_percent > 50.0, "{once:?}");
    let often = with_stretches(&[1000, 2000, 3500, 4500]);
    assert!(often.shown, "{often:?}");
}

#[test]
fn property_a_term_without_torque_gains_nothing() {
    let [time, before, _] = errors(5, 30, 0.0);
    let same = gain_of(&[time, before.clone(), before]);
    assert_eq!(same, Gain::default());
    assert_eq!(gain(&[]), Gain::default());
    let one = gain_of(&[vec![0.0], vec![1.0], vec![0.1]]);
    assert!(!one.shown && one.gain_percent > 80.0 && one.interval_percent[0] <= 0.0, "{one:?}");
}
