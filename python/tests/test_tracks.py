"""Tracks in the forms of other programs, judged by these: label images of the Cell Tracking Challenge, GEFF, layers of
napari, pandas and networkx; and what compare says of two series, judged by SimpleITK."""

import csv
import importlib
import re
import sys

import numpy as np
import pytest
import t4d
from t4d import verbs

tifffile = pytest.importorskip("tifffile")

SIZE = (40, 30, 20)


def balls(*all_):
    """The points of the lattice in balls, each (centre, radius)."""
    points = np.moveaxis(np.indices(SIZE), 0, -1)
    return np.any([((points - centre) ** 2).sum(-1) < radius**2 for centre, radius in all_], axis=0)


def dividing(t):
    """A cell that divides after frame 6; one that vanishes after frame 4; one that stays."""
    return [((10, 15 - 0.6 * t, 10), 4.5), ((10, 15 + 0.6 * t, 10), 4.5), ((30, 8, 10), 3.5),
            *([((30, 22, 10), 3)] if t < 5 else [])]  # fmt: skip


@pytest.fixture(scope="module")
def masks():
    return np.array([balls(*dividing(t)) for t in range(9)])


@pytest.fixture(scope="module")
def cells(masks, tmp_path_factory):
    path = tmp_path_factory.mktemp("cells") / "cells.t4d"
    t4d.weave(masks, units=("um", "min")).save(path)
    return path


def ctc(folder):
    """Labels (t, x, y, z) and the lines of res_track.txt, by label. Checks the rules of the format."""
    files = sorted(folder.glob("mask*.tif"))
    labels = np.array([np.moveaxis(tifffile.imread(file), 0, -1).swapaxes(0, 1) for file in files])
    assert labels.dtype == np.uint16 and [file.name for file in files] == [f"mask{i:03}.tif" for i in range(len(files))]
    rows = np.loadtxt(folder / "res_track.txt", dtype=int, ndmin=2)
    lines = {label: tuple(rest) for label, *rest in rows.tolist()}
    assert len(lines) == len(rows) and min(lines) > 0
    for t, frame in enumerate(labels):
        there = {label for label, (first, last, _) in lines.items() if first <= t <= last}
        assert there == set(np.unique(frame).tolist()) - {0}
    for first, last, parent in lines.values():
        assert first <= last and (parent == 0 or lines[parent][1] < first)
    return labels, lines


def test_labels_at_frames_are_the_components_of_the_masks(cells, masks, tmp_path):
    measure = pytest.importorskip("skimage.measure")
    verbs.track(cells, ctc=tmp_path / "RES", origin=(0, 0, 0), size=SIZE)
    labels, lines = ctc(tmp_path / "RES")
    assert np.array_equal(labels > 0, masks)
    for frame, mask in zip(labels, masks):
        components, count = measure.label(mask, connectivity=3, return_num=True)
        pairs = {*zip(components.ravel().tolist(), frame.ravel().tolist())}
        assert len(pairs) == count + 1  # one label for each component
    found = t4d.read(cells).tracks()
    assert {label: parent for label, (_, _, parent) in lines.items()} == {
        track: (before[0] if before else 0) for track, before in zip(found.tracks["id"].tolist(), found.tracks["from"])}
    # Each is there in the frames of its life.
    for label, begin, end in zip(found.tracks["id"].tolist(), found.tracks["begin"], found.tracks["end"]):
        assert lines[label][:2] == (np.ceil(begin), np.ceil(end) - (end < 8))


def test_a_track_without_voxels_in_a_frame_goes_on_as_a_child(tmp_path):
    there_and_back = {"segments": [{"duration": 2, "translation": [20, 0, 0]}, {"duration": 2, "translation": [-20, 0, 0]}]}
    corner = [[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    t4d.sweep(*corner, there_and_back).save(tmp_path / "back.t4d")
    image = {"origin": (0.25, 0.25, 0.25), "size": (13, 3, 3)}  # which it leaves in frame 2
    verbs.track(tmp_path / "back.t4d", ctc=tmp_path / "back", times=(0, 1, 2, 3, 4), **image)
    assert ctc(tmp_path / "back")[1] == {1: (0, 1, 0), 2: (3, 4, 1)}
    # A series with fewer frames would leave some of this one.
    with pytest.raises(t4d.VerbError, match=r"mask00\d.tif, which would pass for a frame"):
        verbs.track(tmp_path / "back.t4d", ctc=tmp_path / "back", times=(0, 1), **image)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mask000.tif").touch()
    with pytest.raises(t4d.VerbError, match="the folder has other files"):
        verbs.track(tmp_path / "back.t4d", ctc=tmp_path / "full", times=(0, 1), **image)


def test_mergers_have_one_parent_and_other_links_are_counted(masks, tmp_path, capfd):
    t4d.weave(masks[::-1].copy()).save(tmp_path / "merging.t4d")
    found = t4d.read(tmp_path / "merging.t4d").tracks()
    child = next(i for i, before in enumerate(found.tracks["from"]) if len(before) == 2)
    printed = t4d.commands.run_words(["track", "merging.t4d", "--ctc", "m", "--origin", "0,0,0"], cwd=str(tmp_path), text=True)
    assert "left out: 1 further link of mergers" in printed
    _, lines = ctc(tmp_path / "m")
    assert lines[int(found.tracks["id"][child])][2] in found.tracks["from"][child]


def test_colours_of_tracks_are_those_of_the_lineage(cells, tmp_path):
    verbs.track(cells, o=tmp_path / "lineage.svg")
    bands = re.findall(r'<polygon fill="#(\w+)"[^>]*><title>(\d+) ', (tmp_path / "lineage.svg").read_text())
    lineage = {int(track): tuple(bytes.fromhex(color)) for color, track in bands}
    verbs.slice(cells, time=7.9, color="track", attributes=True, output=tmp_path / "cells.ply")
    made = t4d.read_triangles(tmp_path / "cells.ply")
    bytes_ = (tmp_path / "cells.ply").read_bytes()
    row = [("count", "u1"), ("corners", "<i4", 3), ("color", "u1", 4), ("track", "<u4")]
    triangles = np.frombuffer(bytes_[-len(made.triangles) * np.dtype(row).itemsize :], row)
    tracks = triangles["track"]
    found = t4d.read(cells).tracks()
    alive = [i for i, begin, end in zip(found.tracks["id"], found.tracks["begin"], found.tracks["end"])
             if begin <= 7.9 < end]
    assert sorted(set(tracks.tolist())) == alive and [*lineage] == found.tracks["id"].tolist()
    assert len({*lineage.values()}) == len(lineage)
    volumes = dict(zip(found.tracks["id"].tolist(), found.tracks["largest_volume"]))
    for track in alive:
        (color,) = {tuple(rgb) for rgb in triangles["color"][tracks == track, :3].tolist()}
        assert np.abs(np.subtract(color, lineage[track])).max() <= 1
        part = t4d.TriangleMesh(made.vertices, made.triangles[tracks == track])
        assert 0 < part.volume <= volumes[track] * 1.05


def test_tables_are_taken_by_pandas_and_networkx(cells):
    pandas, networkx = pytest.importorskip("pandas"), pytest.importorskip("networkx")
    found = t4d.read(cells).tracks()
    tracks, samples = pandas.DataFrame(found.tracks), pandas.DataFrame(found.samples)
    assert len(tracks) == len(found.tracks["id"]) and len(pandas.DataFrame(found.events)) == len(found.events["time"])
    largest = samples.groupby("track")["volume"].max()
    assert (largest.loc[tracks["id"]].to_numpy() == tracks["largest_volume"].to_numpy()).all()
    graph = networkx.DiGraph(found.links)
    assert {*graph.edges} == {(one, into) for one, into, _ in found.links} and networkx.is_directed_acyclic_graph(graph)


def test_napari_gets_tracks_in_the_order_it_asks_for(cells):
    found = t4d.read(cells).tracks()
    data, properties, graph = found.napari()
    assert data.shape == (len(found.samples["time"]), 5) and {len(column) for column in properties.values()} == {len(data)}
    assert (np.lexsort((data[:, 1], data[:, 0])) == np.arange(len(data))).all()  # by track, then by frame
    assert (data[:, :2] == data[:, :2].astype(int)).all() and data[:, 1].min() == 0
    assert (properties["time"] == data[:, 1]).all()  # frames are a minute apart, from 0
    assert {*graph}.union(*graph.values()) <= {*data[:, 0]} and graph


def test_geff_is_valid_and_has_every_sample_and_link(cells, tmp_path):
    geff = pytest.importorskip("geff")
    found = t4d.read(cells).tracks()
    found.save_geff(tmp_path / "cells.geff")
    importlib.import_module("geff.validate.structure").validate_structure(str(tmp_path / "cells.geff"))
    graph, metadata = geff.read(tmp_path / "cells.geff")
    assert graph.number_of_nodes() == len(found.samples["time"])
    assert [(axis.name, axis.unit) for axis in metadata.axes] == [("t", "minute"), *((name, "micrometer") for name in "zyx")]
    at = graph.nodes
    within = [(a, b) for a, b in graph.edges if at[a]["track"] == at[b]["track"]]
    between = {(at[a]["track"], at[b]["track"]) for a, b in graph.edges if at[a]["track"] != at[b]["track"]}
    assert between == {(one, into) for one, into, _ in found.links}
    assert len(within) == len(found.samples["time"]) - len(found.tracks["id"])
    assert all(at[a]["t"] < at[b]["t"] for a, b in graph.edges)
    valid, wrong = importlib.import_module("geff.validate.tracks").validate_tracklets(
        np.array([*at]), np.array([*graph.edges]), np.array([at[node]["tracklet"] for node in at]))
    assert valid, wrong
    with pytest.raises(t4d.FileError, match="exists already"):
        found.save_geff(tmp_path / "cells.geff")
    assert not [*tmp_path.glob(".geff*")]


def test_geff_without_zarr_names_the_extra(cells, tmp_path, monkeypatch):
    found = t4d.read(cells).tracks(times=(0, 1))
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(t4d.Unsupported, match=r"t4d\[zarr\]"):
        found.save_geff(tmp_path / "cells.geff")


def test_compare_agrees_with_simpleitk_to_sampling(tmp_path):
    itk = pytest.importorskip("SimpleITK")
    spacing, size = 0.25, (160, 120, 80)
    for name, shift in (("a", 0.0), ("b", 1.5)):
        frames = [balls(((12 + shift + t, 15, 10), 6)) | balls(((26, 15 + shift / 2, 10), 4.5)) for t in range(2)]
        t4d.weave(np.array(frames)).save(tmp_path / f"{name}.t4d")
        verbs.track(tmp_path / f"{name}.t4d", ctc=tmp_path / name, times=(0.25, 0.75), spacing=spacing, origin=(0, 0, 0), size=size)
    found = verbs.compare(tmp_path / "a.t4d", tmp_path / "b.t4d", times="0.25,0.75").slices
    for frame, one in enumerate(found):
        images = [itk.GetImageFromArray((tifffile.imread(tmp_path / name / f"mask{frame:03}.tif") > 0).astype(np.uint8)) for name in "ab"]
        for image in images:
            image.SetSpacing([spacing] * 3)
        overlap = itk.LabelOverlapMeasuresImageFilter()
        overlap.Execute(*images)
        assert abs(one["dice"] - overlap.GetDiceCoefficient()) < 2e-3
        assert abs(one["jaccard"] - overlap.GetJaccardCoefficient()) < 3e-3
        distances = []
        for this, other in (images, images[::-1]):
            far = itk.GetArrayFromImage(itk.Abs(itk.SignedMaurerDistanceMap(other, squaredDistance=False, useImageSpacing=True)))
            distances.append(far[itk.GetArrayFromImage(itk.LabelContour(this, True)) > 0])
        # Contours are voxels, half of one inside the surface.
        assert abs(one["hausdorff"] - max(part.max() for part in distances)) < 1.5 * spacing
        assert abs(one["hausdorff_95"] - max(np.quantile(part, 0.95) for part in distances)) < spacing
        assert abs(one["mean_distance"] - np.concatenate(distances).mean()) < spacing
        volumes = [itk.GetArrayViewFromImage(image).sum() * spacing**3 for image in images]
        assert abs(one["volume_difference"] - (volumes[1] - volumes[0])) < 0.01 * volumes[0]


def test_compare_has_a_row_for_each_body(tmp_path):
    labels = np.array([balls(((10, 15, 10), 5)).astype(np.uint8) + 2 * balls(((28, 15, 10), 5))] * 2)
    t4d.weave(labels, label="all").save(tmp_path / "a.t4d")
    t4d.weave(np.where(labels == 2, 0, labels), label=1, name="solid 1").save(tmp_path / "b.t4d")
    verbs.compare(tmp_path / "a.t4d", tmp_path / "b.t4d", slices=1, each_body=True, csv=tmp_path / "bodies.csv")
    rows = [*csv.DictReader((tmp_path / "bodies.csv").open())]
    assert [row["body"] for row in rows] == ["solid 1", "solid 2"]
    assert [float(row["dice"]) for row in rows] == [1, 0] and rows[1]["hausdorff"] == rows[1]["mean_distance"] == ""
    assert float(rows[1]["volume_difference"]) == -float(rows[1]["volume_a"]) < 0


def test_walls_of_a_shell_and_of_a_moving_ball(tmp_path):
    points = np.moveaxis(np.indices((48,) * 3), 0, -1) - 23.5
    radius = np.sqrt((points**2).sum(-1))
    shell = np.maximum(radius - 20, 15 - radius)
    # Both surfaces grow by 2 in a unit of time.
    mesh = t4d.weave(np.array([shell, np.maximum(radius - 22, 17 - radius)])).load()
    mesh.save(tmp_path / "shell.t4d")
    found = verbs.measure(tmp_path / "shell.t4d", times="0,0.5", thickness=True, normal_speed=True).samples
    for one in found:
        assert abs(one["wall_thickness"] - 5) < 0.05 and abs(one["normal_speed"] - 2) < 0.05
    frames = verbs.measure(tmp_path / "shell.t4d", at_frames=True).samples
    assert [one["time"] for one in frames] == [0, 1] and "wall_thickness" not in frames[0]
    t4d.weave(np.array([shell] * 3), times=(0, 2, 3), caps="half-step").save(tmp_path / "half.t4d")
    assert [one["time"] for one in verbs.measure(tmp_path / "half.t4d", at_frames=True).samples] == [0, 2, 3]
