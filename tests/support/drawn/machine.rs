//! A machine drawn by seed: a planar arm of two joints with gearheads, as files.
//!
//! Sizes scatter around those of a small laboratory SCARA: links within 15 %, friction and gaps within factors of 1.5 to 2.

use std::fmt::Write as _;

use lostmotion::robot::EffectEntry;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Names of the joints.
pub const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// Motor turns per joint turn.
pub const GEAR_RATIO: [f64; 2] = [5.375, 10.0 / 3.0];
/// Torque constant of both motors [N·m/A].
pub const TORQUE_CONSTANT: f64 = 0.023;

/// Friction of a joint, the same in both directions [N·m, N·m, rad/s, N·m·s/rad].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    pub coulomb: f64,
    pub breakaway: f64,
    pub stribeck_velocity: f64,
    pub viscous: f64,
}

/// A machine.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Scale of length and mass of the links.
    pub scale: [[f64; 2]; 2],
    /// [kg·m²] on the joint side.
    pub rotor_inertia: [f64; 2],
    /// [rad] whole gap.
    pub backlash: [f64; 2],
    pub friction: [Friction; 2],
    /// [1] friction on the link side.
    pub link_share: f64,
    /// Whether friction has a falling part, and the nominal model file leaves friction out. Else the nominal model file holds it,
    /// without a falling part, and with numbers that are off by [`guess`](Self::guess).
    pub friction_unknown: bool,
    /// [1] Coulomb and viscous friction of the nominal model file against the machine's: a diagnosis fits them anyway.
    pub guess: [[f64; 2]; 2],
}

/// A number within a factor of `spread` around `middle`.
pub fn around(rng: &mut ChaCha8Rng, middle: f64, spread: f64) -> f64 {
    middle * spread.powf(rng.random_range(-1.0..1.0))
}

impl Machine {
    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        let mut pair = |middle: [f64; 2], spread: f64| middle.map(|middle| around(rng, middle, spread));
        let scale = [pair([1.0, 1.0], 1.15), pair([1.0, 1.0], 1.15)];
        let rotor_inertia = pair([0.019, 0.019], 1.25);
        let backlash = pair([0.008, 0.0065], 1.5);
        let coulomb = pair([0.42, 0.2], 1.25);
        let rise = pair([1.18, 1.18], 1.08);
        let stribeck_velocity = pair([0.047, 0.042], 1.25);
        let viscous = pair([0.4, 0.18], 1.25);
        let friction = [0, 1].map(|i| Friction {
            coulomb: coulomb[i],
            breakaway: coulomb[i] * rise[i],
            stribeck_velocity: stribeck_velocity[i],
            viscous: viscous[i],
        });
        let link_share = rng.random_range(0.1..0.5);
        let guess = [0, 1].map(|_| [0, 1].map(|_| rng.random_range(0.7..1.3)));
        let mut machine = Self { scale, rotor_inertia, backlash, friction, link_share, friction_unknown: true, guess };
        if rng.random_bool(0.25) {
            machine.know_friction();
        }
        machine
    }

    /// A machine whose friction has no falling part, and whose nominal model file says so.
    pub fn know_friction(&mut self) {
        self.friction_unknown = false;
        for friction in &mut self.friction {
            friction.breakaway = friction.coulomb;
        }
    }

    /// The robot's description.
    pub fn urdf(&self) -> String {
        let [[l1, m1], [l2, m2]] = self.scale;
        let link = |name: &str, com: f64, mass: f64, inertia: f64| {
            format!(
                "  <link name=\"{name}\"><inertial><origin xyz=\"{com} 0 0\"/><mass value=\"{mass}\"/><inertia ixx=\"{}\" ixy=\"0\" \
                 ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/></inertial></link>\n",
                0.1 * inertia
            )
        };
        let joint = |name: &str, parent: &str, child: &str, x: f64, effort: f64| {
            format!(
                "  <joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{x} 0 0\"/>\
                 <axis xyz=\"0 0 1\"/><limit lower=\"-2.8\" upper=\"2.8\" effort=\"{effort}\" velocity=\"3\"/></joint>\n"
            )
        };
        let mut text = String::from("<?xml version=\"1.0\"?>\n<robot name=\"planar_arm\">\n  <link name=\"base\"/>\n");
        text += &link("link1", 0.15 * l1, 1.5 * m1, 0.012 * m1 * l1 * l1);
        text += &link("link2", 0.12 * l2, 1.0 * m2, 0.006 * m2 * l2 * l2);
        text += &link("tool", 0.0, 0.4, 0.00015);
        text += &joint("joint1", "base", "link1", 0.0, 3.0);
        text += &joint("joint2", "link1", "link2", 0.3 * l1, 2.0);
        let reach = self.reach();
        let _ = writeln!(
            text,
            "  <joint name=\"tool_mount\" type=\"fixed\"><parent link=\"link2\"/><child link=\"tool\"/><origin xyz=\"{reach} 0 0\"/></joint>"
        );
        text + "</robot>\n"
    }

    /// [m] from the second joint to the tool.
    pub fn reach(&self) -> f64 {
        0.25 * self.scale[1][0]
    }

    /// The model file that the program is given: no gap, no effect, friction as far as it is known.
    pub fn nominal(&self) -> String {
        self.model(|i| {
            let Friction { coulomb, viscous, stribeck_velocity, .. } = self.friction[i];
            let [dry, wet] = self.guess[i];
            let (coulomb, viscous) = (dry * coulomb, wet * viscous);
            let law = Friction { coulomb, breakaway: coulomb, stribeck_velocity, viscous };
            if self.friction_unknown { String::new() } else { self.friction_table(i, &law) }
        })
    }

    /// The model file of the machine that moves.
    pub fn truth(&self, effects: &[EffectEntry]) -> String {
        let joint =
            |i: usize| format!("backlash = {}\n{}", self.backlash[i], self.friction_table(i, &self.friction[i]));
        let mut text = self.model(joint);
        for EffectEntry { effect, joint, parameters } in effects {
            let _ = writeln!(text, "\n[[effects]]\neffect = \"{effect}\"");
            if let Some(joint) = joint {
                let _ = writeln!(text, "joint = \"{joint}\"");
            }
            for (name, value) in parameters {
                let _ = writeln!(text, "{name} = {value:?}");
            }
        }
        text
    }

    fn friction_table(&self, i: usize, law: &Friction) -> String {
        let Friction { coulomb, breakaway, stribeck_velocity, viscous } = law;
        format!(
            "[joints.{}.friction]\ncoulomb = {coulomb}\nbreakaway = {breakaway}\nstribeck_velocity = {stribeck_velocity}\n\
             viscous = {viscous}\nlink_share = {}\n",
            JOINTS[i], self.link_share
        )
    }

    /// What both files share; `rest` ends the table of a joint.
    fn model(&self, rest: impl Fn(usize) -> String) -> String {
        let mut text = String::from("schema = \"lostmotion/model/1\"\nname = \"planar_arm\"\nurdf = \"robot.urdf\"\n");
        for (i, name) in JOINTS.iter().enumerate() {
            let ratio = GEAR_RATIO[i];
            let _ = write!(
                text,
                "\n[joints.{name}]\ngear_ratio = {ratio}\nrotor_inertia = {}\ngear_stiffness = 3000.0\ngear_damping = 2.0\n{}\
                 [joints.{name}.motor]\ntorque_constant = {TORQUE_CONSTANT}\nresistance = 0.5\ninductance = 0.0005\n\
                 [joints.{name}.drive]\nvoltage_limit = 24.0\ncurrent_limit = 18.0\n\
                 [joints.{name}.encoder]\ncounts_per_turn = 2000\n\
                 [joints.{name}.velocity_sensor]\nlow_pass_time_constant = 0.02\n\
                 [joints.{name}.current_sensor]\nnoise = 0.03\nresolution = 0.009765625\n",
                self.rotor_inertia[i] / (ratio * ratio),
                rest(i),
            );
        }
        text.push_str("\n[accuracy]\nmasses = 0.0\ncentres = 0.0\ninertias = 0.0\ntorque_constants = 0.0\nrotor_inertias = 0.0\nstiffness = 0.0\n");
        text
    }
}
