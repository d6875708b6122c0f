//! The plant allocates nothing while it runs; what rapier's own step allocates is counted beside it.

#[path = "support/machines.rs"]
mod machines;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use lostmotion::plant::{Engine, Options, Plant, RigidBody, World};
use machines::*;
use nalgebra::DMatrix;

struct Counting;

thread_local! {
    /// Of this thread alone: the harness allocates in its own when it pleases.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    ALLOCATIONS.with(|count| count.set(count.get() + 1));
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTER: Counting = Counting;

fn allocations_of(mut work: impl FnMut()) -> usize {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

#[test]
fn property_a_step_allocates_nothing_of_its_own() {
    let run = |engine| {
        let mut plant = Plant::new(&scara(), &Options { engine, ..Options::default() }).unwrap();
        let mut millisecond = move |k: i32| {
            plant.read();
            plant.advance(&[6.0 * (f64::from(k) * 3e-3).sin(), 4.0 * (f64::from(k) * 5e-3).cos()], 1e-3).unwrap();
        };
        (0..200).for_each(&mut millisecond);
        allocations_of(|| (200..1200).for_each(&mut millisecond))
    };
    assert_eq!(run(Engine::Reduced), 0);

    let mut world = World::new(&planar_arm());
    let (mut mass, mut h) = (DMatrix::zeros(2, 2), vec![0.0; 2]);
    let mut evaluate = |k: i32| world.evaluate(&[f64::from(k) * 1e-3, 0.3], &[1.0, -1.0], &mut mass, &mut h);
    (0..200).for_each(&mut evaluate);
    let of_rapier = allocations_of(|| (200..1200).for_each(&mut evaluate)) / 1000;
    println!("allocations in an evaluation by rapier: {of_rapier}");
    assert_eq!(run(Engine::Rapier), 50 * of_rapier, "one evaluation in 20 milliseconds, and nothing besides");
}
