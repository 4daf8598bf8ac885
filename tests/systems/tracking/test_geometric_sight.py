"""Sight without pictures: late, with the errors asked for, blind when told, and wrong as a wrong lens makes it."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.geometric_sight import GeometricSight, SightErrors, bias

LENS = Lens(640, 480, 1950.0, 1950.0, 319.5, 239.5)
BOX = np.array([[x, y, z] for x in (-0.04, 0.04) for y in (-0.04, 0.04) for z in (0.0, 0.2)])
X_CO = se3.pose(se3.exp_so3(np.array([1.9, 0.2, 0.1])), [0.02, 0.05, 2.0])


def watch(dut, times):
    """Object poses that are out at the given times, the object standing at X_CO."""
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    for name in ("X_CO_true", "X_CE_true"):
        dut.GetInputPort(name).FixValue(context, Value(RigidTransform(X_CO)))
    for t in times:
        simulator.AdvanceTo(t)
        yield dut.GetOutputPort("object_pose").Eval(context)


def test_a_pose_comes_late_and_is_held():
    early, first, held = watch(GeometricSight(BOX), (0.015, 0.025, 0.055))
    assert early.state == "lost" and first.state == "tracking"
    assert first.time == 0.0 and first.number == 0 and held is first
    assert np.allclose(first.X_CO, X_CO)


def test_the_hand_is_seen_only_if_it_has_points():
    for points, state in ((None, "lost"), (BOX, "tracking")):
        dut = GeometricSight(BOX, hand_points=points)
        simulator = Simulator(dut)
        context = simulator.get_mutable_context()
        for name in ("X_CO_true", "X_CE_true"):
            dut.GetInputPort(name).FixValue(context, Value(RigidTransform(X_CO)))
        simulator.AdvanceTo(0.03)
        assert dut.GetOutputPort("hand_pose").Eval(context).state == state


def test_errors_are_as_large_as_asked_for():
    errors = SightErrors(rotation_noise=1e-3, lateral_noise=1e-4, depth_noise=5e-4, depth_bias=2e-3)
    poses = list(watch(GeometricSight(BOX, errors, seed=5), 0.04 * np.arange(400) + 0.03))
    seen = np.array([se3.difference(X_CO, pose.X_CO) for pose in poses])
    assert np.allclose(seen.std(0), [1e-3] * 3 + [1e-4, 1e-4, 5e-4], rtol=0.15)
    assert np.allclose(seen.mean(0), bias(errors, 5), atol=2e-4) and abs(bias(errors, 5)[5]) > 1e-4


def test_nothing_is_seen_while_blind():
    states = [pose.state for pose in watch(GeometricSight(BOX, blind=(0.04, 0.1)), (0.03, 0.07, 0.11, 0.15))]
    assert states == ["tracking", "lost", "lost", "tracking"]


def test_a_lens_believed_too_long_sees_the_object_too_far_away():
    longer = replace(LENS, fx=1.1 * LENS.fx, fy=1.1 * LENS.fy)
    (pose,) = watch(GeometricSight(BOX, lens=LENS, believed=longer), (0.03,))
    assert pose.X_CO[2, 3] == pytest.approx(2.2, abs=0.02)
    pixels, fitted = (lens.project(BOX @ X[:3, :3].T + X[:3, 3]) for lens, X in ((LENS, X_CO), (longer, pose.X_CO)))
    assert np.abs(pixels - fitted).max() < 1.0


def test_bad_settings_are_refused():
    with pytest.raises(InputError, match=r"depth_noise must be 0 to 1, got -1"):
        SightErrors(depth_noise=-1)
    with pytest.raises(InputError, match="give both lenses"):
        GeometricSight(BOX, lens=LENS)
