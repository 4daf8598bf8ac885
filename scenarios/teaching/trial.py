"""One try of a grasp on the bench: close, lift, shake, hold, and what came of it."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.analysis import Simulator

from vipr.diagrams.hand_bench import HandBench, HandBenchConfig
from vipr.systems import se3
from vipr.systems.grasping.grasp import Grasp
from vipr.systems.grasping.wrench import contact_wrenches, epsilon
from vipr.systems.hand import transmission
from vipr.systems.hand.torque_switch import GRASPING, Drives

CLOSE_RATE = 0.8  # rad/s of the finger command
LIFT, LIFT_S = 0.10, 0.6  # m, s
SHAKE, SHAKE_HZ, SHAKE_S = 0.02, 2.5, 0.8  # m, Hz, s: up to 4.9 m/s^2
LARGEST_SLIP = 0.03  # m: beyond it the object is not held but hangs
MOST_TIP = np.radians(10.0)  # of the object while the fingers close
TICK = 0.02  # s, of command and watch
TIME_STEP = 0.004  # s, of the physics


@dataclass(frozen=True)
class Trial:
    """What came of it."""

    held: bool
    slip: float  # m, of the object in the hand, from the end of closing
    tilt: float  # rad, the same for its rotation
    moved: float  # m, how far closing moved the object
    closed: np.ndarray  # (3,) rad, finger angles
    torque: np.ndarray  # (3,) N m of the finger motors after closing
    quality: float  # epsilon of the wrench space after closing
    let_go: int = 0  # clutches, while it closed
    why: str = ""  # it failed


def fits(grasp: Grasp, object_: str, X_WO: np.ndarray) -> bool:
    """Whether the open hand touches neither object nor support at the grasp and on the way to it."""
    bench = HandBench(_config(grasp, object_, X_WO))
    context = bench.CreateDefaultContext()
    return not any(_touches(bench, context, back * _retreat(grasp, X_WO)) for back in (0.0, 0.3, 0.7))


def attempt(
    grasp: Grasp,
    object_: str,
    X_WO: np.ndarray,
    X_WG: np.ndarray | None = None,
    *,
    shake: bool = True,
    drives: Drives = GRASPING,
) -> Trial:
    """The grasp on an object at rest at X_WO; the hand goes to X_WG, where it believes the object to be, or to the grasp's own place."""
    run = _Run(HandBench(_config(grasp, object_, X_WO, X_WG, drives)))
    if _touches(run.bench, run.root, np.zeros(3)):
        return _failed("the hand touches something before it closes")
    X_WO_before = run.read("X_WO_true").GetAsMatrix4()
    closed = _close(run, grasp)
    torque, quality = np.array(run.read("motor_torque")[:3]), _quality(run.bench, run.root)
    let_go = 3 - int(sum(run.read("clutch")))
    X_WO_closed = run.read("X_WO_true").GetAsMatrix4()
    moved = float(np.linalg.norm(X_WO_closed[:3, 3] - X_WO_before[:3, 3]))
    if se3.angle_between(X_WO_before, X_WO_closed) > MOST_TIP:
        return _failed("it turns over as the fingers close")
    slip, tilt = _lift_and_shake(run, shake)
    raised = run.read("X_WO_true").translation()[2] - X_WO_closed[2, 3]
    held = raised > 0.7 * LIFT and slip < LARGEST_SLIP
    return Trial(
        held, slip, tilt, moved, closed, torque, quality, let_go, "" if held else f"lifted {1e3 * raised:.0f} mm"
    )


class _Run:
    """A bench that is being simulated."""

    def __init__(self, bench: HandBench):
        self.bench, self.simulator, self.time = bench, Simulator(bench), 0.0
        self.root = self.simulator.get_mutable_context()
        self.fix("carriage_desired_state", np.zeros(6))

    def fix(self, port: str, value) -> None:
        self.bench.GetInputPort(port).FixValue(self.root, value)

    def read(self, port: str):
        return self.bench.GetOutputPort(port).Eval(self.root)

    def advance(self, time: float) -> None:
        self.time = time
        self.simulator.AdvanceTo(time)

    def in_hand(self) -> np.ndarray:
        """X_EO."""
        return self.read("X_WE_true").inverse().multiply(self.read("X_WO_true")).GetAsMatrix4()


def _close(run: _Run, grasp: Grasp) -> np.ndarray:
    """Close the fingers until they stand, stop their motors there, and return their angles (3,) [rad]."""
    run.fix("torque_limit", np.append(grasp.torque, 2.0))
    still, last = 0, grasp.preshape
    while still < 5 and run.time < 2.5:
        time = run.time + TICK
        wanted = np.minimum(grasp.preshape + CLOSE_RATE * time, transmission.MOTOR_UPPER[:3])
        run.fix("motor_command", np.append(wanted, grasp.spread))
        run.advance(time)
        now = np.array(run.read("motor_position")[:3])
        still = still + 1 if (np.abs(now - last) < 0.002).all() else 0
        last = now
    run.fix("motor_command", np.append(last, grasp.spread))
    run.advance(run.time + 0.1)
    return last


def _lift_and_shake(run: _Run, shake: bool) -> tuple[float, float]:
    """The most that the object slips [m] and turns [rad] in the hand meanwhile."""
    X_EO, slip, tilt = run.in_hand(), 0.0, 0.0
    for seconds, shift in ((LIFT_S, _lift), (SHAKE_S, _shake) if shake else (0.1, _stay)):
        start = run.time
        for s in np.arange(TICK, seconds + TICK / 2, TICK):
            run.fix("carriage_desired_state", shift(s))
            run.advance(start + s)
            change = se3.difference(X_EO, run.in_hand())
            slip, tilt = max(slip, float(np.linalg.norm(change[3:]))), max(tilt, float(np.linalg.norm(change[:3])))
        run.time = start + seconds
    return slip, tilt


def _lift(s):
    phase = min(s / LIFT_S, 1.0)
    rise = LIFT * (phase - np.sin(2 * np.pi * phase) / (2 * np.pi))
    return [0, 0, rise, 0, 0, LIFT / LIFT_S * (1 - np.cos(2 * np.pi * phase))]


def _shake(s):
    """Along x, y and z at once, at rates that never repeat together within the time; it begins and ends smoothly."""
    w = 2 * np.pi * SHAKE_HZ * np.array([1.0, 0.8, 1.2])
    envelope, slope = np.sin(np.pi * s / SHAKE_S), np.pi / SHAKE_S * np.cos(np.pi * s / SHAKE_S)
    p = SHAKE * envelope * np.sin(w * s)
    v = SHAKE * (slope * np.sin(w * s) + envelope * w * np.cos(w * s))
    return [*(p + [0, 0, LIFT]), *v]


def _stay(s):
    return [0, 0, LIFT, 0, 0, 0]


def _config(grasp, object_, X_WO, X_WG=None, drives=GRASPING):
    X_WE = X_WO @ grasp.X_OG if X_WG is None else X_WG
    motors = np.append(grasp.preshape, grasp.spread)
    return HandBenchConfig(object=object_, X_WO=X_WO, X_WE=X_WE, motors=motors, drives=drives, time_step=TIME_STEP)


def _retreat(grasp, X_WO):
    """(3,) in W, from the grasp to its reference point."""
    return -grasp.approach * (X_WO @ grasp.X_OG)[:3, 2]


def _touches(bench, root, shift) -> bool:
    """Whether the hand, shifted [m], touches anything."""
    plant = bench.plant
    context = plant.GetMyMutableContextFromRoot(root)
    carriage = plant.GetModelInstanceByName("carriage")
    plant.SetPositions(context, carriage, shift)
    scene = bench.scene_graph
    query = scene.get_query_output_port().Eval(scene.GetMyContextFromRoot(root))
    inspector = query.inspector()
    hand = plant.GetModelInstanceByName("barrett_hand")

    def of_hand(geometry):
        return plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).model_instance() == hand

    pairs = query.ComputePointPairPenetration()
    touching = any(of_hand(p.id_A) != of_hand(p.id_B) and p.depth > 1e-4 for p in pairs)
    plant.SetPositions(context, carriage, np.zeros(3))
    return touching


def _quality(bench, root) -> float:
    """Epsilon of the contact patches between hand and object; each counts as three points, for it resists turning."""
    plant, results = bench.plant, bench.GetOutputPort("contact_results").Eval(root)
    context = plant.GetMyContextFromRoot(root)
    thing, hand = plant.GetBodyByName(bench.config.object), plant.GetModelInstanceByName("barrett_hand")
    inspector = bench.scene_graph.model_inspector()
    points, normals = [], []
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        bodies = [plant.GetBodyFromFrameId(inspector.GetFrameId(g)) for g in (surface.id_M(), surface.id_N())]
        if thing not in bodies or hand not in [b.model_instance() for b in bodies]:
            continue
        force = info.F_Ac_W().translational() * (1.0 if bodies[0] == thing else -1.0)
        size = np.linalg.norm(force)
        if size < 0.2:
            continue
        # Face normals point out of N into M.
        area = np.array([surface.area(k) for k in range(surface.num_faces())])
        n = np.sum([a * surface.face_normal(k) for k, a in enumerate(area)], axis=0) * (
            1.0 if bodies[0] == thing else -1.0
        )
        n /= np.linalg.norm(n)
        u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
        u /= np.linalg.norm(u)
        radius = 0.5 * np.sqrt(area.sum() / np.pi)
        for angle in 2 * np.pi * np.arange(3) / 3:
            points.append(surface.centroid() + radius * (np.cos(angle) * u + np.sin(angle) * np.cross(n, u)))
            normals.append(n)
    if not points:
        return 0.0
    X_WO = plant.EvalBodyPoseInWorld(context, thing)
    centre = X_WO @ thing.default_com()
    length = max(float(np.linalg.norm(np.array(points) - centre, axis=1).max()), 0.02)
    return epsilon(contact_wrenches(np.array(points), np.array(normals), np.full(len(points), 0.6), centre, length))


def _failed(why: str) -> Trial:
    return Trial(False, np.inf, np.inf, np.inf, np.zeros(3), np.zeros(3), 0.0, 0, why)
