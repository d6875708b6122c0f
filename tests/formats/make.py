#!/usr/bin/env python3
"""Writes the corpus of tests/formats: one recording in many formats, by the libraries that users have.

    python3 -m venv venv && venv/bin/pip install numpy pandas pyarrow scipy h5py mcap mcap-ros2-support rosbags
    venv/bin/python tests/formats/make.py

The recording is computed here: two joints at 1 kHz, encoders of 1e-4 rad. The versions of the libraries go to corpus/VERSIONS.
"""
import gzip, importlib.metadata, json, pathlib, shutil, sqlite3

import h5py, numpy as np, pandas as pd, scipy.io as sio
from mcap_ros2.writer import Writer
from rosbags.rosbag2 import StoragePlugin, Writer as Rosbag2
from rosbags.typesys import Stores, get_typestore

OUT = pathlib.Path(__file__).parent / "corpus"
ROWS, EPOCH = 120, 1_763_000_000
JOINTS = ["joint1", "joint2"]
STEPS = np.arange(ROWS) * 1_000_000  # [ns]


def recording():
    t = np.arange(ROWS) / 1000
    table = {"time": t}
    for joint, (a, w) in zip(JOINTS, [(0.4, 25.0), (0.3, 40.0)]):
        q = a * np.sin(w * t)
        table[f"{joint}.position"] = np.round(q, 4)
        table[f"{joint}.velocity"] = np.round(a * w * np.cos(w * t), 3)
        table[f"{joint}.current"] = np.round(1.5 * np.sign(np.cos(w * t)) + 2 * np.sin(w * t + 0.5), 2)
    return pd.DataFrame(table)


def renamed(df, channels, time="time"):
    """The table with names made of the joint's number from 0 and the joint; None leaves a channel out."""
    names = {"time": time}
    for at, joint in enumerate(JOINTS):
        for channel, name in channels.items():
            if name is not None:
                names[f"{joint}.{channel}"] = name.format(i=at, n=at + 1, joint=joint)
    return df[list(names)].rename(columns=names)


def texts(df):
    csv = df.to_csv(index=False)
    put = lambda name, text, encoding="utf-8": (OUT / name).write_bytes(text.encode(encoding))
    put("plain.csv", csv)
    df.to_csv(OUT / "semicolon.csv", index=False, sep=";")
    df.to_csv(OUT / "semicolon_comma.csv", index=False, sep=";", decimal=",")
    df.to_csv(OUT / "tab.tsv", index=False, sep="\t")
    df.to_csv(OUT / "tab_comma.txt", index=False, sep="\t", decimal=",")
    put("blanks.dat", df.to_string(index=False) + "\n")
    np.savetxt(OUT / "numpy_savetxt.txt", df.to_numpy(), fmt="%.6g", header=" ".join(df.columns))
    put("comments.csv", "# recorded by hand\n# robot: scara\n" + csv)
    put("preamble.csv", "Logger 2.1\nrobot 7\n\n" + csv)
    put("bom_crlf.csv", "\ufeff" + csv.replace("\n", "\r\n"))
    put("utf16.csv", "\ufeff" + csv.replace("\n", "\r\n"), "utf-16-le")
    (OUT / "gzip.csv.gz").write_bytes(gzip.compress(csv.encode(), mtime=0))
    put("quoted_index.csv", df.to_csv(quoting=2))
    put("no_extension", csv)
    df.to_csv(OUT / "no_header.csv", index=False, header=False)
    head, rows = csv.split("\n", 1)
    put("units_row.csv", head + "\ns," + ",".join(["rad", "rad/s", "A"] * 2) + "\n" + rows)


def times(df):
    ns = EPOCH * 10**9 + STEPS
    with_time = lambda name, values: df.assign(time=values).rename(columns={"time": name})
    with_time("timestamp_ns", ns).to_csv(OUT / "time_ns.csv", index=False)
    with_time("t_us", STEPS // 1000).to_csv(OUT / "time_us.csv", index=False)
    with_time("time_ms", STEPS // 10**6).to_csv(OUT / "time_ms.csv", index=False)
    with_time("timestamp", [f"{EPOCH}.{k:09}" for k in STEPS]).to_csv(OUT / "time_epoch.csv", index=False)
    with_time("time", STEPS // 1000).to_csv(OUT / "time_without_unit.csv", index=False)
    with_time("datetime", pd.to_datetime(ns)).to_csv(OUT / "time_iso.csv", index=False)
    stamped = df.drop(columns="time")
    for name, prefix, names in [("ros_stamp", "header.stamp.", ("sec", "nanosec")), ("stamp_pair", "stamp_", ("sec", "nsec"))]:
        pair = {prefix + names[0]: ns // 10**9, prefix + names[1]: ns % 10**9}
        pd.concat([pd.DataFrame(pair), stamped], axis=1).to_csv(OUT / f"{name}.csv", index=False)


def names(df):
    three = lambda *names: dict(zip(["position", "velocity", "current"], names))
    renamed(df, three(*[f"/joint_states/{{joint}}/{q}" for q in ["position", "velocity", "effort"]]), "__time").to_csv(OUT / "plotjuggler.csv", index=False)
    renamed(df, three("position_{i}", "velocity_{i}", "current_{i}")).to_csv(OUT / "numbered.csv", index=False)
    renamed(df, three("q{n}", "dq{n}", "tau{n}"), "t").to_csv(OUT / "q_dq_tau.csv", index=False)
    renamed(df, three("actual_q_{i}", "actual_qd_{i}", "actual_current_{i}"), "timestamp").to_csv(OUT / "ur_rtde.csv", index=False)
    renamed(df, three("joint_positions[{i}]", "joint_velocities[{i}]", "motor_currents[{i}]")).to_csv(OUT / "brackets.csv", index=False)
    renamed(df, three("{joint}_pos", "{joint}_vel", "i_{n}")).to_csv(OUT / "single_letter.csv", index=False)
    degrees = renamed(df, three("{joint} position [deg]", "{joint} velocity [deg/s]", "{joint} current [mA]"), "time [s]")
    for column in degrees:
        if "deg" in column:
            degrees[column] = np.rad2deg(degrees[column])
        if "mA" in column:
            degrees[column] *= 1000
    degrees.to_csv(OUT / "units_in_brackets.csv", index=False)
    counts = renamed(df, three("{joint} position [counts]", None, "{joint} current [A]"))
    counts.to_csv(OUT / "counts.csv", index=False)


def parquets(df):
    for codec in ["snappy", "gzip", "brotli", "zstd", "lz4", "none"]:
        df.to_parquet(OUT / f"{codec}.parquet", compression=codec, index=False)
    df.set_index("time").to_parquet(OUT / "index.parquet")
    ns = pd.to_datetime(EPOCH * 10**9 + STEPS)
    for unit in ["ms", "us", "ns"]:
        df.assign(time=ns.astype(f"datetime64[{unit}]")).to_parquet(OUT / f"datetime_{unit}.parquet", index=False)
    df.assign(time=pd.to_timedelta(STEPS)).to_parquet(OUT / "timedelta.parquet", index=False)
    df.astype("float32").to_parquet(OUT / "float32.parquet", index=False)
    rows = lambda channel: list(df[[f"{joint}.{channel}" for joint in JOINTS]].to_numpy("float32"))
    lerobot = pd.DataFrame({"observation.state": rows("position"), "action": rows("position"), "timestamp": df.time.astype("float32")})
    lerobot.assign(frame_index=np.arange(ROWS), episode_index=0).to_parquet(OUT / "lerobot.parquet", index=False)
    df.to_feather(OUT / "pandas.feather")


def arrays(df):
    columns = {name.replace(".", "_"): df[name].to_numpy() for name in df}
    matrix = lambda channel: df[[f"{joint}.{channel}" for joint in JOINTS]].to_numpy()
    matrices = {"t": df.time.to_numpy(), "q": matrix("position"), "dq": matrix("velocity"), "current": matrix("current")}
    sio.savemat(OUT / "vectors.mat", columns)
    sio.savemat(OUT / "vectors_compressed.mat", columns, do_compression=True)
    sio.savemat(OUT / "struct.mat", {"log": columns})
    sio.savemat(OUT / "matrices.mat", matrices)
    sio.savemat(OUT / "rows.mat", {name: value.T for name, value in matrices.items()})
    with h5py.File(OUT / "v73.mat", "w", userblock_size=512) as file:
        for name, value in columns.items():
            file[name] = value[None, :]
    with open(OUT / "v73.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    with h5py.File(OUT / "log.h5", "w") as file:
        for name in df:
            file[name] = df[name].to_numpy()
    np.savez(OUT / "columns.npz", **{name: df[name].to_numpy() for name in df})
    np.savez_compressed(OUT / "matrices_compressed.npz", **matrices)
    np.save(OUT / "matrix.npy", df.to_numpy())
    np.save(OUT / "matrix_fortran.npy", np.asfortranarray(df.to_numpy("float32")))
    np.save(OUT / "structured.npy", df.to_records(index=False))
    (OUT / "columns.json").write_text(json.dumps({name: df[name].tolist() for name in df}))
    df.to_json(OUT / "pandas.json")
    df.to_json(OUT / "records.json", orient="records")


JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def bags(df):
    with open(OUT / "ros2.mcap", "wb") as file:
        writer = Writer(file)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for k in range(ROWS):
            stamp = {"sec": EPOCH, "nanosec": int(STEPS[k])}
            lists = {q: [float(df[f"{joint}.{c}"][k]) for joint in JOINTS] for q, c in [("position", "position"), ("velocity", "velocity"), ("effort", "current")]}
            at = EPOCH * 10**9 + int(STEPS[k])
            writer.write_message("/joint_states", schema, {"header": {"stamp": stamp, "frame_id": ""}, "name": JOINTS, **lists}, log_time=at, publish_time=at)
        writer.finish()
    bag = OUT / "bag"
    with Rosbag2(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        types = get_typestore(Stores.ROS2_JAZZY)
        message, stamp, header = [types.types[name] for name in ["sensor_msgs/msg/JointState", "builtin_interfaces/msg/Time", "std_msgs/msg/Header"]]
        topic = writer.add_connection("/joint_states", message.__msgtype__, typestore=types)
        for k in range(ROWS):
            lists = {q: df[[f"{joint}.{c}" for joint in JOINTS]].to_numpy()[k].copy() for q, c in [("position", "position"), ("velocity", "velocity"), ("effort", "current")]}
            state = message(header=header(stamp=stamp(sec=EPOCH, nanosec=int(STEPS[k])), frame_id=""), name=JOINTS, **lists)
            writer.write(topic, EPOCH * 10**9 + int(STEPS[k]), types.serialize_cdr(state, message.__msgtype__))
    (bag / "bag.db3").rename(OUT / "ros2.db3")
    shutil.rmtree(bag)
    with sqlite3.connect(OUT / "ros2.db3") as base:
        base.executescript("pragma page_size = 1024; vacuum")  # half the size
    base.close()


OUT.mkdir(exist_ok=True)
df = recording()
for part in [texts, times, names, parquets, arrays, bags]:
    part(df)
libraries = ["numpy", "pandas", "pyarrow", "scipy", "h5py", "mcap", "mcap-ros2-support", "rosbags"]
(OUT / "VERSIONS").write_text("".join(f"{name} {importlib.metadata.version(name)}\n" for name in libraries))
