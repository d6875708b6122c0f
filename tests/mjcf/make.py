"""Mass matrices and weights of the models in this folder as MuJoCo computes them: python make.py > mujoco.json (pip install mujoco numpy).

Postures are drawn with a fixed seed. Joints that lostmotion holds (mimics, ball and free joints) stay where it holds them: a mimic where its
equality puts it with the other joint at zero, the others at their reference. Rows and columns are those of the other joints, in their order.
"""
import json
import pathlib

import mujoco
import numpy as np

HELD = {"arm.xml": {"thumb": 0.002}, "frames.xml": {}}
folder = pathlib.Path(__file__).parent
out = {"mujoco": mujoco.__version__, "models": {}}
for name, held in HELD.items():
    model = mujoco.MjModel.from_xml_path(str(folder / name))
    data = mujoco.MjData(model)
    turning = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    joints = [j for j in range(model.njnt) if int(model.jnt_type[j]) in turning and model.joint(j).name not in held]
    dofs = [model.jnt_dofadr[j] for j in joints]
    draw = np.random.default_rng(1)
    postures = []
    for _ in range(5):
        mujoco.mj_resetData(model, data)
        for joint, position in held.items():
            data.qpos[model.joint(joint).qposadr[0]] = position
        q = []
        for j in joints:
            low, high = model.jnt_range[j] if model.jnt_limited[j] else (-np.pi, np.pi)
            q.append(draw.uniform(low, high))
            data.qpos[model.jnt_qposadr[j]] = q[-1]
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        postures.append({"q": q, "mass": mass[np.ix_(dofs, dofs)].tolist(), "weight": data.qfrc_bias[dofs].tolist()})
    out["models"][name] = {
        "joints": [model.joint(j).name for j in joints],
        "armature": [float(model.dof_armature[d]) for d in dofs],
        "damping": [float(np.ravel(model.dof_damping[d])[0]) for d in dofs],
        "friction": [float(model.dof_frictionloss[d]) for d in dofs],
        "postures": postures,
    }
print(json.dumps(out))
