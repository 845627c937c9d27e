"""Plots from arrays: extremes and gaps survive, every axis has its unit, colours stay with their model."""

import base64
import json
from html import unescape

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from run_bag.report import (
    Axis,
    Bars,
    Panel,
    Report,
    ReportError,
    Residual,
    Series,
    Span,
    Track,
    bars,
    curves,
    heat_map,
    needles,
    residuals,
    space,
    time_series,
)
from run_bag.report.decimation import compact, keep_extremes
from run_bag.report.legend import legend
from run_bag.report.plots.plot import Plot
from run_bag.report.theme import FITS, MEASURED, dark_partner

SPEED = Axis(name="rotor speed", unit="rad/s", symbol="n")
THRUST = Axis(name="thrust", unit="N", symbol="T")


@given(
    st.lists(st.one_of(st.floats(-1e6, 1e6), st.just(float("nan"))), min_size=1, max_size=400),
    st.integers(4, 100),
)
@settings(max_examples=150, deadline=None)
def test_reduction_keeps_ends_and_extremes_and_does_not_bridge_gaps(values: list[float], points: int) -> None:
    y = np.array(values)
    kept = keep_extremes(y, max_points=points)
    assert (np.diff(kept) > 0).all()
    assert kept[0] == 0 and kept[-1] == y.size - 1
    assert np.isfinite(y[kept]).sum() <= max(points, 4) + 2 or y.size <= points
    if np.isfinite(y).any():
        assert np.nanmin(y[kept]) == np.nanmin(y) and np.nanmax(y[kept]) == np.nanmax(y)
    assert np.isnan(y[kept]).any() == np.isnan(y).any()


def test_one_sample_of_a_million_that_sticks_out_is_drawn() -> None:
    y = np.zeros(1_000_000)
    y[123_457] = 1.0
    plot = curves([Series(name="a", x=np.arange(y.size), y=y)], x=SPEED, y=THRUST, max_points=1000)
    drawn = plot.figure.data[0]
    assert drawn.y.max() == 1.0 and drawn.x[np.argmax(drawn.y)] == 123_457
    assert len(drawn.y) <= 1002
    assert "about 1000 of up to 1000000" in plot.notes[0]


def test_short_series_are_drawn_whole_without_a_note() -> None:
    plot = curves([Series(name="a", x=np.arange(50), y=np.arange(50))], x=SPEED, y=THRUST)
    assert len(plot.figure.data[0].y) == 50 and plot.notes == ()


def test_time_stamps_since_1970_keep_double_precision() -> None:
    assert compact(1.7e9 + np.arange(10) * 0.04).dtype == np.float64
    assert compact(np.arange(0, 60, 0.01)).dtype == np.float32
    assert np.isnan(compact([1.0, np.inf])[1])


def all_plots() -> list[object]:
    t = np.arange(10.0)
    line = Series(name="fit", x=t, y=t, low=t - 1, high=t + 1)
    both = residuals(
        [Residual(name="fit", time=t, value=t, frequency=t, density=t + 1)], quantity=THRUST, noise_floor=1
    )
    return [
        time_series([Panel(axis=SPEED, series=[line]), Panel(axis=THRUST, series=[line])], spans=[Span(1, 2, "out")]),
        curves([line], x=SPEED, y=THRUST),
        *both,
        bars(["a", "b"], [Bars(name="v", value=[1, 2], low=[0, 1], high=[2, 3])], quantity=THRUST),
    ]


@pytest.mark.parametrize("plot", all_plots())
def test_every_axis_names_its_unit(plot) -> None:  # type: ignore[no-untyped-def]
    axes = [a for n, a in plot.figure.layout.to_plotly_json().items() if n[1:5] == "axis"]
    assert axes
    assert all(a.get("type") == "category" or a["title"]["text"].endswith("]") for a in axes)


def test_an_axis_without_unit_is_refused() -> None:
    with pytest.raises(ReportError, match=r"expected a name and a unit"):
        Axis(name="thrust", unit="")


def a_path(**options: object) -> Plot:
    east, north, depth = (Axis(name=name, unit="m") for name in ("east", "north", "depth"))
    path = Track(name="path", x=np.arange(5000.0), y=np.zeros(5000), z=np.sin(np.arange(5000.0)))
    there = needles("forward", np.zeros((2, 3)), np.ones((2, 3)))
    return space([path, there], x=east, y=north, z=depth, **options)  # type: ignore[arg-type]


def test_axes_in_space_name_their_units_and_depth_grows_downwards_where_it_is_asked_for() -> None:
    scene = a_path(z_down=True).figure.layout.scene
    assert [axis.title.text for axis in (scene.xaxis, scene.yaxis, scene.zaxis)] == [
        "east [m]",
        "north [m]",
        "depth [m]",
    ]
    assert scene.zaxis.autorange == "reversed" and scene.aspectmode == "data"
    assert a_path().figure.layout.scene.zaxis.autorange is None


def test_needles_are_pieces_with_gaps_and_a_long_path_keeps_its_extremes() -> None:
    path, forward = a_path(max_points=600).figure.data
    assert len(path.x) < 700 and max(path.z) == pytest.approx(np.sin(np.arange(5000.0)).max(), abs=1e-6)
    assert list(forward.x[:2]) == [0.0, 1.0] and np.isnan(forward.x[2]) and len(forward.x) == 6


def test_tracks_of_unequal_length_and_an_empty_space_are_refused() -> None:
    with pytest.raises(ReportError, match=r"expected x, y and z of one shape"):
        Track(name="a", x=[0.0], y=[0.0], z=[0.0, 1.0])
    with pytest.raises(ReportError, match="expected start and end of one shape"):
        needles("a", [0.0], [1.0])
    with pytest.raises(ReportError, match="expected at least one track"):
        space([], x=SPEED, y=SPEED, z=SPEED)


def test_panels_share_one_time_axis_so_that_they_zoom_together() -> None:
    plot = all_plots()[0]
    traces = plot.figure.data  # type: ignore[attr-defined]
    assert {t.xaxis for t in traces if t.xaxis} == {"x"}
    assert {t.yaxis for t in traces if t.yaxis} == {"y", "y2"}


def test_a_model_keeps_the_colour_it_was_given_and_data_are_grey() -> None:
    t = np.arange(3.0)
    series = [
        Series(name="first", x=t, y=t),
        Series(name="second", x=t, y=t, color=0),
        Series(name="measured", x=t, y=t, role="data"),
    ]
    colours = {t.name: t.line.color for t in curves(series, x=SPEED, y=THRUST).figure.data}
    assert colours == {"first": FITS[1], "second": FITS[0], "measured": MEASURED}


def luminance(colour: str) -> float:
    channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("colour", [*FITS, MEASURED])
def test_every_series_colour_has_contrast_on_its_page(colour: str) -> None:
    assert 1.05 / (luminance(colour) + 0.05) > 3.5
    assert (luminance(dark_partner(colour)) + 0.05) / (luminance("#15181c") + 0.05) > 3.5


def test_the_legend_lists_each_name_once_and_as_text() -> None:
    t = np.arange(3.0)
    name = "<b>run</b> & co"
    panels = [Panel(axis=SPEED, series=[Series(name=name, x=t, y=t, low=t, high=t)])] * 3
    html = legend(trace for trace in time_series(panels).figure.to_dict()["data"])
    assert html.count("<button") == 1
    assert "</svg>&lt;b&gt;run&lt;/b&gt; &amp; co</button>" in html
    assert unescape(unescape(html.split('data-group="')[1].split('"')[0])) == name


def test_ten_runs_of_five_channels_stay_below_three_megabytes_besides_plotly() -> None:
    from plotly.offline import get_plotlyjs

    t, rng = np.arange(500) * 0.04, np.random.default_rng(1)
    report = Report("Size")
    for k in range(10):
        series = [Series(name=f"s{i}", x=t, y=rng.normal(size=t.size)) for i in range(4)]
        report.figure(time_series([Panel(axis=SPEED, series=series)] * 5), caption=f"run {k}", alt="noise")
    assert len(report.html()) - len(get_plotlyjs()) < 3_000_000


def test_the_embedded_data_are_the_data() -> None:
    report = Report("T")
    report.figure(curves([Series(name="a", x=[0, 1, 2], y=[1, np.nan, 3])], x=SPEED, y=THRUST), caption="c", alt="a")
    embedded = report.html().split('<script type="application/json">')[1].split("</script>")[0]
    trace = json.loads(embedded)["data"][0]["y"]
    assert trace["dtype"] == "f4"
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(trace["bdata"]), "<f4"), [1, np.nan, 3])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Series(name="a", x=[0, 1], y=[0]), r"y has shape \(1,\), expected \(2,\)"),
        (lambda: Series(name="a", x=[0, np.nan], y=[0, 1]), "x is not finite"),
        (lambda: Series(name="a", x=[0], y=[0], low=[0]), "expected both or neither"),
        (lambda: time_series([]), "at least one panel"),
        (lambda: curves([], x=SPEED, y=THRUST), "at least one series"),
        (
            lambda: bars(["a"], [Bars(name="v", value=[1, 2])], quantity=THRUST),
            r"expected values of shape \(1,\)",
        ),
        (lambda: heat_map(np.eye(3), columns=["a", "b"]), r"expected shape \(2, 2\)"),
    ],
)
def test_arrays_that_do_not_match_are_refused(build, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ReportError, match=message):
        build()


def test_bars_leave_room_for_labels_of_several_lines():
    def height(label):
        return bars([label] * 4, [Bars(name="one", value=[1.0] * 4)], quantity=Axis(name="size", unit="N")).height

    assert height("+ viscous friction of the rotor of thruster 2") >= 4 * 45 > height("short") - 62
