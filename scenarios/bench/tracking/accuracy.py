"""Accuracy on slowly moving objects at 2 m, beside the Cramer-Rao bound for the same nodes and the measured edge noise."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import OBJECTS, UPRIGHT, Run, Workbench, spin_axis
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions
from vipr.systems import se3
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.displacements import normal_jacobian
from vipr.systems.tracking.edge_pass import placed_edges
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Sight
from vipr.systems.tracking.visible_edges import visible_nodes

SETTLE = 5  # frames left out at the start
NOISE = 2.0  # grey levels RMS


def edge_noise_and_bound(run: Run, image: np.ndarray, X_CO: np.ndarray, nodes: int):
    """(sigma px, (6, 6) covariance of (rotation, position of the centre) in C) that the nodes of this image allow.

    The edges are those that the tracker finds at the true pose. sigma is 1.48 MAD of their distances from it. How the noise of one node
    compares with another's, the tracker tells from their strength; how large it is, is measured: so many times what it tells as 1.48 MAD
    of distance over noise. The bound takes the nodes' errors as independent: (sum of J' J over a node's variance)^-1. What the nodes do
    not show at all (the spin of a can) is left out of it.
    """
    belief = start(X_CO)
    sight = Sight(
        image, run.model, run.lens, TrackerSettings(nodes=nodes), None, belief, belief.motion, 0.0, belief.motion
    )
    sight.open([X_CO], margin=12.0)
    at = visible_nodes(run.model, X_CO, run.lens, nodes)
    matches, noise, certain, _ = placed_edges(sight, at, X_CO, 4.0, sharp=True)
    sharp = slice(matches.wide, None)
    offset = np.where(matches.strength[:, sharp] != 0, matches.offset[:, sharp], np.inf)
    nearest = np.argmin(np.abs(offset), axis=1)[:, None]
    offset, noise = (np.take_along_axis(part, nearest, 1)[:, 0] for part in (offset, noise[:, sharp]))
    found = np.isfinite(offset) & (certain * np.ones(len(at)) == 1.0)
    offset, noise = offset[found], noise[found]
    sigma, times = (1.48 * float(np.median(np.abs(x - np.median(x)))) for x in (offset, offset / noise))
    centre = run.model.centre
    X_CB = se3.pose(X_CO[:3, :3], X_CO[:3, :3] @ centre + X_CO[:3, 3])
    J = normal_jacobian(replace(at, p_O=at.p_O - centre), X_CB, run.lens)[found] / (times * noise)[:, None]
    shown = np.eye(6)
    axis_O = spin_axis(run.model)
    if axis_O is not None:
        axis = X_CO[:3, :3] @ axis_O
        shown = np.linalg.svd(np.outer(axis, axis))[0][:, 1:]
        shown = np.block([[shown, np.zeros((3, 3))], [np.zeros((3, 2)), np.eye(3)]])
    shown = shown * np.repeat([1.0, 0.1], 3)[:, None]
    return sigma, shown @ np.linalg.inv((J @ shown).T @ (J @ shown)) @ shown.T


def run(bench: Workbench) -> Iterator[Table]:
    table = Table(
        f"Accuracy: XC-77 at 2 m, noise {NOISE:g} grey levels RMS, objects moving by at most 3 px a frame; RMS and times the bound",
        (
            "object",
            "lost runs",
            "frames",
            "nodes",
            "edge px",
            "lateral mm",
            "x bound",
            "depth mm",
            "x bound",
            "rotation deg",
            "x bound",
            "median run x bound",
            "depth told mm",
            "bias x, y, z mm",
        ),
        note="edge px: 1.48 MAD of the edges' distances from the truth. Bound: Cramer-Rao for the same nodes, each with its share of that "
        "noise. lateral: RMS length of the error across the line of sight; a can's rotation is that of its axis. Lost runs (wrong by "
        "20 px or 15 degrees) are left out. The bound is that of one image; the tracker adds its prediction and the texture learnt, so a "
        "ratio below 1 is no error. Median run: lateral, depth, rotation. "
        "Depth told: RMS of the standard deviation that it reports. Bias: over all runs.",
    )
    count, length = (2, 15) if bench.quick else (6, 20)
    for name in OBJECTS:
        errors, angles, told, bounds, ratios, sigmas, used, lost = [], [], [], [], [], [], [], 0
        for k in range(count):
            rng = np.random.default_rng([bench.seed, k])
            turn = se3.exp_so3(np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(-0.4, 0.4)])) @ UPRIGHT
            turn = turn @ se3.exp_so3(np.array([0, 0, rng.uniform(-np.pi, np.pi)]))
            X_CO = bench.at(name, turn=turn, place=(*rng.uniform(-0.12, 0.12, 2) * (1, 0.7), 2.0))
            bench.progress(f"accuracy: {name} {k + 1}/{count}")
            moving = trajectories.hand_held(
                X_CO, bench.model(name).corners, bench.lens, seed=k, pixels_per_frame=3.0, duration=length / 25
            )
            background = "clutter" if k % 2 else "plain"
            frames = bench.render(
                name, moving, length, Conditions(noise=NOISE, samples=2, finer=4), background=background, seed=k
            )
            result = bench.track(name, frames)
            if not result.survived:
                lost += 1
                continue
            errors += list(result.millimetres[SETTLE:])
            angles += list(result.degrees[SETTLE:])
            told += list(result.depth_told[SETTLE:])
            first = len(bounds)
            for (frame, X), belief in list(zip(frames, result.beliefs, strict=True))[SETTLE::5]:
                sigma, bound = edge_noise_and_bound(result, frame.image, X, 200)
                sigmas.append(sigma)
                used.append(belief.nodes)
                bounds.append(bound)
            ratios.append(_rms(result.millimetres[SETTLE:], result.degrees[SETTLE:]) / _least(bounds[first:]))
        if not errors:
            table.rows.append((name, f"{lost} of {count}", 0, 0, *[float("nan")] * 7, "-", float("nan"), "-"))
            continue
        rms, least = _rms(errors, angles), _least(bounds)
        figures = [float(f) for value, bound in zip(rms, least, strict=True) for f in (value, value / bound)]
        median = " / ".join(f"{r:.1f}" for r in np.median(ratios, axis=0))
        bias = " ".join(f"{b:+.2f}" for b in np.mean(errors, axis=0))
        said = float(np.sqrt(np.mean(np.square(told))))
        counts = f"{lost} of {count}", len(angles), int(np.median(used))
        table.rows.append((name, *counts, float(np.median(sigmas)), *figures, median, said, bias))
    yield table


def _rms(errors, angles):
    """(3,) RMS of the error across the line of sight [mm], of that in depth [mm], and of the rotation [deg]."""
    across, along = np.sum(np.square(errors)[:, :2], axis=1), np.square(errors)[:, 2]
    return np.sqrt([np.mean(across), np.mean(along), np.mean(np.square(angles))])


def _least(bounds):
    """(3,) the same of the bounds (6, 6) of some images."""
    mean = np.mean(bounds, axis=0)
    millimetres = 1e3 * np.sqrt([mean[3, 3] + mean[4, 4], mean[5, 5]])
    return np.array([*millimetres, np.degrees(np.sqrt(np.trace(mean[:3, :3])))])
