"""The ready layouts for Foxglove and PlotJuggler: all that they name is in a run that the vehicle's graph recorded."""

import json
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy

from run_bag import Run, read_run
from run_bag.reader import read_recording

CONFIG = Path(__file__).resolve().parents[1] / "rov_sim" / "config"
DRAWN = ("/tf", "/rov/attitude", "/rov/path", "/rov/scene")


@pytest.fixture(scope="module")
def dive(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A short dive with its scene, as `rov_experiment.sh --scene` records it."""
    from graph_context import a_context
    from vehicle_graph import SCRIPT, Graph

    folder = tmp_path_factory.mktemp("layouts")
    (folder / "script.yaml").write_text(SCRIPT, "utf-8")
    context = a_context()
    graph = Graph(
        context, folder / "script.yaml", record=folder / "dive", scene=True, feedback="estimator", handing_over=True
    )
    try:
        graph.run(40)
        assert graph.until(lambda: len(graph.listener.of("rov/path")) > 1)
    finally:
        graph.close()
        rclpy.try_shutdown(context=context)
    yield folder / "dive"


@pytest.fixture(scope="module")
def run(dive: Path) -> Run:
    return read_run(dive)


def foxglove() -> dict[str, Any]:
    return dict(json.loads((CONFIG / "foxglove.json").read_text("utf-8"))["configById"])


def test_every_line_of_foxglove_s_plots_is_a_channel_of_the_dive(run: Run) -> None:
    lines = [line["value"] for name, panel in foxglove().items() if name.startswith("Plot!") for line in panel["paths"]]
    assert len(lines) > 40
    assert [line for line in lines if not line.startswith("/") or line[1:] not in run] == []


def test_every_topic_that_foxglove_shows_otherwise_is_in_the_dive(dive: Path) -> None:
    there = {raw.topic for one in read_recording(dive, set()).scans for raw in one.topics.values()}
    assert set(DRAWN) <= there
    assert set(foxglove()["3D!scene"]["topics"]) <= there
    assert foxglove()["DiagnosticSummary!nodes"]["topicToRender"] in there


def test_every_curve_of_plotjuggler_is_a_channel_of_the_dive(run: Run) -> None:
    curves = ElementTree.parse(CONFIG / "plotjuggler.xml").getroot().iter("curve")
    names = [str(curve.get("name")) for curve in curves]
    channels = {re.sub(r"\.", "/", f"/{name}") for name in run}
    assert len(names) > 40
    assert [name for name in names if name not in channels] == []


def test_every_channel_that_the_layouts_show_has_been_measured(run: Run) -> None:
    lines = [line["value"][1:] for name, p in foxglove().items() if name.startswith("Plot!") for line in p["paths"]]
    assert [name for name in lines if np.isnan(run[name].values).all()] == []
