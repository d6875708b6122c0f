//! What is changed, one property at a time.

/// Joints that the staircase moves.
pub const JOINTS: [&str; 2] = ["joint1", "joint2"];

/// A row of the table.
pub struct Setting {
    pub name: String,
    /// Values of the scenario and its model, `key=value`.
    pub set: Vec<String>,
    /// Factor on the way for which a step of the staircase settles.
    pub settling: f64,
}

/// The same value, or one for each joint, of a property of both joints.
fn of_joints(name: String, key: &str, values: [f64; 2]) -> Setting {
    let set = JOINTS.iter().zip(values).map(|(joint, value)| format!("model.joints.{joint}.{key}={value:?}"));
    Setting { name, set: set.collect(), settling: 1.0 }
}

/// All rows: the scenario as it is, then its neighbours.
pub fn all() -> Vec<Setting> {
    let mut all = vec![Setting { name: "as in the scenario".to_owned(), set: Vec::new(), settling: 1.0 }];
    let both = |value: f64| [value; 2];
    for counts in [100.0, 200.0, 500.0, 1000.0, 4000.0, 10_000.0] {
        all.push(of_joints(format!("{counts} counts a turn"), "encoder.counts_per_turn", both(counts)));
    }
    for noise in [0.003, 0.1, 0.3] {
        all.push(of_joints(format!("current noise {noise} A"), "current_sensor.noise", both(noise)));
    }
    for period in [0.0005, 0.002, 0.004] {
        let set = vec![format!("control_period={period:?}")];
        all.push(Setting { name: format!("{} ms a sample", 1000.0 * period), set, settling: 1.0 });
    }
    for factor in [0.1, 0.3, 3.0] {
        let stiffness = [3000.0, 2000.0].map(|k: f64| factor * k);
        all.push(of_joints(format!("gears {factor} times as stiff"), "gear_stiffness", stiffness));
    }
    for share in [0.0, 0.15, 0.6] {
        all.push(of_joints(format!("link friction {} %", 100.0 * share), "friction.link_share", both(share)));
    }
    let gap = |degrees: f64| of_joints(format!("gap {degrees}°"), "backlash", both(degrees.to_radians()));
    all.extend([0.05, 0.1, 0.2, 1.0, 2.0].map(gap));
    // A step has to settle for longer than the way through the gap.
    all.push(Setting { name: "gap 2°, settling for twice the way".to_owned(), settling: 2.0, ..gap(2.0) });
    all
}
