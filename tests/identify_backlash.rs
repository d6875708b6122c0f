//! The gap from motor-side signals: the paper's procedure and the likelihood of the counts.

use std::path::PathBuf;

use lostmotion::dataset;
use lostmotion::identify::{self, Options};
use lostmotion::robot::Model;

#[test]
fn recover_gap_of_foreign_recordings() {
    let Ok(root) = std::env::var("LOSTMOTION_DATA") else { return };
    for name in ["none"] {
        let folder = PathBuf::from(&root).join("practice").join(name);
        let model = Model::load(&folder.join("model.toml")).unwrap();
        let series = dataset::load_alone(&folder.join("staircase.csv")).unwrap().series;
        for joint in 0..2 {
            let start = std::time::Instant::now();
            let found =
                identify::identify_joint(&model, joint, std::slice::from_ref(&series), &Options::default()).unwrap();
            println!("{:?}", found.notes);
            let backlash = found.backlash.unwrap();
            for e in [&backlash.paper_literal, &backlash.paper, &backlash.best] {
                println!(
                    "{} {:.4}±{:.4} deg, mean deviation {:.1} %, {} values, {} left out",
                    e.name,
                    e.mean.value.to_degrees(),
                    e.mean.std_error.to_degrees(),
                    e.mean_deviation_percent,
                    e.values.len(),
                    e.left_out.len()
                );
            }
            for v in &backlash.best.values {
                println!(
                    "{:.2} v {:.1} {:.4}±{:.4}",
                    v.time,
                    v.velocity.to_degrees(),
                    v.gap.to_degrees(),
                    v.std_error.to_degrees()
                );
            }
            println!("share {:?} in {:.2} s", backlash.link_share, start.elapsed().as_secs_f64());
        }
    }
}
