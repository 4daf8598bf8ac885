"""The report is one page, complete in itself, for every way that a run can end."""

import re
from base64 import b64decode

import cv2
import numpy as np
import pytest
from recording_ticks import CHANNELS, PLOTS, tick

from vipr.systems.recording.channels import Event, VectorChannel
from vipr.systems.recording.diagram_picture import write_diagram
from vipr.systems.recording.history import STILLS, History
from vipr.systems.recording.plots import Line, Plot, PosePlot, draw, pose_errors
from vipr.systems.recording.report import flat, make_report, name_and_unit
from vipr.systems.recording.summary import make_summary, time_figures
from vipr.systems.signals import ObjectPose


def summary(**changes):
    entries = {
        "scenario": "align",
        "seed": 7,
        "success": True,
        "reason": "held the pose",
        "figures": {"final_translation_error_mm": 0.8125, "following_rotation_error_deg": 3.5, "missing_px": np.nan},
        "time": time_figures(10.0, 8.0, {"render": 7.0, "vision": 1.0}),
        "settings": {"servo": {"gain": 1.5}},
    }
    return make_summary(**(entries | changes))


def history(ticks=40):
    grown = History(CHANNELS)
    for k in range(ticks):
        grown.add(0.04 * k, tick(k))
    return grown


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    diagram = tmp_path_factory.mktemp("report") / "diagram.svg"
    diagram.write_text("<svg/>")
    limits = {"final_translation_error_mm": 2.0, "following_rotation_error_deg": 3.0, "missing_px": 1.0}
    return make_report(summary(), history(), plots=PLOTS, limits=limits, diagram=diagram)


def test_the_page_has_all_its_parts(page):
    headings = re.findall("<h2>(.*?)</h2>", page)
    assert headings == [
        "Figures",
        "What the camera saw",
        "Over time",
        "Events",
        "Where the time went",
        "Wiring",
        "Settings and versions",
    ]
    for part in ("align", "seed 7", "Success", "held the pose", "servo.gain", "drake", "70.0 %", "approach"):
        assert part in page
    assert page.count("data:image/svg+xml;base64,") == len(PLOTS) + 1


def test_the_page_needs_nothing_from_elsewhere(page):
    assert not re.search(r"https?://|//\w+\.|<script|<link|@import|url\(|\$", page)
    assert re.findall(r'src="(?!data:image/)', page) == []


def test_figures_have_units_and_are_held_against_what_is_allowed(page):
    rows = re.findall(r"<tr><td>([^<]*)</td><td><b>([^<]*)</b></td><td>(\w+)</td><td><span class='(\w+)'>", page)
    assert rows == [
        ("final translation error", "0.8125", "mm", "good"),
        ("following rotation error", "3.5", "deg", "bad"),
        ("missing", "–", "px", "bad"),
    ]


@pytest.mark.parametrize(
    "figure, shown",
    [
        ("rotation_error_deg", ("rotation error", "deg")),
        ("speed_mm_s", ("speed", "mm/s")),
        ("delay_ms", ("delay", "ms")),
        ("lost_frames", ("lost frames", "")),
    ],
)
def test_a_figure_s_unit_is_the_end_of_its_name(figure, shown):
    assert name_and_unit(figure) == shown


def test_stills_run_from_the_first_image_to_the_last():
    grown = history(200)
    stills = grown.stills()
    times = [time for time, _ in stills]
    assert len(stills) == STILLS
    assert (times[0], times[-1]) == (0.0, pytest.approx(199 * 0.04))
    assert np.diff(times) == pytest.approx(199 * 0.04 / 5, abs=0.5)
    image = cv2.imdecode(np.frombuffer(stills[-1][1], np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(image.astype(int) - tick(199)["camera"].image).max() <= 3


def test_stills_in_the_page_are_pictures(page):
    first = re.search(r'src="data:image/jpeg;base64,([^"]+)"', page).group(1)
    assert cv2.imdecode(np.frombuffer(b64decode(first), np.uint8), cv2.IMREAD_COLOR).shape == (48, 64, 3)


def test_a_run_that_failed_before_its_first_tick_has_a_page():
    page = make_report(
        summary(success=False, reason="camera: <no> light", figures={}), History(CHANNELS), plots=PLOTS, limits={}
    )
    assert "Failure" in page
    assert "camera: &lt;no&gt; light" in page
    assert "before any figure was known" in page
    assert "What the camera saw" not in page


def test_missing_numbers_leave_gaps_and_no_warnings():
    grown = History(CHANNELS)
    for k in range(10):
        nothing = {
            "servo_error": np.array([np.nan, np.inf]),
            "X_CO": ObjectPose(),
            "X_CO_true": np.full((4, 4), np.nan),
        }
        grown.add(0.04 * k, tick(k) | (nothing if k < 5 else {}))
    for plot in PLOTS:
        assert draw(plot, grown).startswith(b"<?xml")
    assert np.isnan(grown.poses("X_CO")[:5]).all()
    assert np.isfinite(grown.poses("X_CO")[5:]).all()


def test_a_pose_plot_shows_the_errors_at_the_exposures_where_a_channel_holds_them():
    names = ("rx", "ry", "rz", "x", "y", "z")
    history = History((*CHANNELS, VectorChannel("tracking_error", names=names, units=("rad",) * 3 + ("m",) * 3)))
    for k in range(3):
        history.add(0.04 * k, tick(k) | {"tracking_error": np.array([0.0, 0.02, 0.0, 0.003, 0.0, 0.004])})
    at_ticks, at_exposures = (PosePlot("object", "X_CO", "X_CO_true", error=e) for e in ("", "tracking_error"))
    np.testing.assert_allclose(pose_errors(at_exposures, history), [[5.0] * 3, [np.rad2deg(0.02)] * 3])
    np.testing.assert_allclose(pose_errors(at_ticks, history)[0][1:], 0.0, atol=1e-9)


def test_plots_are_the_same_bytes_each_time():
    assert draw(PLOTS[0], history(10)) == draw(PLOTS[0], history(10))


def test_a_plot_has_title_axes_units_and_every_line():
    figure = Plot("Joints", "angle", "rad", (Line("q.waist", "waist"), Line("q.shoulder", "shoulder", truth=True)))
    from matplotlib import rc_context

    with rc_context({"svg.fonttype": "none"}):
        svg = draw(figure, history(10)).decode()
    for text in ("Joints", "angle [rad]", "simulated time [s]", "waist", "shoulder"):
        assert f">{text}</text>" in svg


def test_an_unwired_channel_leaves_its_plot_empty():
    grown = History(CHANNELS)
    for k in range(4):
        grown.add(0.04 * k, {"q": tick(k)["q"]})
    for plot in PLOTS:
        draw(plot, grown)
    assert grown.numbers("q.shoulder").shape == (4,)
    assert np.isnan(grown.numbers("servo_error.rotation")).all()


def test_events_stand_in_lanes_and_in_order_of_time():
    grown = history(40)
    grown.events.append(Event(0.1, "scenario", "lamp <off>", "warning"))
    page = make_report(summary(), grown)
    rows = re.findall(r"<tr><td>([\d.]+)</td><td>(\w+)</td><td><span class='(\w+)'>(.*?)</span>", page)
    assert rows == [
        ("0.00", "phase", "info", "approach"),
        ("0.04", "X_CO", "info", "tracking"),
        ("0.10", "scenario", "warning", "lamp &lt;off&gt;"),
        ("0.20", "phase", "info", "hold"),
    ]
    assert page.count('class="lane"') == 4  # three sources and the times


def test_settings_are_shown_by_their_dotted_names():
    assert flat({"a": {"b": {"c": 1}}, "d": [1, 2], "e": {}}) == [("a.b.c", 1), ("d", [1, 2]), ("e", {})]


class Drawn:
    """A diagram as far as the picture goes."""

    def GetGraphvizString(self, max_depth=None):
        return "digraph { camera -> tracker }"


def test_a_diagram_is_drawn(tmp_path):
    from shutil import which

    if which("dot") is None:
        pytest.skip("Graphviz is not installed")
    assert write_diagram(Drawn(), tmp_path / "diagram.svg") == ""
    assert "tracker" in (tmp_path / "diagram.svg").read_text()


def test_without_graphviz_one_line_names_the_cure(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert write_diagram(Drawn(), tmp_path / "diagram.svg") == (
        "no diagram.svg: Graphviz is missing (apt-get install graphviz)"
    )
    assert not (tmp_path / "diagram.svg").exists()
