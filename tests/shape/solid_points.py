"""Points on the surface of a model's geoms, by the simulator's own kinematics."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from fairlead.messages import FloatArray
from fairlead.robot.capsules import Capsule
from fairlead.robot.manifest import RobotManifest

COUNT = 60


def surface(model: mujoco.MjModel, geom: int, rng: np.random.Generator) -> FloatArray:
    """Points of a geom in its own frame: all vertices of a mesh, random ones of other shapes."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    turn = rng.uniform(0.0, 2.0 * np.pi, COUNT)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(COUNT)], axis=1)
    balls = rng.normal(size=(COUNT, 3))
    balls /= np.linalg.norm(balls, axis=1, keepdims=True)
    ends = np.outer(rng.choice([-1.0, 1.0], COUNT), [0.0, 0.0, size[1]])
    shapes = mujoco.mjtGeom
    if kind == shapes.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        return np.array(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], dtype=float)
    if kind == shapes.mjGEOM_BOX:
        return np.asarray(rng.choice([-1.0, 1.0], (COUNT, 3)) * size)
    if kind == shapes.mjGEOM_CYLINDER:
        return np.asarray(ring * size[0] + ends)
    assert kind == shapes.mjGEOM_CAPSULE
    return np.asarray(balls * size[0] + ends)


def farthest_out(
    robot: RobotManifest,
    model: mujoco.MjModel,
    capsules: list[Capsule],
    samples: int,
) -> float:
    """How far the worst point of the robot is out of all its capsules [m], over random poses.

    The capsules are where the gate puts them: of a finger that opens, it knows the last state only.
    """
    kinematics = pin.buildModelFromUrdf(str(robot.description_path()))
    posed, data, rng = kinematics.createData(), mujoco.MjData(model), np.random.default_rng(11)
    assert robot.simulator is not None
    root = model.body(robot.simulator.base_body).id
    worst = -np.inf
    for _ in range(samples):
        q = _random_pose(robot, model, data, kinematics, rng)
        mujoco.mj_kinematics(model, data)
        pin.framesForwardKinematics(kinematics, posed, q)
        points = []
        for geom in range(model.ngeom):
            if _carried(model, int(model.geom_bodyid[geom]), root) and (
                model.geom_contype[geom] | model.geom_conaffinity[geom]
            ):
                matrix = data.geom_xmat[geom].reshape(3, 3)
                points.append(surface(model, geom, rng) @ matrix.T + data.geom_xpos[geom])
        in_root = (np.concatenate(points) - data.xpos[root]) @ data.xmat[root].reshape(3, 3)
        worst = max(
            worst,
            float(np.min([_out(in_root, c, kinematics, posed) for c in capsules], axis=0).max()),
        )
    return worst


def _random_pose(
    robot: RobotManifest,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    kinematics: pin.Model,
    rng: np.random.Generator,
) -> FloatArray:
    """The same random joint positions in both models, but for fingers, which are on their way."""
    assert robot.simulator is not None
    q: FloatArray = pin.neutral(kinematics)
    for joint in (*robot.joints, *robot.passive_joints):
        sources = robot.simulator.joints[joint.name]
        if len(sources) == 1 and kinematics.existJointName(joint.name):
            low, high = (joint.lower, joint.upper) if joint.has_bounds else (-np.pi, np.pi)
            value = rng.uniform(low, high)
            data.qpos[model.jnt_qposadr[model.joint(sources[0]).id]] = value
            if joint.role == "gripper":
                value = rng.uniform(low, high)
            place = kinematics.joints[kinematics.getJointId(joint.name)]
            told = [value] if place.nq == 1 else [np.cos(value), np.sin(value)]
            q[place.idx_q : place.idx_q + place.nq] = told
    for tie in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
        follower, leader = model.jnt_qposadr[[model.eq_obj1id[tie], model.eq_obj2id[tie]]]
        data.qpos[follower] = np.polyval(model.eq_data[tie][4::-1], data.qpos[leader])
    return q


def _carried(model: mujoco.MjModel, body: int, root: int) -> bool:
    while body not in (0, root):
        body = int(model.body_parentid[body])
    return body == root


def _out(
    points: FloatArray, capsule: Capsule, kinematics: pin.Model, posed: pin.Data
) -> FloatArray:
    """How far each point is out of one capsule [m]."""
    pose = posed.oMf[kinematics.getFrameId(capsule.link, pin.FrameType.BODY)]
    a, b = (pose.act(np.array(end)) for end in (capsule.a_m, capsule.b_m))
    along, rays = b - a, points - a
    share = rays @ along / max(float(along @ along), 1e-12)
    foot = a + np.clip(share, 0.0, 1.0)[:, None] * along
    return np.asarray(np.linalg.norm(points - foot, axis=1) - capsule.radius_m)
