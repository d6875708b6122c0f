//! What a diagnosis found, on standard output: a test that fails shows it.

use lostmotion::diagnose::Diagnosis;

/// Prints effects, mistakes and what is unexplained.
pub fn print(found: &Diagnosis) {
    for one in &found.effects {
        println!(
            "{} {:?} p {:.2} {:?} {:?}",
            one.effect, one.joints, one.probability, one.confusable_with, one.parameters
        );
    }
    println!("mistakes {:?}, unexplained {:?}", found.mistakes, found.unexplained);
}
