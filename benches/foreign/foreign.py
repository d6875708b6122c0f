#!/usr/bin/env python3
"""Recordings of robots that others have modelled, simulated by others, and what a diagnosis says of them. See README.md.

    foreign.py list
    foreign.py make OUT --effect NAME --seed N [--robot WORD] [--strength S] [--roughness R]
    foreign.py judge SET... [--program FILE] [--guess]
"""
import argparse
import ctypes
import json
import math
import pathlib
import subprocess

import numpy as np

import motion
from effects import EFFECTS
from limb import Limb, limbs
from machine import Machine

HERE = pathlib.Path(__file__).resolve().parent
WORK = HERE.parent.parent / "target" / "foreign"
STEP = 50e-6  # [s] of arm.c
SETTLED = 2000  # [ms] before a recording begins
SMALLEST = 0.2  # [kg] of all links of a limb


def arms(word):
    """Limbs of three joints or more, whose file contains `word`, by file."""
    found = {}
    for file, names in limbs(WORK / "robots"):
        if len(names) >= 3 and word in file.stem and "collision" not in file.stem:
            found.setdefault(file.stem, []).append((file, names))
    return found


def choose(word, draw):
    """A limb that MuJoCo compiles and that is no finger."""
    files = arms(word)
    while files:
        of_file = files[draw.choice(sorted(files))]
        file, names = of_file[draw.integers(len(of_file))]
        try:
            limb = Limb(file, names)
            if limb.compiled().body_mass.sum() > SMALLEST:
                return limb
        except ValueError:
            continue
    raise SystemExit(f"no robot file contains `{word}`")


class Simulator:
    def __init__(self):
        self.library = ctypes.CDLL(str(WORK / "libarm.so"))
        self.library.fields.restype = ctypes.c_char_p
        self.fields = self.library.fields().decode().split()

    def run(self, machine, references, times, seed):
        """Positions, velocities and currents at `times`, [steps] since the references begin."""
        n = len(machine.joints)
        unknown = {name for joint in machine.joints for name in joint} - set(self.fields)
        assert not unknown, unknown
        joints = np.array([[joint.get(name, 0.0) for name in self.fields] for joint in machine.joints])
        rows = np.ascontiguousarray(np.hstack(references))
        late = np.array([round(delay / STEP) for delay in machine.late], dtype=np.int32)
        model = machine.links.compiled(machine.gravity)
        out = np.empty((len(times), 3 * n))
        pointer = lambda array: array.ctypes.data_as(ctypes.c_void_p)
        failed = self.library.simulate(
            ctypes.c_void_p(model._address), n, pointer(joints), len(rows), pointer(rows), SETTLED, len(times), pointer(times), pointer(late),
            ctypes.c_uint64(seed), pointer(out),
        )
        if failed:
            raise SystemExit("a joint runs away")
        return out


def sampled(draw, rate, uneven, milliseconds):
    """Times of samples [steps], after the machine has settled."""
    wanted = np.arange(SETTLED * 1e-3, milliseconds * 1e-3, 1 / rate)
    if uneven:
        wanted = wanted + draw.uniform(-0.3, 0.3, size=len(wanted)) / rate
    return np.round(wanted / STEP).astype(np.int64)


def make(out, effect, seed, word, strength, roughness):
    draw = np.random.default_rng(seed)
    machine = Machine(choose(word, draw), draw, roughness)
    rate, uneven, quick = math.exp(draw.uniform(math.log(100), math.log(1000))), draw.random() < 0.5, draw.random() < 0.5
    top = draw.uniform(0.8, 1.6)
    hidden = {one.__name__: one for one in EFFECTS}[effect](machine, draw, strength)
    out.mkdir(parents=True)
    machine.nominal.write(out / "robot.urdf")
    (out / "model.toml").write_text(machine.sheet_model())
    run = motion.sines if quick else motion.poses
    files = {"slow": motion.staircase(machine.low, machine.high, draw)}
    files |= {name: run(machine.low, machine.high, draw, 50, top) for name in ("fast_1", "fast_2", "held_out")}
    simulator = Simulator()
    for number, (name, (q, v)) in enumerate(files.items()):
        start = motion.hold(q[0], SETTLED * motion.PERIOD)
        references = motion.join([start, (q, v)])
        times = sampled(draw, rate, uneven, len(references[0]))
        rows = simulator.run(machine, references, times, seed * 8 + number + 1)
        write(out / f"{name}.csv", machine.names, (times - times[0]) * STEP, rows)
    joints, parameter, value = hidden or ([], None, None)
    truth = {"effect": effect, "joints": [machine.names[k] for k in joints], "parameter": parameter, "value": value}
    about = {"robot": machine.nominal.name, "names": machine.names, "rate": rate, "uneven": uneven, "sines": quick, "late": machine.late}
    (out / "truth.json").write_text(json.dumps(truth | about | {"machine": machine.joints}, default=float, indent=1))


def write(path, names, times, rows):
    columns = [f"{name}.{quantity}" for quantity in ("position", "velocity", "current") for name in names]
    np.savetxt(path, np.column_stack([times, rows]), fmt="%.8g", delimiter=",", header=",".join(["time"] + columns), comments="")


def judge(folder, program, guess):
    """Diagnoses a set; one line: right or not, the hidden effect, what was named, what stays unexplained."""
    truth, out = json.loads((folder / "truth.json").read_text()), folder / ("guess" if guess else "sheet")
    model = guessed(folder, program, truth) if guess else folder / "model.toml"
    (out / "report.json").unlink(missing_ok=True)  # that of another program
    command = [program, "diagnose", "--model", model, "--hold-out", folder / "held_out.csv", "--out", out, "--quiet", "--data"]
    done = subprocess.run(command + [folder / f"{name}.csv" for name in ("slow", "fast_1", "fast_2")], capture_output=True, text=True)
    if not (out / "report.json").exists():
        return f"ERROR   {folder.name}: exit code {done.returncode}: {done.stderr.strip()[-300:]}"
    report = json.loads((out / "report.json").read_text())
    if guess:  # recorded velocities are filtered, which a guessed model does not say
        report["effects"] = [effect for effect in report["effects"] if effect["effect"] != "velocity_lag"]
    size = "" if truth["value"] is None else f" {truth['parameter']}={truth['value']:.4g}"
    named = [told(effect, truth) for effect in report["effects"]]
    named += [f"mistake {one['mistake']} {','.join(one['joints'])}" for one in report["mistakes"]]
    odd = "; ".join(f"{one['joint']}: {one['pattern']}" for one in report["unexplained"])
    line = f"{verdict(report, truth):7} {folder.name} [{where(truth['joints'], truth)}{size}] {'; '.join(named) or 'nothing'}"
    return line + (f" | unexplained {odd}" if odd else "")


def verdict(report, truth):
    """`ok`: the hidden effect alone; `FIRST`: first, with others; `missed`: no name; `MISTAKE`: one of the data; `WRONG`: all else."""
    right = [one["effect"] == truth["effect"] and bool(set(one["joints"]) & set(truth["joints"])) for one in report["effects"]]
    if report["mistakes"]:
        return "MISTAKE"
    if not right:
        return "ok" if truth["effect"] == "none" else "missed"
    return "ok" if all(right) else "FIRST" if right[0] else "WRONG"


def told(effect, truth):
    values = [f"{name}={one['value']:.4g}±{one['std_error'] or math.nan:.2g}" for name, one in effect["parameters"].items()]
    rivals = f" (or {', '.join(effect['confusable_with'])})" if effect["confusable_with"] else ""
    return f"{effect['effect']} {where(effect['joints'], truth)} {100 * effect['probability']:.0f}% {' '.join(values)}{rivals}"


def where(joints, truth):
    return "all" if len(joints) == len(truth["machine"]) else ",".join(joints) or "-"


def guessed(folder, program, truth):
    """The first model of `lostmotion new`, with the gear ratios filled in; all else stays its guess."""
    model = folder / "guess.toml"
    if not model.exists():
        subprocess.run([program, "new", folder / "robot.urdf", "--out", model], check=True, capture_output=True)
        parts = model.read_text().split("gear_ratio = ")
        assert len(parts) == len(truth["machine"]) + 1
        rest = [part.split("\n", 1)[1] for part in parts[1:]]
        ratios = [f"gear_ratio = {joint['ratio']:.1f}\n" for joint in truth["machine"]]
        model.write_text(parts[0] + "".join(map("".join, zip(ratios, rest))))
    return model


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("list")
    of_make = commands.add_parser("make")
    of_make.add_argument("out", type=pathlib.Path)
    of_make.add_argument("--effect", choices=[one.__name__ for one in EFFECTS], required=True)
    of_make.add_argument("--seed", type=int, required=True)
    of_make.add_argument("--robot", default="")
    of_make.add_argument("--strength", type=float, default=1.0)
    of_make.add_argument("--roughness", type=float, default=1.0)
    of_judge = commands.add_parser("judge")
    of_judge.add_argument("sets", nargs="+", type=pathlib.Path)
    of_judge.add_argument("--program", default=str(HERE.parent.parent / "target" / "release" / "lostmotion"))
    of_judge.add_argument("--guess", action="store_true")
    given = parser.parse_args()
    if given.command == "list":
        for stem, found in arms("").items():
            print(stem, ", ".join(f"{names[0]} ({len(names)})" for _, names in found))
    elif given.command == "make":
        make(given.out, given.effect, given.seed, given.robot, given.strength, given.roughness)
    else:
        for folder in given.sets:
            print(judge(folder.resolve(), given.program, given.guess), flush=True)


if __name__ == "__main__":
    main()
