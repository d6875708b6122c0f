//! Drives of a URDF: its elements `<transmission>`, also those inside `<ros2_control>`.
//!
//! ```text
//!   <mechanicalReduction>100</mechanicalReduction>       ROS, at the actuator or the joint; ROS 2 spells it mechanical_reduction
//!   <motorTorqueConstant>0.06</motorTorqueConstant>      ROS
//!   <drake:gear_ratio value="160"/> <drake:rotor_inertia value="1e-5"/>
//! ```
//! A reduction of 1 is ignored: templates contain it. The sign of a reduction describes the motor's wiring and is ignored too: here
//! positive current drives the joint in its positive direction.
//! Left out: transmissions of several joints, whose matrix belongs in `[coupling]` of the model file.

use std::ops::RangeInclusive;

use super::Urdf;
use super::scan::Element;
use crate::robot::drives::{DriveData, Drives};
use crate::robot::remark::Remark;

/// [1 or rad/m] Reductions that a gear can have; 1 is excluded as a template value.
const REDUCTIONS: RangeInclusive<f64> = 1.01..=1e6;

/// [kg·m²] Inertias that a rotor can have, from a motor of 2 mm to that of a wind turbine.
const ROTORS: RangeInclusive<f64> = 1e-12..=1e7;

/// [N·m/A] Torque constants that a motor can have.
const CONSTANTS: RangeInclusive<f64> = 1e-9..=1e5;

/// [1] Values of one drive that differ by less are one value, written with different digits.
const ALIKE: f64 = 1e-3;

impl Urdf<'_> {
    /// Drive data of the file, by joint. Values without a meaning are remarked.
    pub(in crate::robot) fn drives(&self, remarks: &mut Vec<Remark>) -> Drives {
        let mut drives = Drives::new();
        let of_control =
            self.text.owners("ros2_control").flat_map(|control| self.text.children(control, "transmission"));
        for transmission in self.text.owners("transmission").chain(of_control) {
            let mut joints: Vec<&str> =
                self.text.children(transmission, "joint").filter_map(|joint| joint.attribute("name")).collect();
            joints.dedup();
            match joints[..] {
                [] => {}
                [joint] => {
                    let data = self.drive(transmission, remarks);
                    drives.entry(joint.to_owned()).or_insert(data);
                }
                _ => {
                    let text =
                        "a transmission of several joints is not read; write it as [coupling] into the model file";
                    remarks.push(self.text.remark_at(transmission, text));
                }
            }
        }
        drives
    }

    fn drive(&self, transmission: &Element<'_>, remarks: &mut Vec<Remark>) -> DriveData {
        let mut one = |names: &[&str], range: &RangeInclusive<f64>| self.one(transmission, names, range, remarks);
        DriveData {
            gear_ratio: one(&["mechanicalReduction", "mechanical_reduction", "drake:gear_ratio"], &REDUCTIONS),
            rotor_inertia: one(&["drake:rotor_inertia"], &ROTORS),
            armature: None,
            torque_constant: one(&["motorTorqueConstant"], &CONSTANTS),
        }
    }

    /// The value of the elements of these names anywhere inside a transmission; further values that differ are remarked.
    fn one(
        &self,
        transmission: &Element<'_>,
        names: &[&str],
        range: &RangeInclusive<f64>,
        remarks: &mut Vec<Remark>,
    ) -> Option<f64> {
        let mut found: Option<f64> = None;
        let mut waiting: Vec<&Element<'_>> = self.text.inside(transmission).collect();
        while let Some(element) = waiting.pop() {
            waiting.extend(self.text.inside(element));
            if !names.contains(&element.name) {
                continue;
            }
            let written = element.attribute("value").unwrap_or_else(|| self.text.content(element)).trim();
            let value = written.parse::<f64>().ok().map(f64::abs);
            let mut ignored = |why: &str| {
                let shown: String = written.chars().take(40).collect();
                remarks.push(self.text.remark_at(element, &format!("{} \"{shown}\" {why}", element.name)));
            };
            match (value, found) {
                (Some(1.0), _) => {}
                (Some(value), None) if range.contains(&value) => found = Some(value),
                (Some(value), Some(other)) if (value - other).abs() <= ALIKE * other => {}
                (Some(value), Some(other)) if range.contains(&value) => {
                    ignored(&format!("is not taken, another one of this transmission is {other}"));
                }
                _ => {
                    ignored(&format!("is not taken, expected a number from {} to {:e}", range.start(), range.end()));
                }
            }
        }
        found
    }
}
