//! Drive data in a robot file: gear ratios, rotor inertias, torque constants.

use std::collections::BTreeMap;

/// What a robot file states about the drive of a joint; `None` where it states nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct DriveData {
    /// Motor turns [rad] per joint motion [rad or m], > 0.
    pub gear_ratio: Option<f64>,
    /// [kg·m²] at the motor shaft, > 0.
    pub rotor_inertia: Option<f64>,
    /// [kg·m² or kg] Rotor inertia seen at the joint, `ratio² · J_r`, > 0.
    pub armature: Option<f64>,
    /// [N·m/A] > 0.
    pub torque_constant: Option<f64>,
}

/// Drive data by the name of the joint.
pub(super) type Drives = BTreeMap<String, DriveData>;
