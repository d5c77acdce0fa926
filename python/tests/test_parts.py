"""--part K/N of every verb, and join: what parts make together is what one process makes."""

import filecmp
import json
import os
import re
import subprocess

import numpy as np
import pytest
from t4d import verbs
from t4d.errors import VerbError

COUNTS = (1, 3, 7)


@pytest.fixture(scope="session")
def frames(tmp_path_factory):
    """Nine frames of two balls, one of which moves, as distances; the first and the last are empty of
    the smaller."""
    folder = tmp_path_factory.mktemp("frames")
    x, y, z = np.meshgrid(*3 * [np.arange(20.0)], indexing="ij")
    names = []
    for i in range(9):
        big = np.sqrt((x - 7) ** 2 + (y - 8) ** 2 + (z - 7 - 0.6 * i) ** 2) - 4.3
        small = np.sqrt((x - 15) ** 2 + (y - 14) ** 2 + (z - 9) ** 2) - (2.2 if 2 <= i < 7 else -1)
        names.append(folder / f"f{i}.npy")
        np.save(names[-1], np.minimum(big, small).astype(np.float32))
    return names


@pytest.fixture(scope="session")
def woven(frames, tmp_path_factory):
    path = tmp_path_factory.mktemp("woven") / "woven.t4d"
    verbs.weave(*frames, output=path)
    return path


def parts_of(run, count):
    return [run(f"{k}/{count}") for k in range(1, count + 1)]


def joined(reports, folder):
    """The text that `t4d join` prints for JSON reports."""
    names = []
    for number, report in enumerate(reports):
        names.append(folder / f"p{number}.json")
        names[-1].write_text(json.dumps(report))
    return verbs.run_words(["join", *map(str, reversed(names))], text=True)


def printed(*words):
    return subprocess.run([verbs.program(), *map(str, words), "--json"], capture_output=True, text=True).stdout


def without_timing(text):
    return re.sub(r'"(seconds|peak_bytes)": [^,\n]*', "", text)


def without_timing_of(text):
    report = json.loads(text)
    for name in ("bytes", "seconds", "peak_bytes"):
        del report[name]
    return json.dumps(report)


@pytest.mark.parametrize("count", (*COUNTS, 8))
@pytest.mark.parametrize("caps", ("flat", "half-step", "graded"))
def test_parts_of_a_weave_are_its_bytes(frames, tmp_path, count, caps):
    verbs.weave(*frames, caps=caps, output=tmp_path / "whole.t4d")
    files = [tmp_path / f"part{k}.t4d" for k in range(count)]
    reports = [
        verbs.weave(*frames, caps=caps, part=f"{k + 1}/{count}", output=file) for k, file in enumerate(files)
    ]
    verbs.join(*files, output=tmp_path / "joined.t4d")
    assert filecmp.cmp(tmp_path / "whole.t4d", tmp_path / "joined.t4d", shallow=False)
    whole = json.loads(printed("weave", *frames, "--caps", caps, "-o", tmp_path / "again.t4d"))
    all_parts = json.loads(joined(reports, tmp_path))
    for report in (whole, all_parts):
        for name in ("bytes", "seconds", "peak_bytes"):
            del report[name]
    assert all_parts == whole


def test_frames_in_one_file_are_woven_in_parts(frames, tmp_path):
    np.save(tmp_path / "all.npy", np.stack([np.load(name) for name in frames]))
    one = tmp_path / "all.npy"
    for words in ([], ["--region", ":,:,:,1:8"], ["--axes", "xyzt"]):
        whole, parts = tmp_path / "whole.t4d", [tmp_path / f"{k}.t4d" for k in (1, 2, 3)]
        verbs.run_words(["weave", str(one), *words, f"--output={whole}"])
        for k, part in enumerate(parts, 1):
            verbs.run_words(["weave", str(one), *words, f"--part={k}/3", f"--output={part}"])
        verbs.join(*parts, output=tmp_path / "joined.t4d")
        assert filecmp.cmp(whole, tmp_path / "joined.t4d", shallow=False), words


@pytest.mark.parametrize("count", (5, 24) if os.environ.get("T4D_ALL") else (5,))
def test_frames_in_between_are_woven_in_parts(frames, tmp_path, count):
    """Parts may begin between two frames, where velocities carry what is woven."""
    np.save(tmp_path / "d.npy", np.stack([np.load(name) for name in frames]))
    for axis, speed in zip("xyz", (0, 0, 0.6)):
        np.save(tmp_path / f"v{axis}.npy", np.full((9, 20, 20, 20), speed, dtype=np.float32))
    words = ["weave", tmp_path / "d.npy", "--frame-time=1", "--substeps=3",
             "--velocity-file=" + ",".join(str(tmp_path / f"v{axis}.npy") for axis in "xyz")]  # fmt: skip
    whole = json.loads(printed(*words, "-o", tmp_path / "whole.t4d"))
    files = [tmp_path / f"{k}.t4d" for k in range(count)]
    reports = [
        json.loads(printed(*words, "--part", f"{k + 1}/{count}", "-o", file)) for k, file in enumerate(files)
    ]
    verbs.join(*files, output=tmp_path / "joined.t4d")
    assert filecmp.cmp(tmp_path / "whole.t4d", tmp_path / "joined.t4d", shallow=False)
    both = [json.loads(without_timing_of(text)) for text in (joined(reports, tmp_path), json.dumps(whole))]
    assert both[0]["frames_in_between"] == 16 and both[0] == both[1]


@pytest.mark.parametrize("count", COUNTS)
def test_reports_on_parts_are_the_report_on_the_whole(woven, models, tmp_path, count):
    for mesh, verb, *words in (
        (woven, "validate"), (woven, "validate", "--deep"), (models / "screw.t4d", "validate", "--deep"),
        (woven, "quality", "--worst", "7"), (models / "screw.t4d", "quality"),
        (woven, "measure", "--frames", "9"), (models / "cube.t4d", "measure", "--times", "1:60:8"),
    ):  # fmt: skip
        parts = [json.loads(printed(verb, mesh, *words, "--part", f"{k}/{count}")) for k in range(1, count + 1)]
        assert joined(parts, tmp_path) == printed(verb, mesh, *words), (verb, mesh)


@pytest.mark.parametrize("count", (1, 2, 3))
def test_pairs_of_bodies_collide_in_parts(tmp_path, count):
    labels = np.zeros((4, 12, 12, 12), dtype=np.uint8)
    for frame in range(4):
        for label, x, y in ((1, 1, 1), (2, 5, 2), (3, 7, 6), (4, 1 + frame, 7)):
            labels[frame, x : x + 4, y : y + 3, 2:9] = label
    np.save(tmp_path / "labels.npy", labels)
    mesh = tmp_path / "organs.t4d"
    verbs.weave(tmp_path / "labels.npy", label=[1, 2, 3, 4], output=mesh)
    words = ("collide", mesh, "--clearance", "0.1", "--no-volume")
    parts = [json.loads(printed(*words, "--part", f"{k}/{count}")) for k in range(1, count + 1)]
    assert joined(parts, tmp_path) == printed(*words)
    assert "--part and outputs exclude each other" in fails(*words, "--part=1/1", f"--output={tmp_path / 'x.csv'}")


def test_a_broken_mesh_is_found_to_be_broken_in_parts(models, tmp_path):
    """Doubled cells, open and twisted facets, and seams that do not fit, of the corpus and made up."""
    from conftest import BUILD

    folder = tmp_path / "corpus"
    subprocess.run([BUILD / "t4d", "conform", "corpus", "-o", folder, "-q"], check=False)
    corpus = sorted(folder.rglob("impl/mesh-*.t4d")) or sorted(
        (BUILD.parents[1] / "conformance/corpus/files/impl").glob("mesh-*.t4d")
    )
    assert len(corpus) >= 6
    for mesh in corpus:
        most = json.loads(printed("validate", mesh, "--most-parts"))["parts"]
        for count in {1, min(2, most), most}:
            parts = [json.loads(printed("validate", mesh, "--deep", "--part", f"{k}/{count}"))
                     for k in range(1, count + 1)]  # fmt: skip
            assert joined(parts, tmp_path) == printed("validate", mesh, "--deep"), (mesh, count)


@pytest.mark.parametrize("count", COUNTS)
def test_frames_and_grids_are_written_in_parts(models, tmp_path, count):
    screw = models / "screw.t4d"
    for verb, words in (
        ("frames", ["--frames=8", "--format=vtp", "--color=time"]),
        ("frames", ["--frames=8", "--format=ply", "--color=speed", "--velocity"]),
        ("frames", ["--frames=8", "--light"]),
        ("rasterize", ["--frames=8", "--voxel-size=3"]),
    ):
        whole = tmp_path / f"{verb}-whole"
        made = tmp_path / f"{verb}-parts"
        said = printed(verb, screw, *words, "-o", whole)
        parts = [json.loads(printed(verb, screw, *words, "--part", f"{k}/{count}", "-o", made))
                 for k in range(1, count + 1)]  # fmt: skip
        if verb == "frames" and count > 1:
            lists = sorted(made.glob("manifest.part-*.json"))
            verbs.join(*lists, output=made / "manifest.json")
            for name in lists:
                name.unlink()
        same = filecmp.dircmp(whole, made)
        assert not same.left_only and not same.right_only
        assert not filecmp.cmpfiles(whole, made, same.common_files, shallow=False)[1]
        got = re.sub(r'"manifest": ".*"', "", without_timing(joined(parts, tmp_path)))
        assert got == re.sub(r'"manifest": ".*"', "", without_timing(said))
        for folder in (whole, made):
            for file in folder.iterdir():
                file.unlink()
            folder.rmdir()


def test_voxels_of_a_motion_are_written_in_parts(models, tmp_path):
    words = [models / "paper-cube.obj", "--motion", models / "paper-translation.json", "--voxel-size=4",
             "--frames=7", "--mask"]  # fmt: skip
    said = printed("voxelize", *words, "-o", tmp_path / "whole")
    parts = [json.loads(printed("voxelize", *words, "--part", f"{k}/3", "-o", tmp_path / "made")) for k in (1, 2, 3)]
    assert without_timing(joined(parts, tmp_path)) == without_timing(said)
    same = filecmp.dircmp(tmp_path / "whole", tmp_path / "made")
    assert len(same.common_files) == 7 and not same.diff_files


def test_a_file_is_compressed_in_parts(woven, tmp_path):
    parts = [tmp_path / f"{k}.t4d" for k in (1, 2, 3)]
    for k, part in enumerate(parts, 1):
        verbs.compress(woven, part=f"{k}/3", compression=3, output=part)
    verbs.join(*parts, output=tmp_path / "joined.t4d")
    assert filecmp.cmp(woven, tmp_path / "joined.t4d", shallow=False)


def fails(*words):
    with pytest.raises(VerbError) as error:
        verbs.run_words(list(map(str, words)))
    return str(error.value)


def test_what_cannot_be_parts_is_refused(woven, models, frames, tmp_path):
    assert "there are 8 steps from frame to frame, too few for 9 parts" in fails(
        "weave", *frames, "--part=1/9", f"--output={tmp_path / 'x.t4d'}")  # fmt: skip
    assert "--part and --center exclude each other" in fails(
        "weave", *frames, "--part=1/2", "--center", f"--output={tmp_path / 'x.t4d'}")  # fmt: skip
    assert "too few for 11 parts" in fails("validate", woven, "--part=1/11")
    assert "milling cannot be divided" in fails("mill", "x.obj", "--part=1/2")
    assert "converting cannot be divided" in fails("convert", woven, tmp_path / "x.off", "--part=1/2")
    assert "K from 1 to N" in fails("measure", woven, "--part=3/2")
    assert not list(tmp_path.iterdir())


def test_reports_that_are_not_parts_of_one_run_are_refused(woven, models, tmp_path):
    def report(name, *words):
        (tmp_path / name).write_text(printed(*words))
        return tmp_path / name

    one = report("1.json", "measure", woven, "--frames=9", "--part=1/3")
    two = report("2.json", "measure", woven, "--frames=9", "--part=2/3")
    three = report("3.json", "measure", woven, "--frames=9", "--part=3/3")
    assert "part 2 of 3 is missing" in fails("join", one, three)
    assert "part 3 of 3 is missing" in fails("join", one, two)
    assert "part 2 of 3 is given twice" in fails("join", one, two, two, three)
    other = report("o.json", "measure", woven, "--frames=8", "--part=2/3")
    assert 'is of another run: --frames is ["8"]' in fails("join", one, other, three)
    other = report("o.json", "measure", models / "cube.t4d", "--frames=9", "--part=2/3")
    assert "is of another run" in fails("join", one, other, three)
    other = report("o.json", "measure", woven, "--frames=9", "--part=2/4")
    assert "its number of parts is 4" in fails("join", one, other, three)
    other = report("o.json", "validate", woven, "--part=2/3")
    assert 'its verb is "validate"' in fails("join", one, other, three)
    text = two.read_text().replace('"version": "t4d ', '"version": "t4d 0.')
    two.write_text(text)
    assert "its version is" in fails("join", one, two, three)
    whole = report("w.json", "measure", woven, "--frames=9")
    assert "is not the report of a part" in fails("join", whole)
    (tmp_path / "bad.json").write_text(text[:100])
    assert "is not JSON" in fails("join", one, tmp_path / "bad.json")
    assert "are not joined with each other" in fails("join", one, woven)


def test_meshes_with_gaps_and_overlaps_are_refused(frames, tmp_path):
    parts = [tmp_path / f"{k}.t4d" for k in (1, 2, 3)]
    for k, part in enumerate(parts, 1):
        verbs.weave(*frames, part=f"{k}/3", output=part)
    into = f"--output={tmp_path / 'joined.t4d'}"
    assert "begins at time" in fails("join", parts[0], parts[2], into)
    assert "begins at time" in fails("join", parts[0], parts[1], parts[1], into)
    assert not (tmp_path / "joined.t4d").exists()
