"""``report.html``: one page that shows a run, complete in itself: no network, no file beside it is needed."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from vipr.systems.recording.channels import Event
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Plot, PosePlot, draw

UNITS = ("mm", "m", "deg", "rad", "px", "ms", "s", "mm_s", "m_s", "deg_s", "rad_s", "N", "Nm", "hz", "percent", "kg")
SHOWN = {"mm_s": "mm/s", "m_s": "m/s", "deg_s": "deg/s", "rad_s": "rad/s", "Nm": "N m", "hz": "Hz", "percent": "%"}
NAMES_OF_TIME = {"wall_s": "wall time", "simulated_s": "simulated time", "real_time_factor": "real-time factor"}


def make_report(
    summary: Mapping,
    history: History,
    *,
    plots: Sequence[Plot | PosePlot] = (),
    limits: Mapping[str, float] | None = None,
    diagram: Path | None = None,
) -> str:
    """The page of a run, finished or not.

    Args:
        summary: as `make_summary` made it.
        history: what was recorded.
        plots: drawn in this order.
        limits: what figures may reach at most, by their names.
        diagram: an SVG file of the wiring; left out where it does not exist.
    """
    sections = [
        ("Figures", _figures(summary["figures"], limits or {})),
        ("What the camera saw", _stills(history)),
        ("Over time", "".join(_plot(plot, history) for plot in plots)),
        ("Events", _events(history.events, history.duration)),
        ("Where the time went", _time(summary["time"])),
        ("Wiring", _diagram(diagram)),
        ("Settings and versions", _settings(summary)),
    ]
    page = Template(files(__package__).joinpath("report.template.html").read_text(encoding="utf-8"))
    return page.substitute(
        title=escape(f"{summary['scenario']}, seed {summary['seed']}"),
        scenario=escape(str(summary["scenario"])),
        seed=escape(str(summary["seed"])),
        outcome="success" if summary["success"] else "failure",
        word="Success" if summary["success"] else "Failure",
        reason=escape(summary["reason"]),
        simulated=_number(summary["time"]["simulated_s"]),
        factor=_number(summary["time"]["real_time_factor"]),
        sections="\n".join(f"<section><h2>{title}</h2>{body}</section>" for title, body in sections if body),
    )


def name_and_unit(figure: str) -> tuple[str, str]:
    """``final_translation_error_mm`` as ("final translation error", "mm"); the unit is "" if the name ends in none."""
    for unit in sorted(UNITS, key=len, reverse=True):
        if figure.endswith("_" + unit):
            return figure[: -len(unit) - 1].replace("_", " "), SHOWN.get(unit, unit)
    return figure.replace("_", " "), ""


def flat(settings: Mapping, prefix: str = "") -> list[tuple[str, object]]:
    """Nested settings as (dotted name, value)."""
    rows = []
    for key, value in settings.items():
        name = f"{prefix}{key}"
        rows += flat(value, name + ".") if isinstance(value, Mapping) and value else [(name, value)]
    return rows


def _number(value) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else escape(str(value))


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], css: str = "") -> str:
    """An HTML table; the cells are HTML already."""
    top = "".join(f"<th>{cell}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<table class="{css}"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'


def _figures(figures: Mapping, limits: Mapping[str, float]) -> str:
    if not figures:
        return "<p class='quiet'>The run ended before any figure was known.</p>"
    rows = []
    for figure, value in figures.items():
        name, unit = name_and_unit(figure)
        row = [escape(name), f"<b>{_number(value)}</b>", escape(unit)]
        if limits:
            row.append(_verdict(value, limits.get(figure)))
        rows.append(row)
    return _table(["figure", "value", "unit", *(["allowed"] if limits else [])], rows, "figures")


def _verdict(value, limit: float | None) -> str:
    if limit is None:
        return ""
    kept = value is not None and value <= limit
    return f"<span class='{'good' if kept else 'bad'}'>{'✓' if kept else '✗'} at most {_number(float(limit))}</span>"


def _stills(history: History) -> str:
    images = [
        f'<figure><img alt="camera at {time:.2f} s" src="data:image/jpeg;base64,{b64encode(jpeg).decode()}">'
        f"<figcaption>{time:.2f} s</figcaption></figure>"
        for time, jpeg in history.stills()
    ]
    return f'<div class="stills">{"".join(images)}</div>' if images else ""


def _plot(plot: Plot | PosePlot, history: History) -> str:
    return f'<img class="plot" alt="{escape(plot.title)}" src="{_svg(draw(plot, history))}">'


def _svg(svg: bytes) -> str:
    return f"data:image/svg+xml;base64,{b64encode(svg).decode()}"


def _events(events: Sequence[Event], duration: float) -> str:
    """Lanes of what each source said and how long it held, above the list."""
    if not events:
        return ""
    events = sorted(events, key=lambda event: event.time)
    lanes = []
    for source in dict.fromkeys(event.source for event in events):
        said = [event for event in events if event.source == source]
        ends = [event.time for event in said[1:]] + [duration]
        spans = [
            f'<span class="{event.level}" style="left:min({_percent(event.time, duration)}, 100% - 4px);'
            f'width:{_percent(end - event.time, duration)}" title="{event.time:.2f} s: {escape(event.text)}">'
            f"{escape(event.text)}</span>"
            for event, end in zip(said, ends, strict=True)
        ]
        lanes.append(f'<div class="lane"><b>{escape(source)}</b><div>{"".join(spans)}</div></div>')
    ticks = "".join(f"<i style='left:{_percent(time, duration)}'>{time:g} s</i>" for time in _round_times(duration))
    rows = [
        [f"{event.time:.2f}", escape(event.source), f"<span class='{event.level}'>{escape(event.text)}</span>"]
        for event in events
    ]
    table = _table(["time [s]", "source", "event"], rows)
    if len(rows) > 12:
        table = f"<details><summary>All {len(rows)} events</summary>{table}</details>"
    return f'<div class="lanes">{"".join(lanes)}<div class="lane"><b></b><div class="ticks">{ticks}</div></div></div>{table}'


def _round_times(duration: float) -> list[float]:
    """Up to six round times from 0 on that mark the lanes."""
    step = next((s for s in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500) if duration <= 6 * s), 1000)
    return [float(f"{k * step:.6g}") for k in range(int(duration / step + 1e-9) + 1)]


def _percent(part: float, whole: float) -> str:
    return f"{100 * max(0.0, part) / whole if whole > 0 else 0:.4g}%"


def _time(time: Mapping) -> str:
    share = {name: value or 0.0 for name, value in time["share"].items()}
    order = sorted(share, key=lambda name: (name == "other", -share[name]))
    bars = "".join(
        f'<span class="c{k % 8}" style="width:{100 * share[name]:.4g}%" title="{escape(name)}"></span>'
        for k, name in enumerate(order)
    )
    labels = "".join(
        f'<li><i class="c{k % 8}"></i>{escape(name)} <b>{100 * share[name]:.1f} %</b></li>'
        for k, name in enumerate(order)
    )
    totals = ", ".join(
        f"{label} {_number(time[key])}{' s' if key.endswith('_s') else ''}" for key, label in NAMES_OF_TIME.items()
    )
    return f'<p>{totals}; shares are of the wall time.</p><div class="bar">{bars}</div><ul class="legend">{labels}</ul>'


def _diagram(path: Path | None) -> str:
    if path is None or not path.is_file():
        return ""
    return f'<details><summary>Systems and wires</summary><img class="diagram" alt="diagram" src="{_svg(path.read_bytes())}"></details>'


def _settings(summary: Mapping) -> str:
    settings = _table(["setting", "value"], [[escape(k), escape(str(v))] for k, v in flat(summary["settings"])])
    versions = _table(["package", "version"], [[escape(k), escape(v)] for k, v in summary["versions"].items()])
    return f'<div class="pair">{settings if summary["settings"] else ""}{versions}</div>'
