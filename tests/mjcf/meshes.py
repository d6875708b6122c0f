"""The meshes of tests/mjcf/meshes.xml, and their masses as MuJoCo computes them, in every format and mode:

    python meshes.py > meshes.json (pip install mujoco numpy)

The solid is an L, which is not convex, so that the modes differ.
"""
import json
import pathlib
import struct

import mujoco
import numpy as np

folder = pathlib.Path(__file__).parent / "meshes"
folder.mkdir(exist_ok=True)
corners = [(0, 0), (0.2, 0), (0.2, 0.1), (0.1, 0.1), (0.1, 0.3), (0, 0.3)]
points = [(x, y, z) for z in (0, 0.1) for x, y in corners]
faces = [part for a, b, c in [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)] for part in [(a, c, b), (a + 6, b + 6, c + 6)]]
faces += [part for i, j in [(i, (i + 1) % 6) for i in range(6)] for part in [(i, j, j + 6), (i, j + 6, i + 6)]]

triangles = np.array([[points[k] for k in face] for face in faces], "<f4")
with open(folder / "l.stl", "wb") as file:
    file.write(b"an L".ljust(80) + struct.pack("<I", len(triangles)))
    for triangle in triangles:
        file.write(struct.pack("<3f", 0, 0, 0) + triangle.tobytes() + b"\0\0")
with open(folder / "l.msh", "wb") as file:
    file.write(struct.pack("<4i", len(points), 0, 0, len(faces)))
    file.write(np.array(points, "<f4").tobytes() + np.array(faces, "<i4").tobytes())
lines = ["v %g %g %g" % point for point in points]
# The ends of the L as polygons would be split in another way where they are not convex; the sides are rectangles, whose points count from the last one.
lines += ["vn 0 0 1"] + ["f %d//1 %d//1 %d//1" % tuple(k + 1 for k in face) for face in faces[:8]]
lines += ["f %d//1 %d//1 %d//1 %d//1" % (i - 12, (i + 1) % 6 - 12, (i + 1) % 6 - 6, i - 6) for i in range(6)]
(folder / "l.obj").write_text("\n".join(lines) + "\n")

model = mujoco.MjModel.from_xml_path(str(folder.parent / "meshes.xml"))
out = {}
for body in range(1, model.nbody):
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    turn = turn.reshape(3, 3)
    out[model.body(body).name] = {
        "mass": float(model.body_mass[body]),
        "com": model.body_ipos[body].tolist(),
        "tensor": (turn @ np.diag(model.body_inertia[body]) @ turn.T).tolist(),
    }
print(json.dumps({"mujoco": mujoco.__version__, "bodies": out}))
