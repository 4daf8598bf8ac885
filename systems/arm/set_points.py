"""From the set-points of the arm's controller to the reference of its joint servo: smooth in between, with its acceleration."""

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.errors import InputError


class SetPointInterpolator(LeafSystem):
    """Set-points that come in steps, made a motion whose rates change without a jump.

    .. pydrake_system::

        name: SetPointInterpolator
        input_ports:
        - set_points
        output_ports:
        - desired_state
        - desired_acceleration

    ``set_points`` (2n) is [q; qdot] of n joints [rad, rad/s], new every ``period`` [s], q to be reached at qdot when the next ones
    come. ``desired_state`` (2n) and ``desired_acceleration`` (n) [rad/s^2] are the motion through them, in so many ``steps`` a period:
    the rates are the mean of the set-points' over one period, the angles are the mean twice over, so that they are the integral of the
    rates. A motion that ends, ends one period after the set-points do, exactly at the last. The outputs depend on the set-points of
    now; those before are held, and were ``q_initial`` (n) [rad] at rest.
    """

    def __init__(self, q_initial: np.ndarray, period: float = 0.01, steps: int = 5):
        super().__init__()
        if not (period > 0 and steps >= 1):
            raise InputError(f"set-points: need a period above 0 s and a step or more, got {period:g} s and {steps}")
        self._count, self._period, self._n = steps, period, len(q_initial)
        box = np.full(self._count, 1.0 / self._count)
        self._twice = np.convolve(box, box)  # weights of the set-points, newest first
        start = np.concatenate([q_initial, np.zeros(self._n)])
        self._in = self.DeclareVectorInputPort("set_points", 2 * self._n)
        before = self.DeclareDiscreteState(np.tile(start, len(self._twice) - 1 or 1))
        self.DeclarePeriodicDiscreteUpdateEvent(period / steps, 0.0, self._update)
        needed = {self._in.ticket(), self.discrete_state_ticket(before)}
        self.DeclareVectorOutputPort("desired_state", BasicVector(2 * self._n), self._calc_state, needed)
        self.DeclareVectorOutputPort("desired_acceleration", BasicVector(self._n), self._calc_acceleration, needed)

    def _known(self, context) -> np.ndarray:
        """The set-points (m, 2n) of now and of the periods before, newest first."""
        before = context.get_discrete_state_vector().CopyToVector()
        return np.concatenate([self._in.Eval(context), before]).reshape(-1, 2 * self._n)

    def _update(self, context, discrete_state):
        discrete_state.set_value(self._known(context)[:-1].ravel())

    def _calc_state(self, context, output):
        known = self._known(context)
        q = self._twice @ known[: len(self._twice), : self._n]
        output.set_value(np.concatenate([q, known[: self._count, self._n :].mean(axis=0)]))

    def _calc_acceleration(self, context, output):
        rates = self._known(context)[:, self._n :]
        output.set_value((rates[0] - rates[self._count]) / self._period)
