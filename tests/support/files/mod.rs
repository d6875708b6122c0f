//! Good files of every kind, a folder to break them in, and the program run there.
#![allow(dead_code, reason = "every test is its own crate and uses its own part")]

#[cfg(feature = "db3")]
pub mod db3;
#[cfg(feature = "mcap")]
pub mod mcap;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod recordings;
pub mod turntable;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A machine of one joint with little in it.
pub const PLAIN_URDF: &str = r#"<?xml version="1.0"?>
<robot name="turntable">
  <link name="base"/>
  <link name="table">
    <inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial>
    <collision><geometry><box size="0.2 0.02 0.02"/></geometry></collision>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="table"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="5" velocity="40"/>
  </joint>
</robot>
"#;

/// Its model file.
pub const PLAIN_MODEL: &str = r#"schema = "lostmotion/model/1"
name = "turntable"
urdf = "robot.urdf"

[joints.turn]
gear_ratio = 5.0
rotor_inertia = 0.0008
gear_stiffness = 3000.0
gear_damping = 2.0
backlash = 0.008

[joints.turn.motor]
torque_constant = 0.023

[joints.turn.current_sensor]
noise = 0.01

[joints.turn.friction]
coulomb = 0.3
viscous = 0.4
"#;

/// A folder that lasts as long as it is used.
pub struct Folder(TempDir);

impl Folder {
    /// With these files.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, text) in files {
            folder.put(name, text);
        }
        folder
    }

    /// With the machine of one joint.
    pub fn plain() -> Self {
        Self::with(&[("robot.urdf", PLAIN_URDF), ("model.toml", PLAIN_MODEL)])
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, and the folders above it.
    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("folders");
        fs::write(&path, content).expect("a file in a temporary folder");
        path
    }

    /// Names of its entries, sorted.
    pub fn names(&self) -> Vec<String> {
        names(self.root())
    }

    /// The program, in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
        command.args(arguments).current_dir(self.root()).env_remove("LOSTMOTION_DATA");
        command
    }

    pub fn lostmotion(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program runs")
    }
}

/// Names of the entries of a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// What is wrong with a refusal: exit code 2, one message for people with these parts, nothing on standard output.
pub fn fault_of_refusal(output: &Output, parts: &[&str]) -> Result<(), String> {
    let message = String::from_utf8_lossy(&output.stderr);
    let fault = |what: String| Err(format!("  {what}: {message}"));
    if output.status.code() != Some(2) {
        return fault(format!("exit code {:?}", output.status.code()));
    }
    if !message.starts_with("error: ") || message.lines().count() != 1 {
        return fault("not one message".to_owned());
    }
    let debug = ["panicked", "unwrap", "Some(", "Error {", "Kind(", "thread '", "RUST_BACKTRACE"];
    if let Some(word) = debug.iter().find(|word| message.contains(**word)) {
        return fault(format!("debug text `{word}`"));
    }
    if let Some(part) = parts.iter().find(|part| !message.contains(**part)) {
        return fault(format!("`{part}` missing"));
    }
    if !output.stdout.is_empty() {
        return fault(format!("{} on standard output", String::from_utf8_lossy(&output.stdout)));
    }
    Ok(())
}

/// Asserts that a command was refused with these parts in its message.
#[track_caller]
pub fn refused(output: &Output, parts: &[&str]) {
    if let Err(fault) = fault_of_refusal(output, parts) {
        panic!("{fault}");
    }
}
