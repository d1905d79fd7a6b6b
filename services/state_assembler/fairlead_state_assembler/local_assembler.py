"""The same state vectors in one process: for notebooks, parity runs and verification."""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.hal.backend import FramePose
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.state_contract import StateContract
from fairlead_state_assembler.forward_kinematics import ForwardKinematics
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_decoding import pose_from
from fairlead_state_assembler.registry import assemble_contract
from fairlead_state_assembler.transform_buffer import TransformBuffer
from fairlead_state_assembler.transforms_at_tick import TransformsAtTick


class LocalAssembler:
    """Layouts straight from a backend's readings, bit for bit as the service computes them.

    Example::

        assembler = LocalAssembler(robot)
        assembler.take(
            backend.read().positions, backend.transforms(), backend.static_transforms()
        )
        values = assembler.assemble(skill.state_contract)
    """

    def __init__(self, robot: RobotManifest) -> None:
        self._names = robot.measured_joint_names
        self._kinematics = ForwardKinematics(robot)
        self._joints: JointPositions | None = None
        self._buffer = TransformBuffer()
        self._transforms: TransformsAtTick | None = None

    @property
    def frames(self) -> frozenset[str]:
        """Every frame known from what was taken last."""
        return self._buffer.frames

    def take(
        self,
        positions: FloatArray,
        transforms: Sequence[FramePose],
        static_transforms: Sequence[FramePose],
        velocities: FloatArray | None = None,
    ) -> None:
        """Take everything measured at one moment; what was taken before is forgotten.

        Args:
            positions: shape ``[n]``, every measured joint in wire order [rad or m].
            velocities: likewise [rad/s or m/s], for vectors that have some.
        """
        self._buffer = buffer = TransformBuffer()
        for poses, is_static in ((static_transforms, True), (transforms, False)):
            for item in poses:
                pose = pose_from(item.child, item.translation, item.rotation_xyzw)
                buffer.add(item.parent, item.child, pose, 1, is_static=is_static)
        base = self._kinematics.base_frame
        buffer.add_links(base, self._kinematics.frames, self._kinematics.poses(positions), 1)
        self._joints = JointPositions.named(self._names, positions, velocities)
        self._transforms = buffer.at(1)

    def assemble(self, contract: StateContract) -> FloatArray:
        """The state vector of ``contract`` for what was taken last; float64 ``[dim]``.

        Raises:
            LayoutError: naming the frame or joint that is missing.
        """
        if self._joints is None or self._transforms is None:
            raise RuntimeError("assemble() needs a take() before it")
        return assemble_contract(contract, self._joints, self._transforms)
