"""Pictures of recognition: confusion matrix, rejection curve."""

from pathlib import Path

import numpy as np

from vipr.scenarios.experiments.evaluation import confusion


def confusion_picture(truth: np.ndarray, answer: np.ndarray, path: Path, title: str) -> None:
    """Write a confusion matrix in numbers: right answers in grey, errors in red, shaded by their share of the row."""
    figure, axes = _figure(0.30 * len(np.unique(truth)) + 2.4)
    counts, labels = confusion(np.asarray(truth, str), np.asarray(answer, str))
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    colour = np.ones((*counts.shape, 3))
    right = np.eye(len(labels), dtype=bool)
    colour[right] = 1.0 - 0.55 * share[right][:, None]
    wrong = ~right & (counts > 0)
    colour[wrong] = np.array([1.0, 0.85, 0.8]) * (1 - np.minimum(4 * share[wrong], 1)[:, None] * [0.0, 0.75, 0.85])
    axes.imshow(colour)
    for i, j in np.argwhere(counts > 0):
        axes.text(j, i, counts[i, j], ha="center", va="center", fontsize=6, color="white" if i == j else "black")
    long = max(map(len, labels)) > 2
    axes.set_xticks(range(len(labels)), labels, rotation=90 if long else 0, fontsize=8)
    axes.set_yticks(range(len(labels)), labels, fontsize=8)
    axes.set_xlabel("recognised as [number of sequences]")
    axes.set_ylabel("made")
    axes.set_title(title, fontsize=10)
    _save(figure, path)


def rejection_picture(
    false_rejection: np.ndarray, false_acceptance: np.ndarray, here: tuple[float, float], path: Path, title: str
) -> None:
    """Write the curve of false acceptance over false rejection (percent) with the working point ``here``."""
    figure, axes = _figure(4.6)
    axes.plot(false_rejection, false_acceptance, color="0.2")
    label = f"threshold in use: {here[1]:.1f} % accepted, {here[0]:.1f} % rejected"
    axes.plot(*here, "o", color="tab:red", label=label, clip_on=False, zorder=5)
    axes.set(
        xlabel="gestures rejected [%]", ylabel="non-gestures accepted [%]", xlim=(0, 20), ylim=(0, 20), title=title
    )
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    _save(figure, path)


def _figure(size):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size, size), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def _save(figure, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)
