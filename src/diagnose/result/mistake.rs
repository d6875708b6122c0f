//! A mistake in the data or in the model file.

use serde::Serialize;

/// A mistake in the data or in the model file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mistake {
    /// Its name: `sign_of_current`, `gear_ratio` and so on.
    pub mistake: &'static str,
    /// Joints that it concerns.
    pub joints: Vec<String>,
    /// Factor by which the channel or the number of the model file has to be multiplied, where the mistake is a factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// What was measured.
    pub evidence: String,
    /// What to change, and in which file.
    pub remedy: String,
    /// Other mistakes that these data cannot distinguish from it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<&'static str>,
}

impl Mistake {
    /// The mistake, what was measured and what to change.
    pub fn sentence(&self) -> String {
        let or: Vec<String> = self.alternatives.iter().map(|other| format!(" or {other}")).collect();
        format!(
            "{}{} suspected on {}. {} Remedy: {}.",
            self.mistake,
            or.concat(),
            self.joints.join(", "),
            self.evidence,
            self.remedy
        )
    }
}
