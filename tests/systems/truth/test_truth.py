"""Truth and errors, against poses known in advance."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vipr.systems.truth import AlignmentError, PoseTruth, TrackingError

from examples import EXAMPLES


def test_truth_is_the_plants_pose_in_each_frame():
    dut, fix = EXAMPLES[PoseTruth]()
    context = dut.CreateDefaultContext()
    fix(context, 0.5)
    X_WO, X_CO = (dut.GetOutputPort(name).Eval(context).GetAsMatrix4() for name in ("X_WO_true", "X_CO_true"))
    X_WC = X_WO @ np.linalg.inv(X_CO)
    fix(context, 3.0)
    assert np.allclose(X_WC, dut.GetOutputPort("X_WO_true").Eval(context).GetAsMatrix4())


def test_tracking_error_compares_with_the_truth_at_the_exposure():
    dut, fix = EXAMPLES[TrackingError]()
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix(context, 0.0)
    simulator.AdvanceTo(0.02)
    assert np.isnan(dut.get_output_port().Eval(context)).all()
    fix(context, 0.2)  # an estimate, of an exposure at 0.0 s by its own time stamp
    simulator.AdvanceTo(0.039)
    simulator.AdvancePendingEvents()
    assert np.isfinite(dut.get_output_port().Eval(context)).all()


def test_alignment_error_is_zero_at_the_goal():
    dut = AlignmentError(np.eye(4))
    context = dut.CreateDefaultContext()
    for name in ("X_WO_true", "X_WE_true"):
        dut.GetInputPort(name).FixValue(context, Value(RigidTransform([0.3, 0, 0])))
    assert np.allclose(dut.get_output_port().Eval(context), 0)
    dut.GetInputPort("X_WE_true").FixValue(context, Value(RigidTransform([0.1, 0, 0])))
    assert np.allclose(dut.get_output_port().Eval(context), [0, 0, 0, 0.2, 0, 0])
