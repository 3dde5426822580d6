"""Figures of runs: what stands in them is what the folder has, they can be read, and files come out the same."""

from __future__ import annotations

import csv
import itertools
import json
import xml.etree.ElementTree

import matplotlib
import matplotlib.colors
import matplotlib.image
import numpy as np
import pytest

from netdae.core.errors import InputError
from netdae.output.metrics import COLUMNS, CONTACT
from netdae.system.measurements import Cordage
from netdae.system.meeting import TargetColumns
from netdae.visual.plotting.drawing import draw
from netdae.visual.plotting.figures import DESIGNS, NAMES
from netdae.visual.plotting.runs import read_run
from netdae.visual.plotting.sheets import plot

LATER = {*Cordage._fields, *TargetColumns._fields, *CONTACT}
BASE = tuple(name for name in COLUMNS if "impulse" not in name and name not in LATER)
"""As earlier runs have them, which are plotted still."""

SCENARIO = """\
title = "from the scenario"
[[material]]
cables = "all"
strength = 30.0
[[material]]
cables = "border"
strength = 1000.0
"""


def write_folder(
    folder, *, rows=30, size=1.0, title="shot", status="finished", events=(), scenario=SCENARIO, more=()
):
    """A folder as `netdae run` leaves it, with smooth columns; the columns."""
    folder.mkdir(parents=True)
    time = np.linspace(0.0, 1.5, rows)
    table = {"time": time}
    for k, name in enumerate((*BASE[1:], *more)):
        table[name] = size * (k + 1) * np.cos((k + 1) * time)
    text = "\n".join(
        [
            ",".join(table),
            *(",".join(map(repr, map(float, row))) for row in zip(*table.values(), strict=True)),
        ]
    )
    (folder / "metrics.csv").write_text(text + "\n", encoding="utf-8")
    (folder / "scenario.toml").write_text(scenario, encoding="utf-8")
    if status is not None:
        reported = {"title": title, "status": status, "events": list(events)}
        (folder / "summary.json").write_text(json.dumps(reported), encoding="utf-8")
    return table


def happened(name, time):
    return {"name": name, "figure": "distance", "value": 1.0, "action": "none", "time": time, "found": time}


def write_ensemble(folder, members=3):
    """An ensemble's folder of that many members; the members' columns."""
    tables = []
    for k in range(members):
        events = [happened("wide", 1.0 + 0.1 * k), happened("wide", 1.4)]
        tables.append(write_folder(folder / f"member_{k:03d}", size=1.0 + 0.2 * k, events=events))
    columns = {"time": tables[0]["time"]}
    for name in BASE[1:]:
        values = np.array([table[name] for table in tables])
        columns[f"{name}_mean"], columns[f"{name}_std"] = values.mean(axis=0), values.std(axis=0, ddof=1)
        columns[f"{name}_min"], columns[f"{name}_max"] = values.min(axis=0), values.max(axis=0)
    with (folder / "metrics.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows([columns, *zip(*columns.values(), strict=True)])
    reported = [{"folder": f"member_{k:03d}", "status": "finished"} for k in range(members)]
    summary = {"title": "many", "status": "finished", "ensemble": {"finished": members}, "members": reported}
    (folder / "summary.json").write_text(json.dumps(summary))
    return tables


def curves_on(axis, rows):
    """Lines of an axis that have a value for each row: neither events nor strengths."""
    return [line for line in axis.lines if len(line.get_xdata()) == rows]


def drawn(name, *folders):
    return draw(name, [read_run(folder) for folder in folders])


def panel(figure, label):
    """The axis whose label begins so."""
    return next(axis for axis in figure.axes if axis.get_ylabel().replace("\n", " ").startswith(label))


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_every_axis_has_a_name_and_a_unit(tmp_path, name, count):
    folders = [tmp_path / str(k) for k in range(count)]
    for folder in folders:
        write_folder(folder, more=[column for column in COLUMNS if column in LATER])
    figure = drawn(name, *folders)
    units = {"m", "m²", "m/s", "rad/s", "J", "N", "N s", "kg m/s", "kg m²/s", "1"}
    for axis in figure.axes:
        words, unit = axis.get_ylabel().replace("\n", " ").split(", ")
        assert words
        assert unit in units
    below = {axis.get_xlabel() for axis in figure.axes}
    assert below <= {"time, s", ""}
    for axis in figure.axes:  # an axis without time below it stands on another one of its column
        place = axis.get_subplotspec()
        under = [
            other
            for other in figure.axes
            if other.get_subplotspec().rowspan.start == place.rowspan.stop
            and other.get_subplotspec().colspan == place.colspan
        ]
        assert axis.get_xlabel() or under


def test_lines_of_a_run_are_the_columns_of_its_file(tmp_path):
    more = [name for name in COLUMNS if name in LATER]
    table = write_folder(tmp_path / "a", more=more)
    shown = set()
    for name, design in DESIGNS.items():
        figure = drawn(name, tmp_path / "a")
        wanted = [[q.column for q in p.quantities if q.column in table] for p in design.panels]
        wanted = [columns for columns in wanted if columns]
        computed = ("tension / strength", "penetration")
        axes = [axis for axis in figure.axes if not axis.get_ylabel().startswith(computed)]
        for axis, columns in zip(axes, wanted, strict=True):
            lines = curves_on(axis, 30)
            assert len(lines) == len(columns)
            for line, column in zip(lines, columns, strict=True):
                np.testing.assert_array_equal(line.get_xdata(), table["time"])
                np.testing.assert_array_equal(line.get_ydata(), table[column])
                shown.add(column)
    assert shown == {*BASE, *more} - {"contacts"} - {"time", "com_x", "com_y", "com_z"}


def test_several_runs_have_one_line_each_on_every_axis_and_a_legend(tmp_path):
    tables = [write_folder(tmp_path / str(k), size=k + 1, rows=20 + k, title=f"title {k}") for k in range(3)]
    figure = drawn("overview", *(tmp_path / str(k) for k in range(3)))
    assert len(figure.axes) == 16  # 2 areas, distance, 4 energies, residual, tension, 6 momenta, taut share
    for axis in figure.axes:
        assert [len(curves_on(axis, 20 + k)) for k in range(3)] == [1, 1, 1]
    energy = panel(figure, "kinetic energy")
    for k, table in enumerate(tables):
        np.testing.assert_array_equal(curves_on(energy, 20 + k)[0].get_ydata(), table["kinetic_energy"])
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["1  title 0", "2  title 1", "3  title 2"]


def test_legend_tells_runs_of_one_title_by_their_folders(tmp_path):
    for name in "ab":
        write_folder(tmp_path / name)
    figure = drawn("area", tmp_path / "a", tmp_path / "b")
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [f"1  shot, in {tmp_path / 'a'}", f"2  shot, in {tmp_path / 'b'}"]


def test_runs_and_quantities_differ_in_line_and_marker_so_that_grey_is_enough(tmp_path):
    for k in range(4):
        write_folder(tmp_path / str(k), size=k + 1.0)
    of_runs = curves_on(drawn("distance", *(tmp_path / str(k) for k in range(4))).axes[0], 30)
    of_quantities = curves_on(drawn("energy", tmp_path / "0").axes[0], 30)
    for lines in (of_runs, of_quantities):
        assert len(lines) == 4
        for one, other in itertools.combinations(lines, 2):
            assert str(one._dash_pattern) != str(other._dash_pattern)
            assert one.get_marker() != other.get_marker()
        for line in lines:  # darker than half of white: seen on paper
            red, green, blue = matplotlib.colors.to_rgb(line.get_color())
            assert 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.5


def test_events_stand_at_their_times_with_their_names_and_one_that_never_came_does_not(tmp_path):
    events = [happened("wide", 0.5), happened("wide", 0.9), happened("far", 1.25), happened("never", None)]
    write_folder(tmp_path / "a", events=events)
    for axis in drawn("energy", tmp_path / "a").axes:
        upright = [line for line in axis.lines if np.ptp(line.get_xdata()) == 0.0]
        assert sorted(line.get_xdata()[0] for line in upright) == [0.5, 0.9, 1.25]
    names = {text.get_text(): text.xy[0] for text in drawn("area", tmp_path / "a").axes[0].texts}
    assert names == {"wide ×2": 0.5, "far": 1.25}


def test_events_of_several_runs_tell_whose_they_are_and_near_ones_share_a_place(tmp_path):
    write_folder(tmp_path / "a", events=[happened("wide", 0.5), happened("far", 1.25)])
    write_folder(tmp_path / "b", events=[happened("wide", 0.51)])
    texts = drawn("distance", tmp_path / "a", tmp_path / "b").axes[0].texts
    assert [text.get_text() for text in texts] == ["wide [1, 2]", "far [1]"]


def test_event_after_the_last_row_is_on_the_axis(tmp_path):
    write_folder(tmp_path / "a", events=[happened("late", 1.7)])
    assert drawn("area", tmp_path / "a").axes[0].get_xlim() == (0.0, 1.7)


def test_ensemble_is_its_mean_in_a_band_of_all_members(tmp_path):
    tables = write_ensemble(tmp_path / "e")
    figure = drawn("distance", tmp_path / "e")
    values = np.array([table["distance"] for table in tables])
    axis = figure.axes[0]
    (line,) = curves_on(axis, 30)
    np.testing.assert_allclose(line.get_ydata(), values.mean(axis=0), rtol=1e-15)
    (band,) = axis.collections
    corners = {tuple(point) for point in band.get_paths()[0].vertices.tolist()}
    time = tables[0]["time"]
    assert {
        *zip(time, values.min(axis=0), strict=True),
        *zip(time, values.max(axis=0), strict=True),
    } <= corners
    low, high = axis.get_ylim()
    assert low < values.min()
    assert high > values.max()
    assert "range of 3 members" in figure.get_suptitle()


def test_events_of_an_ensemble_are_bands_over_the_members_first_ones(tmp_path):
    write_ensemble(tmp_path / "e")
    (mark,) = read_run(tmp_path / "e").marks
    assert mark.name == "wide"
    # the members' times 1.0, 1.1, 1.2 are exact to round-off
    np.testing.assert_allclose([mark.time, mark.low, mark.high], [1.1, 1.0, 1.2], rtol=1e-15)


def test_run_and_ensemble_go_over_each_other(tmp_path):
    write_folder(tmp_path / "a")
    write_ensemble(tmp_path / "e")
    figure = drawn("overview", tmp_path / "a", tmp_path / "e")
    assert {len(curves_on(axis, 30)) for axis in figure.axes} == {2}
    assert {len(axis.collections) for axis in figure.axes} == {1}


def test_strengths_are_level_lines_and_one_far_above_is_reported_in_words(tmp_path):
    table = write_folder(tmp_path / "a")
    tension, share = drawn("tension", tmp_path / "a").axes
    assert np.abs(table["max_tension"]).max() < 30.0 * 3
    assert [line.get_ydata()[0] for line in tension.lines if len(line.get_xdata()) == 2] == [30.0]
    words = [text.get_text() for text in tension.texts]
    assert words == ["strength 30 N", "strength 1000 N of border, above this scale"]
    assert tension.get_ylim()[1] > 30.0
    np.testing.assert_array_equal(curves_on(share, 30)[0].get_ydata(), table["max_tension"] / 30.0)
    assert [line.get_ydata()[0] for line in share.lines if len(line.get_xdata()) == 2] == [1.0]


def test_strength_of_runs_that_differ_tells_whose_it_is(tmp_path):
    write_folder(tmp_path / "a", scenario="[[material]]\nstrength = 30.0\n")
    write_folder(tmp_path / "b", scenario="[[material]]\nstrength = 40.0\n[tether]\nstrength = 45.0\n")
    words = [text.get_text() for text in drawn("tension", tmp_path / "a", tmp_path / "b").axes[0].texts]
    assert words == ["strength 30 N [1]", "strength 40 N [2]", "strength 45 N of tether [2]"]


def test_run_without_strength_has_no_share_of_it(tmp_path):
    write_folder(tmp_path / "a", scenario="[[material]]\ndensity = 1.0\n")
    assert [axis.get_ylabel() for axis in drawn("tension", tmp_path / "a").axes] == ["largest tension, N"]


def test_strength_of_the_tether_alone_is_on_its_tension(tmp_path):
    write_folder(tmp_path / "a", more=Cordage._fields, scenario=SCENARIO + "[tether]\nstrength = 45.0\n")
    paid_out, tension, distance = drawn("tether", tmp_path / "a").axes
    assert [axis.get_ylabel() for axis in (paid_out, tension, distance)] == [
        "length paid out, m",
        "tether tension, N",
        "distance to chaser, m",
    ]
    assert [text.get_text() for text in tension.texts] == ["strength 45 N of tether"]
    assert [line.get_ydata()[0] for line in tension.lines if len(line.get_xdata()) == 2] == [45.0]
    assert [len(axis.lines) for axis in (paid_out, distance)] == [1, 1]


def test_runs_without_a_tether_have_no_figure_of_it_and_a_locked_one_has_no_length_paid_out(tmp_path):
    write_folder(tmp_path / "old")
    assert drawn("tether", tmp_path / "old") is None
    write_folder(tmp_path / "locked", more=Cordage._fields)
    file = tmp_path / "locked" / "metrics.csv"
    header, *rows = [line.split(",") for line in file.read_text().splitlines()]
    without = {header.index(name) for name in ("paid_out", "closing_length", "closing_tension")}
    rows = [["nan" if k in without else value for k, value in enumerate(row)] for row in rows]
    file.write_text("".join(",".join(row) + "\n" for row in [header, *rows]))
    labels = [axis.get_ylabel() for axis in drawn("tether", tmp_path / "locked").axes]
    assert labels == ["tether tension, N", "distance to chaser, m"]
    assert drawn("closing", tmp_path / "locked") is None
    figure = drawn("tether", tmp_path / "old", tmp_path / "locked")
    assert [len(curves_on(axis, 30)) for axis in figure.axes] == [1, 1]
    assert (
        len(drawn("overview", tmp_path / "locked").axes) == len(drawn("overview", tmp_path / "old").axes) + 2
    )


def test_momentum_less_the_external_impulse_is_drawn_where_the_file_has_impulses(tmp_path):
    more = [f"external_{kind}_{axis}" for kind in ("impulse", "angular_impulse") for axis in "xyz"]
    table = write_folder(tmp_path / "a", more=more)
    axes = drawn("momentum", tmp_path / "a").axes
    assert len(axes) == 4
    assert set(more) <= {*COLUMNS}
    for row, (kind, impulse) in enumerate((("momentum", "impulse"), ("angular_momentum", "angular_impulse"))):
        for line, axis in zip(curves_on(axes[2 + row], 30), "xyz", strict=True):
            kept = table[f"{kind}_{axis}"] - table[f"external_{impulse}_{axis}"]
            np.testing.assert_array_equal(line.get_ydata(), kept)


def test_impulses_of_nothing_have_no_axes_of_their_own(tmp_path):
    more = [name for name in COLUMNS if "impulse" in name]
    write_folder(tmp_path / "a", more=more)
    file = tmp_path / "a" / "metrics.csv"
    rows = [line.split(",") for line in file.read_text().splitlines()]
    text = [
        ",".join([*row[: len(BASE)], *(["0.0"] * len(more) if k else more)]) for k, row in enumerate(rows)
    ]
    file.write_text("\n".join(text) + "\n")
    assert len(drawn("momentum", tmp_path / "a").axes) == 2


def test_components_of_several_runs_have_one_scale(tmp_path):
    for name in "ab":
        write_folder(tmp_path / name)
    figure = drawn("momentum", tmp_path / "a", tmp_path / "b")
    limits = {}
    for axis in figure.axes:
        limits.setdefault(axis.get_ylabel().split(" ")[0], set()).add(axis.get_ylim())
    assert {name: len(found) for name, found in limits.items()} == {"momentum": 1, "angular": 1}


def test_round_off_about_a_constant_is_a_flat_line(tmp_path):
    table = write_folder(tmp_path / "a")
    noisy = table["distance"] * 1e-14 + 3.5
    text = (tmp_path / "a" / "metrics.csv").read_text().splitlines()
    rows = [line.split(",") for line in text]
    for row, value in zip(rows[1:], noisy.tolist(), strict=True):
        row[COLUMNS.index("distance")] = repr(value)
    (tmp_path / "a" / "metrics.csv").write_text("".join(",".join(row) + "\n" for row in rows))
    low, high = drawn("distance", tmp_path / "a").axes[0].get_ylim()
    assert high - low > 1e-3


def test_stopped_and_killed_runs_are_drawn_as_far_as_they_came(tmp_path):
    write_folder(tmp_path / "failed", rows=9, status="failed: step too small", title="one")
    write_folder(tmp_path / "killed", rows=12, status=None)
    with (tmp_path / "killed" / "metrics.csv").open("a") as stream:
        stream.write("1.6,2.0,3.")  # cut short in writing
    figure = drawn("area", tmp_path / "failed", tmp_path / "killed")
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["1  one, failed at t = 1.5 s", "2  from the scenario, unfinished at t = 1.5 s"]
    assert [len(curves_on(axis, 9)) + len(curves_on(axis, 12)) for axis in figure.axes] == [2, 2]


def test_column_without_a_number_is_left_out(tmp_path):
    write_folder(tmp_path / "a")
    file = tmp_path / "a" / "metrics.csv"
    rows = [line.split(",") for line in file.read_text().splitlines()]
    file.write_text(
        "".join(
            ",".join([row[0], *(["nan"] * 2 if k else row[1:3]), *row[3:]]) + "\n"
            for k, row in enumerate(rows)
        )
    )
    assert drawn("area", tmp_path / "a") is None
    assert len(drawn("overview", tmp_path / "a").axes) == 8
    files = plot(tmp_path / "a", tmp_path / "o", formats=("svg",))
    assert [f.stem for f in files] == [
        name for name in NAMES if name not in ("area", "tether", "closing", "contact", "target")
    ]
    with pytest.raises(InputError, match=r"area cannot be drawn: .* has no numbers for it"):
        plot(tmp_path / "a", tmp_path / "p", only=("area",))
    assert not (tmp_path / "p").exists()


def test_files_are_whole_not_blank_and_the_same_when_made_again(tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    write_folder(tmp_path / "a", title="a <b> & $c$", events=[happened("x < y & z", 0.5)])
    write_folder(tmp_path / "b")
    folders = (tmp_path / "a", tmp_path / "b")
    files = plot(folders, tmp_path / "one", only=("energy", "area"))
    assert [file.name for file in files] == ["area.png", "area.svg", "energy.png", "energy.svg"]
    with matplotlib.rc_context({"axes.facecolor": "black", "font.size": 30.0}):  # a user's own style
        again = plot(folders, tmp_path / "two", only=("energy", "area"))
    assert [file.read_bytes() for file in again] == [file.read_bytes() for file in files]
    pixels = matplotlib.image.imread(files[0])[..., :3]
    assert min(pixels.shape[:2]) > 400
    inked = (np.abs(pixels - 1.0) > 0.1).any(axis=-1)
    assert 0.005 < inked.mean() < 0.5
    assert not inked[:, [0, -1]].any()  # nothing is cut off at the sides
    root = xml.etree.ElementTree.fromstring(files[1].read_bytes())
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert b"<dc:date>" not in files[1].read_bytes()
    assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) > 20


def test_pictures_go_beside_the_run_or_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in "ab":
        write_folder(tmp_path / name)
    assert plot("a", only=("taut",), formats=("svg",)) == [
        tmp_path.joinpath("a/plots/taut.svg").relative_to(tmp_path)
    ]
    assert [str(file) for file in plot(["a", "b"], only=("taut",), formats=("svg",))] == ["plots/taut.svg"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        (",".join(BASE) + "\n", "no rows"),
        (",".join(BASE) + "\n" + ",".join("0" * len(BASE)) + "\n", "one row, at t = 0 s"),
        ("a,b\n1,2\n2,3\n", "first line is 'a,b'"),
        (
            ",".join(BASE) + "\n1,2\n" + ",".join("1" * len(BASE)) + "\n",
            "line 2 has 2 fields, expected 20",
        ),
        ("time,distance\n0,1\n1,far\n2,3\n", "line 3"),
        ("time,distance\n0,1\nnan,2\n", "a time that is not a finite number"),
        ("time,distance\n0,nan\n1,nan\n", "nothing can be drawn"),
    ],
)
def test_table_without_a_course_is_refused(tmp_path, text, words):
    write_folder(tmp_path / "a")
    (tmp_path / "a" / "metrics.csv").write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        plot(tmp_path / "a")
    assert str(tmp_path / "a") in str(caught.value)
    assert not (tmp_path / "a" / "plots").exists()


def test_summary_that_is_not_json_is_reported(tmp_path):
    write_folder(tmp_path / "a")
    (tmp_path / "a" / "summary.json").write_text("{")
    with pytest.raises(InputError, match=r"summary.json is not JSON"):
        plot(tmp_path / "a")


def test_formats_and_folders_are_checked(tmp_path):
    write_folder(tmp_path / "a")
    with pytest.raises(InputError, match="'pdf' is not a format of a picture"):
        plot(tmp_path / "a", formats=("pdf",))
    with pytest.raises(InputError, match="no folder is given"):
        plot([])
