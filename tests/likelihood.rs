//! The filter's score: an exact model reaches the floor of its sensors, and a planted effect shows in samples that no regression uses.

#[path = "support/drawn/arm.rs"]
mod arm;
#[path = "support/drawn/drawn.rs"]
mod drawn;
#[path = "support/drawn/hidden.rs"]
mod hidden;
#[path = "support/drawn/machine.rs"]
mod machine;
#[path = "support/drawn/motion.rs"]
mod motion;
#[path = "support/drawn/record.rs"]
mod record;
#[path = "support/rough.rs"]
mod rough;
#[path = "support/drawn/sampling.rs"]
mod sampling;
#[path = "support/six_joints.rs"]
mod six_joints;
#[path = "support/drawn/strengths.rs"]
mod strengths;

use drawn::Drawn;
use hidden::Order;
use lostmotion::likelihood::{Recording, Settings, score};

#[test]
fn property_an_exact_model_reaches_the_floor() {
    let drawn = Drawn::new(&Order::nothing(700_001));
    let truth = drawn.truth();
    let series: Vec<_> = drawn.sessions().take(2).collect();
    for one in &series {
        let recording = Recording::new(&truth, one).expect("a recording");
        for lambda in [-1.0, 0.0, 0.5, 1.0, 2.0] {
            let start = std::time::Instant::now();
            let scores = score(&truth, &[recording.clone()], &[lambda; 2], &Settings::default()).expect("a score");
            let score = &scores[0];
            println!(
                "{} λ {lambda}: {:.4} nats a sample, {:?}, {:.2} µs a sample",
                score.name,
                score.mean(),
                score.nats,
                1e6 * start.elapsed().as_secs_f64() / recording.len() as f64
            );
            if std::env::var("DUMP").is_ok() {
                let mut text = String::new();
                for k in 0..recording.len() {
                    text += &format!("{}", score.time[k]);
                    for (j, joint) in score.joints.iter().enumerate() {
                        let c = &one.joints[j].channels;
                        use lostmotion::timeseries::Channel::*;
                        text += &format!(" {} {} {} {} {} {}", joint.nats[k], joint.below[k], joint.inside[k], c[&Position][k], c[&Velocity][k], c[&Current][k]);
                    }
                    text += "\n";
                }
                std::fs::write(format!("/tmp/judge_{}_{lambda}.txt", score.name), text).unwrap();
            }
            for joint in &score.joints {
                let mut tens = [0.0; 10];
                let mut seed = 1u64;
                for (k, (below, inside)) in joint.below.iter().zip(&joint.inside).enumerate().skip(600) {
                    if *inside < 0.95 || k % 1 == 1 {
                        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                        let u = (seed >> 11) as f64 / (1u64 << 53) as f64;
                        let pit = below + u * inside;
                        tens[((10.0 * pit) as usize).min(9)] += 1.0;
                    }
                }
                let worst: Vec<f64> = { let mut n = joint.nats.clone(); n.sort_by(f64::total_cmp); n[..5].to_vec() };
                println!("   {tens:?} {worst:.1?}");
            }
        }
    }
}
