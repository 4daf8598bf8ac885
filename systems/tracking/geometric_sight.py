"""Sight without pictures: what camera and tracker would report, from geometry, a lens and the tracker's measured errors.

For measurements that need thousands of runs. Frames: C camera, O object, E hand.
"""

from dataclasses import dataclass, field

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.pose.estimate import estimate_pose
from vipr.systems.signals import ObjectPose, Signal


@dataclass(frozen=True)
class SightErrors:
    """Standard deviations of a pose in C; ``*_bias`` is drawn once a run, ``*_noise`` in each frame."""

    rotation_noise: float = 0.0  # rad, each axis
    lateral_noise: float = 0.0  # m, x and y
    depth_noise: float = 0.0  # m, z
    rotation_bias: float = 0.0
    lateral_bias: float = 0.0
    depth_bias: float = 0.0

    def __post_init__(self):
        for name in self.__dataclass_fields__:
            if not 0 <= getattr(self, name) < 1:
                raise InputError(f"geometric sight: {name} must be 0 to 1, got {getattr(self, name)}")

    def draw(self, rng: np.random.Generator, kind: str) -> np.ndarray:
        """(6,) rotation vector [rad] and translation [m] of one draw of the ``noise`` or the ``bias``."""
        return rng.normal(size=6) * np.sqrt(np.diag(self.covariance(kind)))

    def covariance(self, kind: str) -> np.ndarray:
        """(6, 6)."""
        rotation, lateral, depth = (getattr(self, f"{name}_{kind}") for name in ("rotation", "lateral", "depth"))
        return np.diag(np.square([rotation, rotation, rotation, lateral, lateral, depth]))


def bias(errors: SightErrors, seed: int) -> np.ndarray:
    """(6,) the bias of all poses in a run with this seed."""
    return errors.draw(np.random.default_rng([seed, 0]), "bias")


@dataclass(frozen=True, eq=False)
class _Memory(Signal):
    """The exposure that is being worked on, and what was last made known."""

    X_CO: np.ndarray = field(default_factory=lambda: np.eye(4))
    X_CE: np.ndarray = field(default_factory=lambda: np.eye(4))
    time: float = 0.0
    number: int = -1
    object_pose: ObjectPose = ObjectPose()
    hand_pose: ObjectPose = ObjectPose()


class GeometricSight(LeafSystem):
    """Reports the poses of object and hand in the camera as a tracker would: late, with errors, and through the lens that is believed in.

    .. pydrake_system::

        name: GeometricSight
        input_ports:
        - X_CO_true
        - X_CE_true
        output_ports:
        - object_pose
        - hand_pose

    Every ``period`` an exposure is taken of the true poses (RigidTransform); ``delay`` seconds later ``object_pose`` and ``hand_pose``
    (ObjectPose) speak of it, and are held; both are lost before the first. An exposure at a time within ``blind`` (from, to) [s] shows
    nothing: both are lost. ``points`` (n, 3) [m] are the object's and ``hand_points`` the hand's (None: the hand is never seen): where
    the believed lens is not the real one, each pose is the one by which they fit the pixels best.
    """

    def __init__(
        self,
        points: np.ndarray,
        errors: SightErrors = SightErrors(),
        *,
        hand_points: np.ndarray | None = None,
        lens: Lens | None = None,
        believed: Lens | None = None,
        blind: tuple[float, float] = (np.inf, np.inf),
        seed: int = 0,
        period: float = 0.04,
        delay: float = 0.02,
    ):
        super().__init__()
        if (lens is None) != (believed is None):
            raise InputError("geometric sight: give both lenses, the real and the believed one, or neither")
        self._points, self._hand_points, self._errors = np.asarray(points, float), hand_points, errors
        self._lens, self._believed = lens, believed
        self._blind, self._seed = blind, seed
        self._bias = bias(errors, seed)
        self._covariance = errors.covariance("noise") + errors.covariance("bias")
        self._X_CO = self.DeclareAbstractInputPort("X_CO_true", Value(RigidTransform()))
        self._X_CE = self.DeclareAbstractInputPort("X_CE_true", Value(RigidTransform()))
        self._memory = self.DeclareAbstractState(Value(_Memory()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._expose)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, delay, self._report)
        ticket = {self.abstract_state_ticket(self._memory)}
        for name in ("object_pose", "hand_pose"):
            calc = getattr(self, f"_calc_{name}")
            self.DeclareAbstractOutputPort(name, lambda: Value(ObjectPose()), calc, ticket)

    def _held(self, context) -> _Memory:
        return context.get_abstract_state(int(self._memory)).get_value()

    def _expose(self, context, state):
        held = self._held(context)
        X_CO, X_CE = (port.Eval(context).GetAsMatrix4() for port in (self._X_CO, self._X_CE))
        new = _Memory(X_CO, X_CE, context.get_time(), held.number + 1, held.object_pose, held.hand_pose)
        state.get_mutable_abstract_state(int(self._memory)).set_value(new)

    def _report(self, context, state):
        held = self._held(context)
        rng = np.random.default_rng([self._seed, held.number + 1])
        seen = [self._seen(X, p, held, rng) for X, p in ((held.X_CO, self._points), (held.X_CE, self._hand_points))]
        new = _Memory(held.X_CO, held.X_CE, held.time, held.number, *seen)
        state.get_mutable_abstract_state(int(self._memory)).set_value(new)

    def _seen(self, X_true: np.ndarray, points, held: _Memory, rng: np.random.Generator) -> ObjectPose:
        if points is None or self._blind[0] <= held.time < self._blind[1]:
            return ObjectPose(time=held.time, number=held.number)
        X = X_true if self._lens is None else self._through_lenses(X_true, points)
        error = self._bias + self._errors.draw(rng, "noise")
        X = se3.pose(se3.exp_so3(error[:3]) @ X[:3, :3], X[:3, 3] + error[3:])
        return ObjectPose(X, covariance=self._covariance, state="tracking", time=held.time, number=held.number)

    def _through_lenses(self, X: np.ndarray, points: np.ndarray) -> np.ndarray:
        pixels = self._lens.project(points @ X[:3, :3].T + X[:3, 3])
        start = se3.pose(X[:3, :3], X[:3, 3] * [1.0, 1.0, self._believed.fx / self._lens.fx])
        return estimate_pose(points, pixels, self._believed, robust=False, X_CO_start=start).X_CO

    def _calc_object_pose(self, context, output):
        output.set_value(self._held(context).object_pose)

    def _calc_hand_pose(self, context, output):
        output.set_value(self._held(context).hand_pose)
