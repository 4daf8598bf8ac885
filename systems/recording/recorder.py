"""The end of every wire that a run records."""

from collections.abc import Callable, Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem

from vipr.systems.recording.channels import (
    Channel,
    ImageChannel,
    JointChannel,
    PoseChannel,
    StatusChannel,
    VectorChannel,
    check_channels,
)
from vipr.systems.signals import CameraFrame, ObjectPose, Status
from vipr.systems.timing import LEDGER

MODELS = {ImageChannel: CameraFrame, StatusChannel: Status}  # types on the ports of these channels


class Recorder(LeafSystem):
    """Hands what its channels carry to a run's folder, once a tick.

    .. pydrake_system::

        name: Recorder
        input_ports:
        - camera
        - X_CO
        - X_CO_true
        - servo_error
        - q
        - phase
        output_ports: []

    There is one input port a channel, in their order and of their names; above are those of an example that has one of each kind: an
    image (CameraFrame), a tracked pose (ObjectPose), a pose (RigidTransform), numbers, joints (vectors) and a status (Status). Frames
    and units are the channels'. At ``offset`` and every ``period`` after it, all ports are read at one instant (a publish event,
    which sees the state before the updates of that instant) and given to ``record(time, values)``, such as `RunFolder.record`, which
    is an output device: nothing comes back, nothing is held. Ports may stay unconnected; they are left out.
    """

    def __init__(
        self,
        channels: Sequence[Channel],
        record: Callable[[float, dict], None],
        *,
        period: float = 0.04,
        offset: float = 0.0,
    ):
        super().__init__()
        self._record = record
        self._ports = [(channel, self._declare(channel)) for channel in check_channels(channels)]
        self.DeclarePeriodicPublishEvent(period, offset, self._publish)

    def _declare(self, channel: Channel):
        if isinstance(channel, VectorChannel | JointChannel):
            return self.DeclareVectorInputPort(channel.name, channel.size)
        if isinstance(channel, PoseChannel):
            model = ObjectPose() if channel.tracked else RigidTransform()
        else:
            model = MODELS[type(channel)]()
        return self.DeclareAbstractInputPort(channel.name, Value(model))

    def _publish(self, context):
        values = {c.name: port.Eval(context) for c, port in self._ports if port.HasValue(context)}  # others' work
        with LEDGER.charge("logging"):
            self._record(context.get_time(), {name: _kept(value) for name, value in values.items()})


def _kept(value):
    """The value as something that no one changes later: signals are, Drake's views are copied."""
    if isinstance(value, RigidTransform):
        return value.GetAsMatrix4()
    return np.array(value) if isinstance(value, np.ndarray) else value
