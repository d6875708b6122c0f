//! The engine has the last word on the links, whoever carries its answers on in between.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::machines::*;
use lostmotion::dynamics::Dynamics;
use lostmotion::plant::links::Links;
use lostmotion::plant::{RigidBody, World};
use lostmotion::robot::Robot;
use nalgebra::DMatrix;

/// An engine that counts how often it is asked.
struct Counted<T>(T, Arc<AtomicUsize>);

impl<T: RigidBody> RigidBody for Counted<T> {
    fn evaluate(&mut self, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]) {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.evaluate(q, v, mass, h);
    }
}

fn motion(t: f64) -> ([f64; 2], [f64; 2]) {
    ([(3.0 * t).sin(), 1.5 * (2.0 * t).cos()], [3.0 * (3.0 * t).cos(), -3.0 * (2.0 * t).sin()])
}

/// Largest difference [N·m, or kg·m²] from the engine along two seconds of motion, and how often the engine was asked.
fn followed(engine: impl RigidBody + 'static, own: &Robot, mut truth: impl RigidBody) -> (f64, usize) {
    let asked = Arc::new(AtomicUsize::new(0));
    let mut links = Links::carried(Box::new(Counted(engine, asked.clone())), Dynamics::new(own), 0.02);
    let (mut mass, mut h) = ([DMatrix::zeros(2, 2), DMatrix::zeros(2, 2)], [[0.0; 2]; 2]);
    let mut worst = 0.0_f64;
    let (q, v) = motion(0.0);
    links.start(0.0, &q, &v);
    for k in 1..=2000 {
        let t = f64::from(k) * 1e-3;
        let (q, v) = motion(t);
        links.evaluate(t, &q, &v, &mut mass[0], &mut h[0]);
        truth.evaluate(&q, &v, &mut mass[1], &mut h[1]);
        // The first line needs two answers.
        if k > 2 {
            worst = worst.max((&mass[0] - &mass[1]).amax());
            worst = worst.max((h[0][0] - h[1][0]).abs().max((h[0][1] - h[1][1]).abs()));
        }
        if links.is_due(t) {
            links.ask(t, &q, &v);
        }
    }
    (worst, asked.load(Ordering::Relaxed))
}

#[test]
fn property_an_engine_that_agrees_is_asked_every_twenty_milliseconds() {
    let arm = planar_arm();
    let (worst, asked) = followed(World::new(&arm), &arm, World::new(&arm));
    println!("differs by {worst:.1e}, asked {asked} times in 2 s");
    // 1e-9: what rapier's own answer is uncertain by, its oracle's step moving the arm by v dt.
    assert!(worst < 1e-9, "{worst:e}");
    assert!((100..120).contains(&asked), "{asked}");
}

#[test]
fn property_an_engine_that_differs_has_the_last_word() {
    let (arm, mut loaded) = (planar_arm(), planar_arm());
    loaded.bodies[1].inertia.mass *= 1.5;
    let engine = || Dynamics::new(&loaded);
    let (worst, asked) = followed(engine(), &arm, engine());
    let (mut mass, mut h) = ([DMatrix::zeros(2, 2), DMatrix::zeros(2, 2)], [0.0; 2]);
    engine().evaluate(&[0.3; 2], &[1.0; 2], &mut mass[0], &mut h);
    Dynamics::new(&arm).evaluate(&[0.3; 2], &[1.0; 2], &mut mass[1], &mut h);
    let apart = (&mass[0] - &mass[1]).amax();
    println!("differs by {worst:.1e}, asked {asked} times in 2 s; the machines are {apart:.2} apart");
    // A line through answers 1 ms apart: δ̈ dt² of differences below 1 that move at 3 rad/s, 1e-5 at most.
    assert!(apart > 0.1 && worst < 2e-5, "{apart} {worst:e}");
    assert_eq!(asked, 2001, "an engine that surprises is asked at every occasion");
}
