"""The Puma's model and its table against vectors from an independent implementation, to 1e-9."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces, SpatialInertia, UnitInertia

from vipr.models import model_path
from vipr.systems.arm import puma560
from vipr.systems.errors import InputError

TOLERANCE = dict(rtol=0, atol=1e-9)
LINK_4_COM_BEYOND_WRIST = np.array([0, 0.019, 0])  # the other sign that is in use


@pytest.fixture(scope="module")
def vectors(shared_facts):
    return np.load(shared_facts / "puma560_vectors.npz")


@pytest.fixture(scope="module")
def arm():
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels(str(model_path("puma560/puma560.sdf")))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("link_0"))
    plant.Finalize()
    return plant


@pytest.fixture(params=["elbow side", "beyond the wrist"])
def variant(request, arm, vectors):
    """(context, gravity torque, M_rigid) for either side of the wrist that link 4's centre of mass is put on."""
    context = arm.CreateDefaultContext()
    if request.param == "elbow side":
        return context, vectors["gravity_torque_akbcom4"], vectors["M_rigid_akbcom4"]
    put_link_4_beyond_the_wrist(arm, context)
    return context, vectors["gravity_torque"], vectors["M_rigid"]


def put_link_4_beyond_the_wrist(arm, context):
    mass, moments = puma560.MASS[2], puma560.INERTIA[2]
    inertia = SpatialInertia.MakeFromCentralInertia(
        mass, LINK_4_COM_BEYOND_WRIST, UnitInertia(*(moments / mass)) * mass
    )
    arm.GetBodyByName("link_4").SetSpatialInertiaInBodyFrame(context, inertia)


def rows(vectors, *names):
    return zip(*(vectors[name] for name in names), strict=True)


def test_loads_without_a_warning(caplog):
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels(str(model_path("puma560/puma560.sdf")))
    plant.Finalize()
    assert not caplog.records


def test_every_link_frame_is_where_denavit_and_hartenberg_put_it(arm, vectors):
    context = arm.CreateDefaultContext()
    for q, X_0L in rows(vectors, "q", "T0_links"):
        arm.SetPositions(context, q)
        for i in range(7):
            X = arm.GetFrameByName(f"link_{i}").CalcPoseInWorld(context)
            np.testing.assert_allclose(X.GetAsMatrix4(), X_0L[i], **TOLERANCE)
        np.testing.assert_allclose(puma560.WRIST.link_poses(q), X_0L, **TOLERANCE)


def test_the_flange_lies_beyond_the_wrist(arm):
    context = arm.CreateDefaultContext()
    X_6F = arm.GetFrameByName("flange").CalcPose(context, arm.GetFrameByName("link_6"))
    assert X_6F.IsNearlyEqualTo(RigidTransform([0, 0, puma560.FLANGE]), 1e-12)


def test_jacobian_agrees_with_angular_rows_first(arm, vectors):
    context = arm.CreateDefaultContext()
    wrist, world = arm.GetFrameByName("link_6"), arm.world_frame()
    for q, J_vw in rows(vectors, "q", "J0_geometric"):
        arm.SetPositions(context, q)
        J = arm.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kQDot, wrist, [0, 0, 0], world, world)
        np.testing.assert_allclose(J, np.vstack([J_vw[3:], J_vw[:3]]), **TOLERANCE)
        np.testing.assert_allclose(puma560.WRIST.tool_pose_and_jacobian(q)[1], J, **TOLERANCE)


def test_mass_matrix_agrees_with_and_without_rotors(arm, variant, vectors):
    context, _, M_rigid = variant
    motors = np.array([M - m for M, m in rows(vectors, "M_with_motor", "M_rigid")])
    for q, M, motor in zip(vectors["q"], M_rigid, motors, strict=True):
        arm.SetPositions(context, q)
        np.testing.assert_allclose(arm.CalcMassMatrix(context), M + motor, **TOLERANCE)
        np.testing.assert_allclose(np.diag(motor), puma560.REFLECTED_INERTIA, **TOLERANCE)


def test_gravity_torque_agrees(arm, variant, vectors):
    context, gravity, _ = variant
    for q, g in zip(vectors["q"], gravity, strict=True):
        arm.SetPositions(context, q)
        np.testing.assert_allclose(-arm.CalcGravityGeneralizedForces(context), g, **TOLERANCE)


def test_coriolis_torque_agrees(arm, vectors):
    context = arm.CreateDefaultContext()
    put_link_4_beyond_the_wrist(arm, context)
    for q, qd, torque in rows(vectors, "q", "qd", "coriolis_torque"):
        arm.SetPositions(context, q)
        arm.SetVelocities(context, qd)
        np.testing.assert_allclose(arm.CalcBiasTerm(context), torque, **TOLERANCE)


def test_inverse_dynamics_agrees_with_friction(arm, vectors):
    context = arm.CreateDefaultContext()
    put_link_4_beyond_the_wrist(arm, context)
    for q, qd, qdd, with_friction, without in rows(vectors, "q", "qd", "qdd", "tau_motor_friction", "tau_motor"):
        arm.SetPositions(context, q)
        arm.SetVelocities(context, qd)
        forces = MultibodyForces(arm)
        arm.CalcForceElementsContribution(context, forces)
        torque = arm.CalcInverseDynamics(context, qdd, forces)  # gravity and viscous friction are force elements
        np.testing.assert_allclose(torque + puma560.coulomb_torque(qd), with_friction, **TOLERANCE)
        np.testing.assert_allclose(torque - puma560.DAMPING * qd, without, **TOLERANCE)


def test_friction_torque_agrees(vectors):
    for qd, torque in rows(vectors, "qd", "friction_torque"):
        np.testing.assert_allclose(puma560.friction_torque(qd), torque, **TOLERANCE)


def test_the_table_and_the_model_say_the_same(arm, vectors):
    np.testing.assert_allclose(arm.GetPositionLowerLimits(), puma560.POSITION_LOWER, **TOLERANCE)
    np.testing.assert_allclose(arm.GetPositionUpperLimits(), puma560.POSITION_UPPER, **TOLERANCE)
    np.testing.assert_allclose(vectors["qlim"].T, [puma560.POSITION_LOWER, puma560.POSITION_UPPER], **TOLERANCE)
    np.testing.assert_array_equal(arm.GetVelocityUpperLimits(), puma560.VELOCITY_LIMIT)
    np.testing.assert_array_equal(arm.GetEffortUpperLimits(), puma560.EFFORT_LIMIT)
    for i in range(6):
        actuator = arm.get_joint_actuator(arm.GetJointActuatorIndices()[i])
        assert actuator.joint().name() == f"joint_{i + 1}"
        assert actuator.default_rotor_inertia() == puma560.ROTOR_INERTIA[i]
        assert actuator.default_gear_ratio() == puma560.GEAR_RATIO[i]
        assert actuator.joint().default_damping() == puma560.DAMPING[i]
    for i in range(5):
        body = arm.GetBodyByName(f"link_{i + 2}")
        np.testing.assert_allclose(body.default_mass(), puma560.MASS[i], **TOLERANCE)


def test_the_eight_solutions_of_the_inverse_agree(vectors):
    names = [str(name) for name in vectors["ik_cfg_names"]]
    assert tuple(names) == puma560.BRANCHES
    for q, X, expected, match in rows(vectors, "q", "T06", "ik_q", "ik_match_index"):
        solutions = puma560.inverse(X)
        assert tuple(solutions) == puma560.BRANCHES
        for name, q_expected in zip(names, expected, strict=True):
            np.testing.assert_allclose(puma560.forward(solutions[name]), X, **TOLERANCE)
            if abs(np.sin(q_expected[4])) > 1e-6:  # otherwise only q4 + q6 is determined
                difference = (solutions[name] - q_expected + np.pi) % (2 * np.pi) - np.pi
                np.testing.assert_allclose(difference, 0, atol=1e-9)
        if abs(np.sin(q[4])) > 1e-6:
            difference = (solutions[names[match]] - q + np.pi) % (2 * np.pi) - np.pi
            np.testing.assert_allclose(difference, 0, atol=1e-9)


def test_the_nearest_solution_keeps_the_configuration(vectors):
    for q, X in rows(vectors, "q", "T06"):
        if abs(np.sin(q[4])) > 1e-6:
            near = q + 0.01 * np.cos(np.arange(6))
            np.testing.assert_allclose(puma560.inverse_near(X, near), q, **TOLERANCE)


def test_a_pose_out_of_reach_is_refused():
    X = puma560.forward(puma560.NAMED["stretch"])
    X[:3, 3] *= 1.01
    assert puma560.inverse(X) == {}
    with pytest.raises(InputError, match="out of reach"):
        puma560.inverse_near(X, np.zeros(6))
