//! The files of the corpus, and how each is read.

use lostmotion::timeseries::Channel::{self, Current, Position, ReferencePosition, Torque, Velocity};

/// How a file is read.
pub enum Read {
    /// As it is.
    Directly,
    /// By a manifest; this part of the refusal says why.
    ByManifest(&'static str),
    /// Not at all; this part of the refusal is the way out.
    Refused(&'static str),
}

/// A file of the corpus.
pub struct Case {
    /// Its name.
    pub file: &'static str,
    /// What wrote it, and how it is laid out.
    pub made: &'static str,
    /// How it is read.
    pub read: Read,
    /// Channels of each joint, and the channels of the recording from which they were made.
    pub channels: &'static [(Channel, Channel)],
    /// [s] Largest error of the time.
    pub time_error: f64,
    /// Whether values were written in single precision, or in a list of them.
    pub single: bool,
}

type Channels = &'static [(Channel, Channel)];

/// All three channels of the recording.
const ALL: Channels = &[(Position, Position), (Velocity, Velocity), (Current, Current)];
/// The current in a column of torques, whose values are the same.
const AS_TORQUE: Channels = &[(Position, Position), (Velocity, Velocity), (Torque, Current)];
/// Positions and their action of LeRobot.
const LEROBOT: Channels = &[(Position, Position), (ReferencePosition, Position)];
/// Where nothing but the numbers tells what the columns hold.
const MOTION: Channels = &[(Position, Position), (Velocity, Velocity)];
const NO_VELOCITY: Channels = &[(Position, Position), (Current, Current)];

/// [s] Two roundings of a double that is a tenth of a second, and of a product with 1e-9.
const EXACT: f64 = 1e-16;
/// [s] Half of the last place of an f32 that is a tenth of a second, 3.7e-9.
const SINGLE: f64 = 4e-9;

const fn case(file: &'static str, made: &'static str, read: Read, channels: Channels) -> Case {
    Case { file, made, read, channels, time_error: EXACT, single: false }
}

const fn direct(file: &'static str, made: &'static str) -> Case {
    case(file, made, Read::Directly, ALL)
}

const fn asked(file: &'static str, made: &'static str, doubt: &'static str, channels: Channels) -> Case {
    case(file, made, Read::ByManifest(doubt), channels)
}

const fn refused(file: &'static str, made: &'static str, way: &'static str) -> Case {
    case(file, made, Read::Refused(way), &[])
}

const fn single(case: Case) -> Case {
    Case { time_error: SINGLE, single: true, ..case }
}

/// The corpus.
pub const CASES: &[Case] = &[
    direct("plain.csv", "pandas: canonical columns"),
    direct("semicolon.csv", "pandas: semicolons"),
    direct("semicolon_comma.csv", "pandas: semicolons, decimal comma"),
    direct("tab.tsv", "pandas: tabs"),
    direct("tab_comma.txt", "pandas: tabs, decimal comma"),
    direct("blanks.dat", "pandas `to_string`: runs of blanks"),
    direct("numpy_savetxt.txt", "numpy `savetxt`: blanks, names in a comment"),
    direct("comments.csv", "lines of comment before the header"),
    direct("preamble.csv", "lines of text before the header"),
    direct("bom_crlf.csv", "a spreadsheet: byte order mark, line ends of Windows"),
    direct("utf16.csv", "a spreadsheet: UTF-16"),
    direct("gzip.csv.gz", "CSV compressed by gzip"),
    direct("quoted_index.csv", "pandas: quotes, a column of row numbers without a name"),
    direct("no_extension", "CSV whose name has no ending"),
    asked("no_header.csv", "CSV without a header", "no names for its columns", MOTION),
    direct("units_row.csv", "a row of units below the header"),
    direct("time_ns.csv", "`timestamp_ns` since 1970, 1.76e18"),
    direct("time_us.csv", "`t_us`"),
    direct("time_ms.csv", "`time_ms`"),
    direct("time_epoch.csv", "seconds since 1970 with nine decimals"),
    asked("time_without_unit.csv", "`time` in µs, without saying so", "the time is likely in us", ALL),
    direct("time_iso.csv", "pandas: dates and times of day (ISO 8601)"),
    direct("ros_stamp.csv", "`header.stamp.sec` and `header.stamp.nanosec`"),
    direct("stamp_pair.csv", "`stamp_sec` and `stamp_nsec`"),
    case(
        "plotjuggler.csv",
        "PlotJuggler: `__time`, `/joint_states/joint1/position` ... `effort`",
        Read::Directly,
        AS_TORQUE,
    ),
    direct("numbered.csv", "`position_0`, `velocity_0`, `current_0`"),
    case("q_dq_tau.csv", "`q1`, `dq1`, `tau1`", Read::Directly, AS_TORQUE),
    direct("ur_rtde.csv", "RTDE of Universal Robots: `actual_q_0`, `actual_qd_0`, `actual_current_0`"),
    direct("brackets.csv", "`joint_positions[0]`, `motor_currents[0]`"),
    asked("single_letter.csv", "`joint1_pos`, `i_1`", "`i`: a current in A?", ALL),
    direct("units_in_brackets.csv", "`joint1 position [deg]`, `joint1 current [mA]`"),
    asked("counts.csv", "`joint1 position [counts]`", "[counts] is not a known unit", NO_VELOCITY),
    direct("snappy.parquet", "pandas: Snappy"),
    direct("gzip.parquet", "pandas: gzip"),
    direct("brotli.parquet", "pandas: brotli"),
    direct("zstd.parquet", "pandas: Zstandard"),
    direct("lz4.parquet", "pandas: LZ4"),
    direct("none.parquet", "pandas: not compressed"),
    direct("index.parquet", "pandas: the time as index"),
    direct("datetime_ms.parquet", "pandas: time stamps in ms"),
    direct("datetime_us.parquet", "pandas: time stamps in µs"),
    direct("datetime_ns.parquet", "pandas: time stamps in ns"),
    direct("timedelta.parquet", "pandas: durations"),
    single(direct("float32.parquet", "pandas: single precision")),
    single(asked(
        "lerobot.parquet",
        "LeRobot: lists in cells",
        "a state of LeRobot: a position, in what unit?",
        LEROBOT,
    )),
    refused("pandas.feather", "pandas: Feather", "read_feather('pandas.feather').to_parquet('pandas.parquet')"),
    direct("vectors.mat", "scipy, MATLAB 5: vectors `joint1_position`"),
    direct("vectors_compressed.mat", "scipy, MATLAB 5, compressed"),
    direct("struct.mat", "scipy, MATLAB 5: a structure of vectors"),
    direct("matrices.mat", "scipy, MATLAB 5: matrices `q`, `dq`, `current`, a row for each sample"),
    direct("rows.mat", "scipy, MATLAB 5: matrices with a column for each sample"),
    refused("v73.mat", "MATLAB 7.3 (HDF5)", "save('v73_v7.mat', '-struct', 's', '-v7')"),
    refused("log.h5", "h5py", "h5py.File('log.h5')"),
    direct("columns.npz", "numpy `savez`: vectors"),
    direct("matrices_compressed.npz", "numpy `savez_compressed`: matrices"),
    asked("matrix.npy", "numpy `save`: a matrix", "no names for its columns", MOTION),
    single(asked(
        "matrix_fortran.npy",
        "numpy `save`: a matrix in Fortran order, single precision",
        "no names for its columns",
        MOTION,
    )),
    direct("structured.npy", "numpy `save`: a structured array"),
    direct("columns.json", "JSON: an object of columns"),
    direct("pandas.json", "pandas `to_json`"),
    direct("records.json", "pandas `to_json`, `orient=\"records\"`: a list of rows"),
    case("ros2.mcap", "mcap-ros2: `sensor_msgs/JointState`", Read::Directly, AS_TORQUE),
    case("ros2.db3", "rosbags, SQLite as rosbag2: `sensor_msgs/JointState`", Read::Directly, AS_TORQUE),
];
