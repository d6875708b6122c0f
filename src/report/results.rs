//! Reads identifications back from `report.json`: every parameter over several results.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::{Error, Place, Result};
use crate::identify::LawKind;
use crate::identify::statistics::mean_with_error;
use crate::identify::trend::{History, Repeat};

/// Parameters of a law in each direction: key, and symbol for readers.
const EXPONENTIAL: [(&str, &str); 4] =
    [("coulomb", "F_C"), ("breakaway", "F_S"), ("stribeck_velocity", "v_S"), ("viscous", "F_V")];
const TWO_LINES: [(&str, &str); 4] = [("a1", "a1"), ("b1", "b1"), ("a2", "a2"), ("b2", "b2")];
/// Directions: key, and sign for readers.
const DIRECTIONS: [(&str, &str); 2] = [("positive", "+"), ("negative", "−")];
/// Key of the gap.
const GAP: &str = "backlash.best.mean";

/// The `report.json` of an identification, as read.
struct ResultFile {
    path: PathBuf,
    name: String,
    joints: Vec<Value>,
}

/// The file of a result that is given as a file or as its folder.
pub fn file_of(given: &Path) -> PathBuf {
    if given.is_dir() { given.join("report.json") } else { given.to_owned() }
}

/// Name of the machine or scenario of the first result, and the history of every parameter of every joint. `times`: one for each file.
///
/// # Errors
/// A file cannot be read, is no result of an identification, or lacks a value; units differ between results.
pub fn histories(files: &[PathBuf], times: &[f64]) -> Result<(String, Vec<History>)> {
    let results = files.iter().map(|file| ResultFile::read(file)).collect::<Result<Vec<_>>>()?;
    let mut joints: Vec<&str> = Vec::new();
    for joint in results.iter().flat_map(|result| &result.joints).filter_map(|joint| joint["joint"].as_str()) {
        if !joints.contains(&joint) {
            joints.push(joint);
        }
    }
    let mut found = Vec::new();
    for joint in joints {
        for parameter in parameters(&results, joint)? {
            found.extend(history(&results, times, joint, &parameter)?);
        }
    }
    Ok((results.first().map_or_else(String::new, |first| first.name.clone()), found))
}

/// The parameter for readers: `F_C +` for `friction.exponential.positive.coulomb`.
pub fn symbol(parameter: &str) -> String {
    let part = |at: usize| parameter.rsplit('.').nth(at).unwrap_or_default();
    let law = EXPONENTIAL.iter().chain(&TWO_LINES).find(|(key, _)| *key == part(0));
    let direction = DIRECTIONS.iter().find(|(key, _)| *key == part(1));
    match (law, direction) {
        (Some((_, symbol)), Some((_, sign))) => format!("{symbol} {sign}"),
        _ if parameter == GAP => "gap".to_owned(),
        _ => parameter.to_owned(),
    }
}

impl ResultFile {
    fn read(path: &Path) -> Result<Self> {
        let path = path.to_owned();
        let text = fs::read_to_string(&path).map_err(|source| Error::file(&path, "read", source))?;
        let content: Value = serde_json::from_str(&text)
            .map_err(|why| Error::input(&path, Place::Line(why.line()), "", "", format!("JSON, but {why}")))?;
        let schema = content["schema"].as_str().unwrap_or_default();
        let joints = match schema {
            "lostmotion/identification/1" => &content["joints"],
            "lostmotion/diagnosis/1" => &content["identification"]["joints"],
            _ => {
                let expected =
                    "lostmotion/identification/1, the report.json of `identify`, or of `run` with an identification";
                return Err(Error::input(&path, Place::File, "schema", schema, expected));
            }
        };
        let Some(joints) = joints.as_array().cloned() else {
            let expected = "identified joints, a list; this result has none";
            return Err(Error::input(&path, Place::File, "joints", "", expected));
        };
        let name = content["name"].as_str().unwrap_or("machine").to_owned();
        Ok(Self { path, name, joints })
    }

    fn joint(&self, name: &str) -> Option<&Value> {
        self.joints.iter().find(|joint| joint["joint"] == name)
    }

    fn refuse<T>(&self, joint: &str, key: &str, value: &Value, expected: &str) -> Result<T> {
        let value = if value.is_null() { String::new() } else { value.to_string() };
        Err(Error::input(&self.path, Place::File, format!("{joint}: {key}"), value, expected))
    }
}

/// The parameters of a joint: those of the law that most results prefer, and the gap.
fn parameters(results: &[ResultFile], joint: &str) -> Result<Vec<String>> {
    let (mut lines, mut all) = (0, 0);
    for result in results {
        let Some(found) = result.joint(joint) else { continue };
        let preferred = &found["friction"]["preferred"];
        let kinds = [LawKind::Exponential, LawKind::TwoLines];
        let kind = kinds.into_iter().find(|kind| serde_json::to_value(kind).is_ok_and(|name| name == *preferred));
        let Some(kind) = kind else {
            return result.refuse(joint, "friction.preferred", preferred, "\"exponential\" or \"two_lines\"");
        };
        lines += usize::from(kind == LawKind::TwoLines);
        all += 1;
    }
    let (law, coefficients) = if 2 * lines > all { ("lines", TWO_LINES) } else { ("exponential", EXPONENTIAL) };
    let of_law = coefficients
        .iter()
        .flat_map(|(key, _)| DIRECTIONS.iter().map(move |(direction, _)| format!("friction.{law}.{direction}.{key}")));
    Ok(of_law.chain([GAP.to_owned()]).collect())
}

/// The history of a parameter; `None` where no result has it, which only the gap may lack.
fn history(results: &[ResultFile], times: &[f64], joint: &str, parameter: &str) -> Result<Option<History>> {
    let mut history: Option<History> = None;
    for (result, &time) in results.iter().zip(times) {
        let Some(found) = result.joint(joint) else { continue };
        let quantity = parameter.split('.').fold(found, |at, key| &at[key]);
        if quantity.is_null() && parameter == GAP {
            continue;
        }
        let number = |key: &str| {
            let value = &quantity[key];
            match value.as_f64() {
                Some(number) if number.is_finite() => Ok(number),
                _ => result.refuse(joint, &format!("{parameter}.{key}"), value, "a number"),
            }
        };
        let (value, std_error) = (number("value")?, number("std_error")?);
        let unit = quantity["unit"].as_str().unwrap_or_default();
        if std_error <= 0.0 {
            let key = format!("{parameter}.std_error");
            return result.refuse(joint, &key, &quantity["std_error"], "a standard error above zero");
        }
        let history = history.get_or_insert_with(|| History {
            joint: joint.to_owned(),
            parameter: parameter.to_owned(),
            unit: unit.to_owned(),
            repeats: Vec::new(),
        });
        if history.unit != unit {
            let expected = format!("{}, as in the results before it", history.unit);
            return result.refuse(joint, &format!("{parameter}.unit"), &quantity["unit"], &expected);
        }
        let reversals = if parameter == GAP { &found["backlash"]["best"]["values"] } else { &Value::Null };
        let std_error = error_of_scatter(reversals).map_or(std_error, |own| own.min(std_error));
        history.repeats.push(Repeat { time, value, std_error });
    }
    Ok(history)
}

/// Standard error of a mean by the scatter of the values of single reversals. That of a gap also contains what all reversals share, of counts and stiffness: repeats
/// on one machine share it as well. `None` of fewer than three values, or where they do not scatter.
fn error_of_scatter(values: &Value) -> Option<f64> {
    /// Fewest values whose scatter says something.
    const FEWEST: usize = 3;
    let gaps: Vec<f64> = values.as_array()?.iter().filter_map(|value| value["gap"].as_f64()).collect();
    let (_, error) = mean_with_error(&gaps);
    (gaps.len() >= FEWEST && error > 0.0).then_some(error)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Three reversals at 1, 2 and 3 have a mean with an error of `1/√3`. One that is stated smaller holds, and so does that of two reversals.
    #[test]
    fn analytic_repeats_of_a_gap_scatter_as_its_reversals() {
        let error = |values: &[f64], stated: f64| {
            let values: Vec<Value> = values.iter().map(|gap| json!({"gap": gap})).collect();
            let mean = json!({"value": 2.0, "std_error": stated, "unit": "rad"});
            let joint = json!({"joint": "j1", "backlash": {"best": {"mean": mean, "values": values}}});
            let result = ResultFile { path: PathBuf::new(), name: String::new(), joints: vec![joint] };
            history(&[result], &[0.0], "j1", GAP).expect("a result").expect("a gap").repeats[0].std_error
        };
        assert!((error(&[1.0, 2.0, 3.0], 5.0) - 3f64.sqrt().recip()).abs() < 1e-14);
        assert_eq!(error(&[1.0, 2.0, 3.0], 0.5), 0.5);
        assert_eq!(error(&[1.0, 3.0], 5.0), 5.0);
        assert_eq!(error(&[2.0, 2.0, 2.0], 5.0), 5.0);
    }
}
