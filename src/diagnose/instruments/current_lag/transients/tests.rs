use super::*;

/// [s]
const STEP: f64 = 0.001;
/// `c` of the made transients.
const C: f64 = 3.0;

/// Transients of which the torque is late by `lag` [s], with noise of the acceleration as strong as it; three lines, so that no other lag is as good.
fn late_by(lag: f64, from: f64) -> Transients {
    let time: Vec<f64> = (0..4000).map(|k| from + STEP * f64::from(k)).collect();
    let smooth = |t: f64| [61.0, 97.3, 143.7].iter().map(|omega| (omega * t).sin()).sum::<f64>();
    let mut noise = crate::drive::Noise::new(7, 0);
    let acceleration = time.iter().map(|t| C * (smooth(*t) + 1.2 * noise.gaussian())).collect();
    Transients { acceleration, torque: time.iter().map(|t| smooth(t - lag)).collect(), step: STEP, time }
}

#[test]
fn recover_the_lag_of_transients_in_noise() {
    for lag in [0.0, 0.0034, 0.0101] {
        let found = late_by(lag, 0.0).lag().expect("a lag");
        // Standard error `1/(ω √(N S))` of 4000 samples, `ω` = 106 rad/s and a signal as strong as the noise: 0.15 ms; four of them.
        assert!((found - lag).abs() < 6e-4, "{found} for {lag}");
    }
}

/// Undoing a lag gains, and undoing one that is not there loses.
#[test]
fn property_only_the_lag_that_is_there_gains() {
    let late = 0.0101;
    let gain = |there: f64, undone: f64| {
        let (training, held_out) = (late_by(there, 0.0), late_by(there, 10.0));
        crate::diagnose::residuals::gains::gain(&compared(&[training], &[held_out], undone))
    };
    let right = gain(late, late);
    // The three lines correlate by `r = mean cos ω L = 0.50` where the lag is ignored: `1 − √(1/(1 + S (1 − r²)))` = 25 % with `S` = 1.04.
    assert!(right.shown && (right.gain_percent - 25.0).abs() < 3.0, "{right:?}");
    let wrong = gain(0.0, late);
    assert!(!wrong.shown && wrong.gain_percent < 0.0, "{wrong:?}");
}
