"""The report's plots, as SVG: what a scenario asks for, drawn from a run's history."""

import io
from dataclasses import dataclass

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from vipr.systems.recording.history import History
from vipr.systems.se3 import angle_between, log_so3

COLOURS = ("#c2410c", "#15803d", "#1d4ed8", "#7e22ce", "#0e7490", "#a16207", "#be185d", "#4b5563")
TRUTH = "#111827"
STYLE = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.edgecolor": "#9ca3af",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e7eb",
    "legend.frameon": False,
    "svg.hashsalt": "vipr",
}


@dataclass(frozen=True)
class Line:
    """One line of a plot."""

    numbers: str  # "channel.name" of a vector or joint channel
    label: str
    truth: bool = False  # drawn thin and dashed, over the estimate


@dataclass(frozen=True)
class Plot:
    """Numbers over time."""

    title: str
    y_label: str
    unit: str
    lines: tuple[Line, ...]
    scale: float = 1.0  # from the channel's unit to the plot's: 1000 for metres drawn in mm
    limit: float | None = None  # drawn as a line: what the run is held against, in the plot's unit


@dataclass(frozen=True)
class PosePlot:
    """An estimated pose against the true one: position and rotation since the truth's first, and both errors."""

    title: str
    estimate: str  # names of pose channels in one parent frame
    truth: str
    error: str = ""  # vector channel of the errors at the exposures (``History.error_norms``); else those at the ticks
    limits: tuple[float, float] | None = None  # mm and degrees, drawn in the error panels


def draw(plot: Plot | PosePlot, history: History) -> bytes:
    """The plot as an SVG file. Numbers that are missing or not finite leave gaps."""
    with rc_context(STYLE):
        figure = _pose_figure(plot, history) if isinstance(plot, PosePlot) else _figure(plot, history)
        svg = io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": "vipr"})
    return svg.getvalue()


def _figure(plot: Plot, history: History) -> Figure:
    figure = Figure(figsize=(8.4, 2.9), layout="constrained")
    axes = figure.subplots()
    for k, line in enumerate(plot.lines):
        look = {"color": TRUTH, "lw": 1.0, "ls": (0, (4, 4)), "zorder": 3} if line.truth else _look(k)
        _line(axes, history.times, plot.scale * history.numbers(line.numbers), label=line.label, **look)
    _finish(axes, plot.title, f"{plot.y_label} [{plot.unit or '1'}]", plot.limit)
    if len(plot.lines) > 1:
        _legend(axes, len(plot.lines))
    return figure


def _pose_figure(plot: PosePlot, history: History) -> Figure:
    times, estimate, truth = history.times, history.poses(plot.estimate), history.poses(plot.truth)
    p, r = _motion(estimate, truth)
    p_true, r_true = _motion(truth, truth)
    figure = Figure(figsize=(8.4, 5.2), layout="constrained")
    (position, rotation), (position_error, rotation_error) = figure.subplots(2, 2, sharex=True)
    for k, axis in enumerate("xyz"):
        for axes, seen, real in ((position, p, p_true), (rotation, r, r_true)):
            _line(axes, times, seen[:, k], label=axis, **_look(k))
            _line(
                axes,
                times,
                real[:, k],
                color=TRUTH,
                lw=0.9,
                ls=(0, (4, 4)),
                zorder=3,
                label="truth" if k == 2 else None,
            )
    mm, deg = pose_errors(plot, history)
    _line(position_error, times, mm, **_look(3))
    _line(rotation_error, times, deg, **_look(3))
    limits = plot.limits or (None, None)
    _finish(position, f"{plot.title}: position", "since the start [mm]", x_label=False)
    _finish(rotation, f"{plot.title}: rotation", "since the start [deg]", x_label=False)
    _finish(position_error, "Position error against truth", "distance [mm]", limits[0])
    _finish(rotation_error, "Rotation error against truth", "angle [deg]", limits[1])
    _legend(position, 4)
    return figure


def pose_errors(plot: PosePlot, history: History) -> tuple[np.ndarray, np.ndarray]:
    """Distance [mm] and angle [deg] between estimate and truth at each tick (n,)."""
    if plot.error:
        return history.error_norms(plot.error)
    estimate, truth = history.poses(plot.estimate), history.poses(plot.truth)
    angles = [angle_between(A, B) if np.isfinite(A + B).all() else np.nan for A, B in zip(estimate, truth, strict=True)]
    return 1e3 * np.linalg.norm(estimate[:, :3, 3] - truth[:, :3, 3], axis=1), np.rad2deg(angles)


def _motion(poses: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions [mm] (n, 3) and rotation vectors [deg] (n, 3) of the poses since the first true pose."""
    there = np.isfinite(truth).all(axis=(1, 2))
    first = truth[np.argmax(there)] if there.any() else np.full((4, 4), np.nan)
    turns = [
        log_so3(X[:3, :3] @ first[:3, :3].T) if np.isfinite(X).all() and there.any() else np.full(3, np.nan)
        for X in poses
    ]
    return 1e3 * (poses[:, :3, 3] - first[:3, 3]), np.rad2deg(np.reshape(turns, (-1, 3)))


def _look(k: int) -> dict:
    return {"color": COLOURS[k % len(COLOURS)], "lw": 1.8}


def _line(axes, times, values, **look) -> None:
    values = np.where(np.isfinite(values), values, np.nan)
    axes.plot(times, values, **look)
    alone = np.isfinite(values) & ~np.isfinite(np.r_[np.nan, values[:-1]]) & ~np.isfinite(np.r_[values[1:], np.nan])
    if alone.any():  # a single number between gaps has no line to it
        axes.plot(times[alone], values[alone], ".", ms=3, color=look["color"])


def _finish(axes, title: str, y_label: str, limit: float | None = None, x_label: bool = True) -> None:
    axes.set_title(title, loc="left")
    axes.set_ylabel(y_label)
    if x_label:
        axes.set_xlabel("simulated time [s]")
    if limit is not None:
        axes.axhline(limit, color="#dc2626", lw=0.9, ls=":")
        axes.annotate(
            f"allowed {limit:g}",
            (1, limit),
            xycoords=("axes fraction", "data"),
            ha="right",
            va="bottom",
            fontsize=7.5,
            color="#dc2626",
        )
    lines = [line.get_ydata() for line in axes.lines]
    if not any(np.isfinite(np.asarray(y, float)).any() for y in lines[: len(lines) - (limit is not None)]):
        axes.text(0.5, 0.5, "no data", transform=axes.transAxes, ha="center", va="center", color="#6b7280")


def _legend(axes, columns: int) -> None:
    axes.legend(ncols=min(columns, 6), loc="best", fontsize=8, handlelength=1.5, columnspacing=1.0)
