"""``vipr bench arm``: clearance against the distances of the real model, limits under wild twists, stopping, and what it costs."""

import time
from collections.abc import Callable, Iterator

import numpy as np

from vipr.diagrams.workcell_layout import JOINT_LIMITS, collision_guard, obstacles, puma_with_hand
from vipr.scenarios.bench.arm_stop import stopping
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.model_distances import ModelDistances
from vipr.scenarios.bench.tables import Table
from vipr.systems.arm import puma560
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.arm.guard import CollisionGuard
from vipr.systems.arm.limit_use import limit_use
from vipr.systems.arm.puma_body import OPEN, puma_with_hand_body
from vipr.systems.hand.transmission import JOINT_UPPER

PERIOD = 0.01  # s
MODEL_LESS = ("knuckle", "stage_foot")  # what the model shows but gives no shape to collide with


PARTS = {
    "clearance": "the guard's gaps beside the distances of Drake's model",
    "limits": "what wild twists make of the joints' limits and of the gaps",
    "stopping": "the arm told to stand at its greatest speed of servoing",
    "time": "of a tick, of a clearance",
}
SEED = 1
NEEDS_DATA: dict[str, str] = {}


def tables(part: str, bench: Bench) -> Iterator[Table]:
    """The table of one part."""
    bench.progress(f"bench arm: {part}")
    yield {"clearance": _clearance, "limits": _limits, "stopping": _stopping, "time": _time}[part](bench)


def _clearance(bench: Bench) -> Table:
    count, rng = bench.of(3000, 200), np.random.default_rng(bench.seed)
    arm, model, around = puma_with_hand(), ModelDistances(), obstacles(np.zeros(3))
    beyond, short, near = [], [], []
    for _ in range(count):
        q, hand = random_configuration(rng)
        body = puma_with_hand_body(arm, hand)
        ours, pair = body.clearance(q, around)
        true = model.smallest(q, hand, body, around)
        beyond.append(ours - true)
        if true > 0 and not any(name in part for part in pair for name in MODEL_LESS):
            short.append(true - ours)
            near += [true - ours] if true < 0.05 else []
    table = Table(
        f"Clearance of arm and hand against Drake's distances, {count} random configurations",
        ("quantity", "mm"),
        note="The clearance is a lower bound: it must not be above the distance. Short of it: free configurations only.",
    )
    table.rows.append(("most above the distance", 1e3 * max(beyond)))
    for name, values in (("short of it", short), ("short of it, closer than 50 mm", near)):
        for share, word in ((0.5, "median"), (0.99, "99 %"), (1.0, "most")):
            table.rows.append((f"{name}, {word}", 1e3 * float(np.quantile(values, share))))
    return table


def _limits(bench: Bench) -> Table:
    seeds, steps, model = bench.seeds(10, 2), 0, ModelDistances()
    most, least = np.zeros(3), np.inf
    guard = collision_guard()
    for k in seeds:
        rng, driven = np.random.default_rng(k), DrivenArm(guard=guard)
        (q, v), places = driven.state, []
        for V, ticks in random_twists(rng, 40):
            for _ in range(ticks):
                q_new, v_new = driven.step(V)
                most = np.maximum(most, limit_use(q_new, v_new, v, JOINT_LIMITS, PERIOD))
                q, v = q_new, v_new
                places.append(q)
        steps += len(places)
        least = min(least, *(model.smallest(q, OPEN, guard.body, guard.obstacles) for q in places[::5]))
    table = Table(
        f"Limits under wild twists, {len(seeds)} seeds, {steps} steps",
        ("quantity", "value"),
        note=f"Twists up to some m/s and 20 rad/s, every 0.05 to 1.5 s another, half of them towards table or arm. Margin of the guard: "
        f"{1e3 * guard.margin:g} mm.",
    )
    for name, value in zip(("position", "speed", "acceleration"), most, strict=True):
        table.rows.append((f"largest use of a joint's {name} limit, %", 100.0 * value))
    table.rows.append(("least distance in Drake's model, mm", 1e3 * least))
    return table


def _stopping(bench: Bench) -> Table:
    return stopping(bench.of(30, 2), bench.seed)


def _time(bench: Bench) -> Table:
    count, guard, rng = bench.of(1000, 100), collision_guard(), np.random.default_rng(bench.seed)
    table = Table(
        "CPU time", ("what", "median us", "95 % us"), note="Of the process, on a machine that does other things too."
    )
    sway = [np.array([0, 0, 0.1, 0.1 * np.sin(k / 40), 0.1 * np.cos(k / 40), 0.0]) for k in range(count)]
    down = [np.array([0, 0, 0, 0, 0, -0.2])] * count
    for name, twists, some in (
        ("a tick of the commander, no guard", sway, None),
        ("with the guard, servoing above the table", sway, guard),
        ("with the guard, held off the table", down, guard),
    ):
        driven = DrivenArm(guard=some)
        spent = [_spent(lambda V=V, driven=driven: driven.step(V, np.zeros(4))) for V in twists]
        table.rows.append((name, *_quantiles(spent)))
    body, many = guard.body, np.array([random_configuration(rng)[0] for _ in range(500)])
    table.rows.append(
        (
            "a clearance, one at a time",
            *_quantiles([_spent(lambda q=q: body.clearance(q, guard.obstacles)) for q in many[:200]]),
        )
    )
    batches = [_spent(lambda: body.clearance(many, guard.obstacles)) / len(many) for _ in range(bench.of(10, 3))]
    table.rows.append(("a clearance, 500 at once", *_quantiles(batches)))
    return table


def _spent(action: Callable[[], object]) -> float:
    begin = time.process_time()
    action()
    return time.process_time() - begin


def _quantiles(seconds: list[float]) -> tuple[float, float]:
    return tuple(1e6 * float(np.quantile(seconds, share)) for share in (0.5, 0.95))


def random_configuration(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles of the arm (6,) and of the hand (8,), both fingers spread alike."""
    hand = rng.uniform(0, JOINT_UPPER)
    hand[3] = hand[0]
    return rng.uniform(puma560.POSITION_LOWER, puma560.POSITION_UPPER), hand


def random_twists(rng: np.random.Generator, count: int) -> Iterator[tuple[np.ndarray, int]]:
    """Twists and their ticks: still, slow, and far beyond what the arm can do; often down, or back towards the arm."""
    for _ in range(count):
        V = rng.normal(size=6) * rng.choice([0.0, 0.2, 1.0, 20.0]) * [1, 1, 1, 0.5, 0.5, 0.5]
        V += rng.choice([0.0, 1.0]) * np.array([0, 0, 0, *rng.choice([[0, 0, -1.0], [-1.0, 0, 0], [1.0, 0, 0.5]])])
        yield V, int(rng.integers(5, 150))


class DrivenArm:
    """An arm commander of the workcell, stepped tick by tick."""

    def __init__(self, q: np.ndarray = puma560.NAMED["nominal"], guard: CollisionGuard | None = None):
        self._commander = ArmCommander(puma_with_hand(), JOINT_LIMITS, q, guard=guard, period=PERIOD)
        self._context = self._commander.CreateDefaultContext()

    def step(self, V: np.ndarray, motor: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """One tick at the wanted twist V (6,), the hand's motors at ``motor`` (4,); the set-points and their rates after it."""
        if motor is not None:
            self._commander.GetInputPort("motor_position").FixValue(self._context, motor)
        self._commander.GetInputPort("V_WE_W").FixValue(self._context, V)
        new = self._commander.EvalUniquePeriodicDiscreteUpdate(self._context)
        self._context.get_mutable_discrete_state().SetFrom(new)
        return self.state

    def _eval(self, port: str):
        return self._commander.GetOutputPort(port).Eval(self._context)

    @property
    def state(self) -> tuple[np.ndarray, np.ndarray]:
        value = self._eval("desired_state")
        return value[:6].copy(), value[6:].copy()

    @property
    def limited_by(self) -> str:
        return ArmCommander.REASONS[int(self._eval("limited_by")[0])]

    @property
    def status(self) -> str:
        return self._eval("status").text
