"""The tables and the picture of ``vipr analyse servo``: what gain and latency do to the closed loop."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from vipr.diagrams.servo_loop import workcell_loop
from vipr.scenarios.bench.tables import Table
from vipr.systems.errors import InputError
from vipr.systems.servo.analysis import (
    SampledLoop,
    behaviour,
    largest_stable_gain,
    poles,
    quickest_gain,
    require_gain,
    step_response,
)

USES = {"predicted": "encoders carry the error to the present", "delayed": "the error of the exposure is used"}


def tables(gains: list[float], latencies: list[float]) -> list[Table]:
    """Gain limits against latency, and the loop's behaviour against gain at the schedule's latency. Gains [1/s], latencies [s]."""
    if not gains or not latencies:
        raise InputError("servo analysis: needs at least one gain and one latency")
    for gain in gains:
        require_gain(gain)
    limits = Table(
        "Gain limits against latency (exposure to the servo's tick)",
        ("use of the measurement", "latency ms", "largest stable gain 1/s", "quickest gain 1/s", "it settles in s"),
        note="Quickest: the largest gain that overshoots by at most 2 % of the step. Settled: within 2 % for good.",
    )
    for use in USES:
        for latency in latencies:
            loop = replace(workcell_loop(use=use), latency=latency)
            quick = quickest_gain(loop)
            limits.rows.append((use, 1e3 * latency, largest_stable_gain(loop), quick, behaviour(loop, quick).settling))
    rows = Table(
        f"Behaviour against gain at the schedule's latency, {1e3 * workcell_loop().latency:.0f} ms",
        ("use of the measurement", "gain 1/s", "gain margin", "slowest pole |z|", "overshoot %", "settles in s"),
        note="Poles of one camera period, 40 ms.",
    )
    for use in USES:
        loop = workcell_loop(use=use)
        for gain in gains:
            b = behaviour(loop, gain)
            rows.rows.append((use, gain, b.margin, abs(poles(loop, gain)[0]), 1e2 * b.overshoot, b.settling))
    return [limits, rows]


def draw(path: Path, gains: list[float], latencies: list[float]) -> None:
    """Write the picture: poles against gain, largest stable gain against latency, steps."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15, 4.6), layout="constrained")
    _draw_poles(figure.add_subplot(1, 3, 1), workcell_loop())
    _draw_limits(figure.add_subplot(1, 3, 2), np.arange(0.0, max(*latencies, 0.1) + 0.005, 0.01))
    _draw_steps(figure.add_subplot(1, 3, 3), workcell_loop(), gains)
    figure.savefig(path, dpi=100)


def _draw_poles(axes, loop: SampledLoop) -> None:
    gains = np.geomspace(0.5, 1.3 * largest_stable_gain(loop), 60)
    z = np.array([poles(loop, gain) for gain in gains])
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    axes.plot(circle.real, circle.imag, "k-", linewidth=0.8)
    dots = axes.scatter(z.real, z.imag, c=np.broadcast_to(gains[:, None], z.shape), s=6, cmap="viridis")
    axes.figure.colorbar(dots, ax=axes, label="gain [1/s]")
    axes.set(title="Poles, encoders bridging the latency", xlabel="Re z [-]", ylabel="Im z [-]", aspect="equal")


def _draw_limits(axes, latencies: np.ndarray) -> None:
    for use, meaning in USES.items():
        loop = workcell_loop(use=use)
        loops = [replace(loop, latency=latency) for latency in latencies]
        axes.plot(1e3 * latencies, [largest_stable_gain(loop) for loop in loops], label=f"{use}: {meaning}")
    axes.plot(1e3 * latencies, [quickest_gain(loop) for loop in loops], "--", label="delayed, 2 % overshoot")
    axes.set(title="Largest stable gain", xlabel="latency [ms]", ylabel="gain [1/s]")
    axes.set_ylim(bottom=0.0)
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)


def _draw_steps(axes, loop: SampledLoop, gains: list[float]) -> None:
    for gain in gains:
        if not behaviour(loop, gain).stable:
            continue
        times, places = step_response(loop, gain, 2.0)
        axes.plot(times, places.mean(axis=1), label=f"{gain:g} 1/s")
    axes.set(title="Step, mean of the joints", xlabel="time from the first exposure [s]", ylabel="error / start [-]")
    axes.legend(fontsize=8, title="gain")
    axes.grid(alpha=0.3)
