"""A vision chain that is slow: poses arrive a number of frames late."""

from dataclasses import dataclass

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.errors import InputError
from vipr.systems.signals import ObjectPose, Signal


@dataclass(frozen=True, eq=False)
class _Queue(Signal):
    """The poses on their way, oldest first; the oldest has arrived."""

    poses: tuple[ObjectPose, ...] = ()


class PoseDelay(LeafSystem):
    """Holds an object's pose back for ``frames`` ticks, as a slower computer would.

    .. pydrake_system::

        name: PoseDelay
        input_ports:
        - object_pose
        output_ports:
        - delayed_pose

    Both are ObjectPose. Every ``period`` the newest pose joins the queue; ``delayed_pose`` is the one that joined ``frames`` ticks ago, and
    lost until there is one. Poses keep the time of their exposure.
    """

    def __init__(self, frames: int, *, period: float = 0.04, offset: float = 0.0):
        super().__init__()
        if frames < 1:
            raise InputError(f"pose delay: frames must be 1 or more, got {frames}")
        self._frames = frames
        self._object_pose = self.DeclareAbstractInputPort("object_pose", Value(ObjectPose()))
        self._queue = self.DeclareAbstractState(Value(_Queue((ObjectPose(),) * (frames + 1))))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)
        self.DeclareAbstractOutputPort(
            "delayed_pose",
            lambda: Value(ObjectPose()),
            self._calc_delayed_pose,
            {self.abstract_state_ticket(self._queue)},
        )

    def _update(self, context, state):
        queue = context.get_abstract_state(int(self._queue)).get_value()
        poses = (*queue.poses[1:], self._object_pose.Eval(context))
        state.get_mutable_abstract_state(int(self._queue)).set_value(_Queue(poses))

    def _calc_delayed_pose(self, context, output):
        output.set_value(context.get_abstract_state(int(self._queue)).get_value().poses[0])
