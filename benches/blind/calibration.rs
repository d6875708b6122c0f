//! The probabilities told against how often they were right.

use std::fmt::Write as _;

use super::case::Case;
use super::share::Share;

/// The effects named, in ten bins of the probability told.
pub fn calibration<'a>(cases: impl Iterator<Item = &'a Case>) -> String {
    let mut bins = [(0.0, Share::default()); 10];
    for case in cases {
        let mut named = Vec::new();
        for found in &case.verdict.found {
            if named.contains(&&found.effect) {
                continue;
            }
            named.push(&found.effect);
            let (sum, share) = &mut bins[((10.0 * found.probability) as usize).min(9)];
            *sum += found.probability;
            share.all += 1;
            share.good += usize::from(case.order.effects.contains(&found.effect));
        }
    }
    let mut text = String::from("| probability said | mean | right |\n|---|---|---|\n");
    for (bin, (sum, share)) in bins.into_iter().enumerate().filter(|(_, (_, share))| share.all > 0) {
        let (low, high) = (bin as f64 / 10.0, (bin + 1) as f64 / 10.0);
        let _ = writeln!(text, "| {low:.1} to {high:.1} | {:.3} | {} |", sum / share.all as f64, share.text());
    }
    text
}
