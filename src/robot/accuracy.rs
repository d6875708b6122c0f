//! How well the nominal values of a model are known: one standard deviation of each group of values.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{Inertia, Masses, Model, Robot};
use crate::error::Result;
use crate::toml_input::{Range, Table};

/// The table `[accuracy]` of a model file: one standard deviation, as a share of the nominal value where no unit is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// `s_m` [1] Masses of the links.
    pub masses: f64,
    /// `s_c` [m] Centres of mass, along each axis.
    pub centres: f64,
    /// `s_I` [1] Moments of inertia about the centres of mass.
    pub inertias: f64,
    /// `s_K` [1] Torque constants.
    pub torque_constants: f64,
    /// `s_J` [1] Rotor inertias.
    pub rotor_inertias: f64,
    /// [1] Stiffness of the gears.
    pub stiffness: f64,
}

/// Values that fit a vendor's URDF: masses come from CAD without cables, grease and screws, tensors from solids of uniform density, and
/// motor constants from a catalogue, with the tolerance of the magnets.
impl Default for Accuracy {
    fn default() -> Self {
        Self {
            masses: 0.1,
            centres: 0.005,
            inertias: 0.15,
            torque_constants: 0.05,
            rotor_inertias: 0.1,
            stiffness: 0.3,
        }
    }
}

/// `s_K` [1] Accuracy from which on torque constants are guesses: the true one may be twice or half of it.
const GUESS: f64 = 0.5;
/// [1] Largest share: a mass known to a factor of ten is not known.
const LARGEST: f64 = 10.0;
/// [1] A value never falls below this share of its nominal value.
pub const LEAST_FACTOR: f64 = 0.1;
/// [1] Smaller changes are not written: relative to the value, or to this number where the value is smaller than it.
const SHOWN: f64 = 1e-9;
/// Count of a body's parameters in which the equations of motion are linear, see [`Inertia::parameters`].
const NUMBERS: usize = Inertia::NUMBERS;

impl Accuracy {
    /// Every nominal value is exact.
    pub const EXACT: Self =
        Self { masses: 0.0, centres: 0.0, inertias: 0.0, torque_constants: 0.0, rotor_inertias: 0.0, stiffness: 0.0 };

    /// Masses, centres and inertias are only known to their order of magnitude; the rest has its default.
    pub fn of_guesses() -> Self {
        Self { masses: 3.0, centres: 0.3, inertias: 3.0, ..Self::default() }
    }

    /// Whether torque constants are guesses: what the model file says of them contradicts no other value.
    pub fn guesses_torque_constants(&self) -> bool {
        self.torque_constants >= GUESS
    }

    /// Reads the table `[accuracy]`; missing keys take their default. `masses = "unknown"` makes all inertial values guesses.
    ///
    /// # Errors
    /// A key is unknown or out of its range.
    pub(super) fn read(table: &Table<'_>) -> Result<(Self, Masses)> {
        let unknown = table.optional_text("masses").is_ok_and(|text| text == Some("unknown"));
        let default = if unknown { Self::of_guesses() } else { Self::default() };
        let range = Range::between(0.0, LARGEST, "1");
        let share = |key: &str, default: f64| table.number_or(key, &range, default);
        let masses = || {
            let or_unknown = |_| table.error("masses", format!("{range}, or \"unknown\""));
            share("masses", default.masses).map_err(or_unknown)
        };
        let accuracy = Self {
            masses: if unknown { default.masses } else { masses()? },
            centres: table.number_or("centres", &Range::between(0.0, LARGEST, "m"), default.centres)?,
            inertias: share("inertias", default.inertias)?,
            torque_constants: share("torque_constants", default.torque_constants)?,
            rotor_inertias: share("rotor_inertias", default.rotor_inertias)?,
            stiffness: share("stiffness", default.stiffness)?,
        };
        Ok((accuracy, if unknown { Masses::Estimated } else { Masses::Known }))
    }

    /// Keys of the table and their values, in the order of the file, with their units.
    pub(super) fn entries(&self) -> [(&'static str, f64, &'static str); 6] {
        [
            ("masses", self.masses, "one standard deviation, as a share of the value"),
            ("centres", self.centres, "[m]"),
            ("inertias", self.inertias, ""),
            ("torque_constants", self.torque_constants, ""),
            ("rotor_inertias", self.rotor_inertias, ""),
            ("stiffness", self.stiffness, ""),
        ]
    }

    /// Changes of the bodies' parameters by one standard deviation of each nominal value: `10 n` rows in the order of
    /// [`Inertia::parameters`], ten columns per body (mass, centre, tensor). The values of a body are independent.
    pub fn inertial_deviations(&self, robot: &Robot) -> DMatrix<f64> {
        let n = robot.bodies.len();
        let mut deviations = DMatrix::zeros(NUMBERS * n, NUMBERS * n);
        for (index, body) in robot.bodies.iter().enumerate() {
            let at = (NUMBERS * index, NUMBERS * index);
            deviations.view_mut(at, (NUMBERS, NUMBERS)).copy_from(&self.deviations_of(&body.inertia));
        }
        deviations
    }

    /// Changes of one body's parameters.
    pub fn deviations_of(&self, body: &Inertia) -> DMatrix<f64> {
        DMatrix::from_column_slice(NUMBERS, NUMBERS, self.of_body(body).as_flattened())
    }

    /// Columns of one body.
    fn of_body(&self, body: &Inertia) -> [[f64; NUMBERS]; NUMBERS] {
        let (m, c, i) = (body.mass, body.com, body.tensor);
        let steiner = Matrix3::identity() * c.norm_squared() - c * c.transpose();
        let mut changes = [[0.0; NUMBERS]; NUMBERS];
        changes[0] = listed(self.masses * m, c * (self.masses * m), steiner * (self.masses * m));
        for (k, change) in changes[1..4].iter_mut().enumerate() {
            let e = Vector3::ith(k, 1.0);
            let slope = Matrix3::identity() * (2.0 * c[k]) - e * c.transpose() - c * e.transpose();
            *change = listed(0.0, e * (self.centres * m), slope * (self.centres * m));
        }
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        for (change, (r, s)) in changes[4..].iter_mut().zip(pairs) {
            // A product of inertia is a rotation of the principal axes by half of the relative error of the moments.
            let size = if r == s { i[(r, r)] } else { 0.5 * (i[(r, r)] * i[(s, s)]).max(0.0).sqrt() };
            let mut tensor = Matrix3::zeros();
            (tensor[(r, s)], tensor[(s, r)]) = (self.inertias * size, self.inertias * size);
            *change = listed(0.0, Vector3::zeros(), tensor);
        }
        changes
    }
}

impl Model {
    /// The machine with its nominal values changed by `u` standard deviations: ten per body, then the rotors, then the torque constants.
    /// Each changed body is the nearest one that is physically possible. Bodies whose change would not show in the file stay as they are.
    pub fn deviating(&self, u: &[f64]) -> Self {
        let n = self.robot.bodies.len();
        let of_bodies = DVector::from_iterator(NUMBERS * n, u.iter().copied().take(NUMBERS * n));
        let changes = self.accuracy.inertial_deviations(&self.robot) * of_bodies;
        let mut model = self.clone();
        let mut changed = Vec::new();
        for (index, body) in model.robot.bodies.iter_mut().enumerate() {
            let mut parameters = body.inertia.parameters();
            let change = &changes.as_slice()[NUMBERS * index..NUMBERS * (index + 1)];
            if change.iter().zip(&parameters).any(|(change, value)| change.abs() > SHOWN * value.abs().max(SHOWN)) {
                parameters.iter_mut().zip(change).for_each(|(value, change)| *value += change);
                body.inertia = Inertia::nearest(&parameters);
                changed.push(index);
            }
        }
        let rotors = u.iter().skip(NUMBERS * n);
        let constants = rotors.clone().skip(n);
        for (index, (rotor, constant)) in rotors.zip(constants).enumerate().take(n) {
            let joint = &mut model.joints[index];
            let factor = (1.0 + self.accuracy.rotor_inertias * rotor).max(LEAST_FACTOR);
            joint.rotor_inertia = joint.rotor_inertia.map(|inertia| inertia * factor);
            if let Some(motor) = &mut joint.motor {
                motor.torque_constant *= self.torque_factor(index, *constant);
            }
        }
        model.write_inertias(&changed);
        model
    }

    /// `s_K` [1] Accuracy of a joint's torque constant.
    pub fn constant_accuracy(&self, joint: usize) -> f64 {
        self.joints[joint].constant_accuracy.unwrap_or(self.accuracy.torque_constants)
    }

    /// `1/(1 − s_K u)` True torque per torque computed with the nominal constant, where a current shows `1 − s_K u` of the torque that was expected. For an
    /// accuracy of a few per cent `u` are standard deviations of the constant; a guessed constant of accuracy 1 may be half or several times the true one.
    pub fn torque_factor(&self, joint: usize, u: f64) -> f64 {
        factor_where_shown(1.0 - self.constant_accuracy(joint) * u)
    }
}

/// True torque per computed torque, where a current shows this share of the torque that was expected.
fn factor_where_shown(share: f64) -> f64 {
    share.clamp(LEAST_FACTOR, LEAST_FACTOR.recip()).recip()
}

/// The ten numbers of a body in the order of [`Inertia::parameters`].
fn listed(m: f64, h: Vector3<f64>, i: Matrix3<f64>) -> [f64; NUMBERS] {
    [m, h.x, h.y, h.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(mass: f64, com: [f64; 3], moments: [f64; 3]) -> Inertia {
        Inertia { mass, com: com.into(), tensor: Matrix3::from_diagonal(&moments.into()) }
    }

    #[test]
    fn analytic_half_of_the_expected_current_is_twice_the_constant() {
        // Twice the constant needs half of the expected current, half of it twice as much.
        for (shown, factor) in [(0.5, 2.0), (2.0, 0.5), (1.0, 1.0), (-3.0, 10.0), (40.0, 0.1)] {
            assert!((factor_where_shown(shown) - factor).abs() < 1e-12, "{shown} of the current");
        }
    }

    /// The columns are the derivatives of the ten numbers, times one standard deviation.
    #[test]
    fn equivalent_deviations_are_differences_of_the_parameters() {
        let accuracy = Accuracy::default();
        let nominal = body(2.0, [0.1, -0.2, 0.3], [0.02, 0.03, 0.04]);
        let found = accuracy.of_body(&nominal);
        let step = 1e-6;
        let mut heavier = nominal;
        heavier.mass *= 1.0 + step * accuracy.masses;
        let mut shifted = nominal;
        shifted.com.y += step * accuracy.centres;
        let mut wider = nominal;
        wider.tensor[(2, 2)] *= 1.0 + step * accuracy.inertias;
        for (column, moved) in [(0, heavier), (2, shifted), (9, wider)] {
            for (k, (new, old)) in moved.parameters().iter().zip(nominal.parameters()).enumerate() {
                // The second derivative adds 5e-3 · 1e-6 of a kg·m²; rounding of numbers of 2 adds 4e-16/1e-6.
                assert!(((new - old) / step - found[column][k]).abs() < 1e-8, "column {column}, number {k}");
            }
        }
    }
}
