"""What of plotly.js a page carries: as little as draws it, unpacked to what npm publishes."""

import base64
import gzip
import re

import plotly.graph_objects as go
import pytest
from plotly.offline import get_plotlyjs

from run_bag.report import Axis, Report, Series, Track, curves, space
from run_bag.report.library import libraries_for

X = Axis(name="x", unit="m")


@pytest.mark.parametrize(
    ("types", "names"),
    [
        (set(), []),
        ({"scatter", "bar", "heatmap"}, ["cartesian"]),
        ({"scatter3d", "scatter"}, ["gl3d"]),
        ({"scatter3d", "bar"}, ["cartesian", "gl3d"]),
        ({"scatterpolar", "bar"}, ["full"]),
    ],
)
def test_the_smallest_bundles_that_draw_everything_are_chosen(types: set[str], names: list[str]) -> None:
    assert [each.name for each in libraries_for(types)] == names


@pytest.mark.parametrize("types", [{"bar"}, {"scatter3d"}, {"scatterpolar"}], ids=["flat", "space", "all"])
def test_a_bundle_is_the_version_that_the_python_package_describes_and_draws_the_types(types: set[str]) -> None:
    (library,) = libraries_for(types)
    script = gzip.decompress(library.packed).decode("utf-8")
    versions = [re.search(r"v(\d+\.\d+)\.\d+", text[:200]) for text in (script, get_plotlyjs())]
    assert versions[0] and versions[1] and versions[0][1] == versions[1][1]
    for kind in types:
        assert f'name:"{kind}"' in script or f'type:"{kind}"' in script


def test_the_notice_stands_in_plain_text_and_the_packed_script_is_the_bundle() -> None:
    (library,) = libraries_for({"bar"})
    found = library.render()
    assert "Licensed under the MIT license" in found.partition("<script")[0]
    data = re.search(r">([A-Za-z0-9+/=]+)</script>", found)
    assert data and base64.b64decode(data[1]) == library.packed


def test_a_page_without_data_stays_below_a_megabyte_and_one_in_space_too() -> None:
    flat, solid = Report("Flat"), Report("In space")
    flat.figure(curves([Series(name="a", x=[0, 1], y=[0, 1])], x=X, y=X), caption="c", alt="a")
    solid.figure(space([Track(name="a", x=[0, 1], y=[0, 1], z=[0, 1])], x=X, y=X, z=X), caption="c", alt="a")
    assert len(flat.html()) < 750_000
    assert len(solid.html()) < 850_000


def test_a_figure_of_plotly_s_own_is_drawn_by_the_whole_library() -> None:
    report = Report("Any figure")
    report.figure(go.Figure(go.Scatterpolar(r=[1, 2], theta=[0, 90])), caption="c", alt="a")
    assert 'data-name="full"' in report.html()
