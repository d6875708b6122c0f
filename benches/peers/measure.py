"""Runs both sides in turn on one core, prints all settings and the tables that the READMEs quote; with --write, quotes them."""

import argparse
import datetime
import math
import os
import platform
import re
import shutil
import statistics
import subprocess
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROUNDS = 3
SECONDS = 4.0  # of a motion
MOTIONS = ("fast", "slow")

# MuJoCo's settings: gear/friction/integrator, steps a millisecond, motions. mujoco.c says what the words mean.
SETTINGS = [
    # What its model elements offer.
    ("tendon/loss/implicitfast", (1, 10, 100), MOTIONS),
    ("tendon/lugre/implicitfast", (10, 100), MOTIONS),
    # The gear's torque put right; friction in all ways.
    ("law/loss/implicitfast", (1, 10, 100), MOTIONS),
    ("law/lugre/implicitfast", (10, 100), MOTIONS),
    ("law/lugre_1e5/explicit", (10, 100), MOTIONS),
    ("law/lugre_1e6/explicit", (10, 100), MOTIONS),
    ("law/stribeck/Euler", (1, 10, 100), MOTIONS),
    ("law/stribeck/explicit", (1, 2, 5, 10, 30, 100), MOTIONS),
    ("law/stribeck/implicitfast", (10,), MOTIONS),
    ("law/stribeck/implicit", (10,), MOTIONS),
    ("law/stribeck/discrete", (1, 10), MOTIONS),
    ("law/stribeck/RK4", (1, 10, 50), MOTIONS),
    ("law/linear/explicit", (1, 2, 5, 10, 30, 100), MOTIONS),
    ("law/linear/RK4", (1, 10, 50), MOTIONS),
]
# Long ones, once.
LONG = [
    ("law/stribeck/explicit", (1000,), MOTIONS),
    ("law/linear/explicit", (1000,), ("fast",)),
    ("law/stribeck/RK4", (200,), MOTIONS),
]
# Largest errors [degrees] at which speeds are compared.
LEVELS = (1e-2, 1e-3, 1e-4)


def on_core(core, command):
    """What a command prints, run on one core."""
    words = ["taskset", "-c", str(core), *map(str, command)]
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def collect(arguments):
    """Rows (program, setting), steps, motion -> (error [deg], times [s]); both sides in turn, round after round."""
    rows = {}

    def take(text):
        for line in text.splitlines():
            program, setting, steps, motion, error, *times = line.split()
            row = rows.setdefault(((program, setting), int(steps), motion), [math.degrees(float(error)), []])
            row[1] += map(float, times)

    def mujoco(settings, runs):
        for setting, steps, motions in settings:
            for n in steps:
                for motion in motions:
                    command = [arguments.out / "mujoco", HERE / "arm.xml", arguments.out, motion, *setting.split("/"), n]
                    take(on_core(arguments.core, [*command, runs if n <= 10 else 1]))

    ours = [arguments.programs / "examples/peers", "run", arguments.out]
    for _ in range(ROUNDS):
        take(on_core(arguments.core, ours))
        mujoco(SETTINGS, 3)
    take(on_core(arguments.core, ours))
    mujoco(LONG, 1)
    take(on_core(arguments.core, ours))
    return rows


def speed(times):
    """Times real time, from the median."""
    return SECONDS / statistics.median(times)


def best(rows, of, motion, level):
    """Fastest way to an error of at most `level`, and its name. MuJoCo's settings are interpolated between numbers of steps."""
    found = (0.0, "")
    for name in sorted({key[0] for key in rows if of(key[0])}):
        points = sorted((steps, *row) for (who, steps, m), row in rows.items() if who == name and m == motion)
        points = [(steps, error, speed(times)) for steps, error, times in points]
        for i, (steps, error, fast) in enumerate(points):
            if error > level:
                continue
            if i > 0 and name[0] == "mujoco":
                before = points[i - 1]
                share = math.log(level / error) / math.log(before[1] / error)
                fast *= (before[2] / fast) ** share
            found = max(found, (fast, name[1]))
            break
    return found


def number(x):
    return f"{x:.0f}" if x >= 10 else f"{x:.1f}" if x >= 1 else f"{x:.2g}"


def all_settings(rows):
    lines = [
        "| program, setting | steps a ms | error fast [deg] | slow [deg] | × real time fast: median (range) | slow | million steps/s |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, steps in sorted({key[:2] for key in rows}):
        cells, rate = [[], []], []
        for motion in MOTIONS:
            error, times = rows.get((name, steps, motion), (None, []))
            cells[0].append("–" if error is None else "unstable" if math.isinf(error) else f"{error:.1e}")
            range_ = f" ({number(SECONDS / max(times))} … {number(SECONDS / min(times))})" if times else ""
            cells[1].append(number(speed(times)) + range_ if times else "–")
            rate += [1e-3 * steps * speed(times)] if times else []
        lines.append(f"| {' '.join(name)} | {steps} | {' | '.join(cells[0] + cells[1])} | {max(rate):.2g} |")
    return "\n".join(lines)


def at_equal_error(rows, names):
    """The fastest way to an error; `names` tells which of MuJoCo's settings it was."""
    ways = [
        lambda name: name in {("lostmotion", "rapier/sensors"), ("lostmotion", "rapier-coarse/sensors")},
        lambda name: name in {("lostmotion", "rapier-each-ms/sensors"), ("lostmotion", "rapier-each-ms-coarse/sensors")},
        lambda name: name in {("lostmotion", "reduced/sensors"), ("lostmotion", "reduced-coarse/sensors")},
        lambda name: name[0] == "mujoco",
    ]
    lines = ["| motion | error [deg] | on rapier | rapier asked every ms | reduced engine | MuJoCo | rapier, reduced : MuJoCo |", "|---|---|---|---|---|---|---|"]
    for motion in MOTIONS:
        for level in LEVELS:
            rapier, each, reduced, peer = (best(rows, of, motion, level) for of in ways)
            cells = [number(fast) if fast else "not reached" for fast, _ in (rapier, each, reduced, peer)]
            if names:
                cells[3] += f" ({peer[1]})"
            ratios = ", ".join(number(own[0] / peer[0]) for own in (rapier, reduced)) if peer[0] else "–"
            lines.append(f"| {motion} | {level:g} | {' | '.join(cells)} | {ratios} |")
    return "\n".join(lines)


def process(command):
    """Wall time, CPU time [s] and peak memory [MB] of a process."""
    start = time.perf_counter()
    child = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.perf_counter() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    return child.returncode, wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def whole_processes(arguments):
    lines = ["| whole process | wall, best of 3 [s] | CPU [s] | peak memory [MB] |", "|---|---|---|---|"]
    folder = arguments.out / "identify"
    for engine in ("rapier", "reduced"):
        runs = []
        for _ in range(ROUNDS):
            shutil.rmtree(folder, ignore_errors=True)
            program = [arguments.programs / "lostmotion", "run", "01_identify_scara", "--quiet"]
            code, *figures = process([*program, "--set", f"plant.engine={engine}", "--out", folder])
            if code not in (0, 3):  # 3: done, with warnings
                raise SystemExit(f"lostmotion run 01_identify_scara ended with {code}")
            runs.append(figures)
        wall, cpu, memory = (min(column) for column in zip(*runs))
        lines.append(f"| `lostmotion run 01_identify_scara`, {engine}, `trace.rrd` included | {wall:.2f} | {cpu:.2f} | {memory:.0f} |")
    batch = [arguments.programs / "examples/peers", "batch", arguments.out]
    walls = {1: [], 2: []}
    for _ in range(ROUNDS):
        for threads, found in walls.items():
            found.append(float(subprocess.run([*batch, str(threads)], check=True, capture_output=True, text=True).stdout))
    one, two = min(walls[1]), min(walls[2])
    return "\n".join(lines) + f"\n\nA batch of 32 runs on rapier: {one:.2f} s on one core, {two:.2f} s on two ({one / two:.2f} times as fast)."


def machine():
    text = Path("/proc/cpuinfo").read_text()
    model = re.search(r"model name\s*: (.*)", text)
    return f"{model.group(1) if model else platform.machine()}, {os.cpu_count()} cores"


def versions(mujoco):
    rapier = re.search(r'rapier3d-f64 = "=([\d.]+)"', (HERE.parents[1] / "Cargo.toml").read_text()).group(1)
    rust = subprocess.run(["rustc", "--version"], check=True, capture_output=True, text=True).stdout.split()[1]
    return f"MuJoCo {mujoco}, rapier {rapier}, Rust {rust}"


def quote(path, text):
    """Puts tables between the marks of a README."""
    begin, end = "<!-- measured by benches/peers/run -->", "<!-- end of measured -->"
    before, rest = path.read_text().split(begin)
    path.write_text(f"{before}{begin}\n{text}\n{end}{rest.split(end)[1]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mujoco", required=True, help="version")
    parser.add_argument("--core", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--programs", type=Path, required=True)
    parser.add_argument("--write", action="store_true", help="quote the tables in the READMEs")
    arguments = parser.parse_args()
    load = os.getloadavg()[0]
    busy = "; a busy machine: wall times are too long" if load > 0.7 * os.cpu_count() else ""
    rows = collect(arguments)
    head = f"{datetime.date.today()}, {machine()} (virtual, load {load:.1f} at the start{busy}), {versions(arguments.mujoco)}."
    tables = {
        HERE.parents[1] / "README.md": "\n\n".join([head, at_equal_error(rows, names=False), whole_processes(arguments)]),
        HERE / "README.md": "\n\n".join([head, at_equal_error(rows, names=True), all_settings(rows)]),
    }
    for path, text in tables.items():
        print(text, end="\n\n")
        if arguments.write:
            quote(path, text)


if __name__ == "__main__":
    main()
