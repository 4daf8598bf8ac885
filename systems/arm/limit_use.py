"""How much of an arm's limits its set-points use: a witness beside the loop."""

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.arm.resolved_rate import JointLimits


class LimitUse(LeafSystem):
    """Keeps the largest share of each limit that the set-points have used so far.

    .. pydrake_system::

        name: LimitUse
        input_ports:
        - desired_state
        output_ports:
        - limit_use

    ``desired_state`` (2n) is [q; qdot] for the joint servo [rad, rad/s], looked at every ``period``, which must be that of the set-points.
    ``limit_use`` (3) is the worst joint's share of its range of positions (0 in the middle, 1 at a stop), of its speed and of its
    acceleration: above 1 a limit was broken. Zero before the first look; the first tells no acceleration.
    """

    def __init__(self, limits: JointLimits, *, period: float = 0.01, offset: float = 0.0):
        super().__init__()
        self._limits, self._period, self._n = limits, period, len(limits.lower)
        self._desired = self.DeclareVectorInputPort("desired_state", 2 * self._n)
        worst = self.DeclareDiscreteState(3)
        before = self.DeclareDiscreteState(np.full(self._n, np.nan))  # rad/s
        self._worst, self._before = worst, before
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)
        self.DeclareVectorOutputPort(
            "limit_use", BasicVector(3), self._calc_limit_use, {self.discrete_state_ticket(worst)}
        )

    def _update(self, context, discrete_state):
        q, rates = np.split(self._desired.Eval(context), 2)
        before = context.get_discrete_state(self._before).CopyToVector()
        worst = context.get_discrete_state(self._worst).CopyToVector()
        use = limit_use(q, rates, rates if np.isnan(before).any() else before, self._limits, self._period)
        discrete_state.set_value(self._worst, np.maximum(worst, use))
        discrete_state.set_value(self._before, rates)

    def _calc_limit_use(self, context, output):
        output.set_value(context.get_discrete_state(self._worst).CopyToVector())


def limit_use(q: np.ndarray, rates: np.ndarray, before: np.ndarray, limits: JointLimits, dt: float) -> np.ndarray:
    """(3,) shares of position, speed and acceleration limits that set-points q [rad], rates and rates before [rad/s] use."""
    middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * (limits.upper - limits.lower)
    return np.array(
        [
            np.max(np.abs(q - middle) / half),
            np.max(np.abs(rates) / limits.speed),
            np.max(np.abs(rates - before) / (limits.acceleration * dt)),
        ]
    )
