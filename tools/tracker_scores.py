#!/usr/bin/env python3
"""Scores of t4d track, laptrack and trackpy on cells that move and divide as is known, by the measures of the Cell
Tracking Challenge (traccuracy): the table of docs/track.md. Frames are more and more far apart.

    pip install laptrack trackpy traccuracy py-ctcmetrics scikit-image tifffile
    tools/tracker_scores.py --t4d build/release/t4d
"""

import argparse
import contextlib
import io
import logging
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import tifffile
from skimage.measure import label, regionprops_table

SIZE = (160, 160, 13)  # voxels along x, y, z
RADIUS = 5.5
LIFE = 40.0  # mean time between two divisions of a cell
SPEED = 1.0
STEP = 0.05
DURATION = 60.0


class Cell:
    """A ball that moves, and begins to divide at a time."""

    def __init__(self, number, parent, centre, velocity, divides):
        self.number, self.parent, self.centre, self.velocity, self.divides = number, parent, centre, velocity, divides


def simulate(seed):
    """The cells at times STEP apart: {number: (parent, centres (n, 2))} at each, where a mother that divides has the
    centres of both daughters."""
    random = np.random.default_rng(seed)

    def direction():
        angle = random.uniform(0, 2 * np.pi)
        return np.array([np.cos(angle), np.sin(angle)])

    lanes = [(x, y) for x in (26, 62, 98, 134) for y in (26, 62, 98, 134)]
    cells = [Cell(i + 1, 0, np.array(lane, float), SPEED * direction(), random.uniform(5, LIFE))
             for i, lane in enumerate(random.permutation(lanes)[:9])]
    pairs = []  # of daughters that are not apart: (mother, [centre, centre], axis)
    number = len(cells)
    history = []
    for step in range(round(DURATION / STEP) + 1):
        time = step * STEP
        history.append({**{one.number: (one.parent, [one.centre.copy()]) for one in cells},
                        **{mother.number: (mother.parent, [c.copy() for c in centres]) for mother, centres, _ in pairs}})
        for one in [one for one in cells if time >= one.divides]:
            cells.remove(one)
            pairs.append((one, [one.centre.copy(), one.centre.copy()], direction()))
        for pair in list(pairs):
            mother, centres, axis = pair
            for sign, centre in zip((-1, 1), centres):
                centre += STEP * (0.5 * mother.velocity + 0.7 * SPEED * sign * axis)
            if np.linalg.norm(centres[0] - centres[1]) > 2 * RADIUS + 1:
                pairs.remove(pair)
                for sign, centre in zip((-1, 1), centres):
                    number += 1
                    cells.append(Cell(number, mother.number, centre, SPEED * sign * axis, time + random.uniform(LIFE / 2, 2 * LIFE)))
        everything = [(one.centre, one) for one in cells] + [(centre, mother) for mother, centres, _ in pairs for centre in centres]
        for one in cells:
            turn = random.normal(0, 0.3) * np.sqrt(STEP)
            one.velocity = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ one.velocity
            push = np.zeros(2)
            for centre, other in everything:
                if other is one:
                    continue
                away = one.centre - centre
                distance = np.linalg.norm(away)
                push += away / distance * max(0, 3 * RADIUS - distance)
            for axis in range(2):  # of the walls
                push[axis] += max(0, 14 - one.centre[axis]) - max(0, one.centre[axis] - SIZE[axis] + 14)
            if push.any():
                one.velocity = SPEED * (one.velocity + STEP * push) / np.linalg.norm(one.velocity + STEP * push)
            one.centre += STEP * (one.velocity + 0.5 * push)
    return history


def images(history, every):
    """Label images (t, x, y, z) of the truth, and its lines {label: [first, last, parent]}; None if cells touch."""
    points = np.moveaxis(np.indices(SIZE), 0, -1)
    frames, lines = [], {}
    for frame, cells in enumerate(history[:: round(every / STEP)]):
        image = np.zeros(SIZE, np.uint16)
        for number, (parent, centres) in cells.items():
            for centre in centres:
                low = np.maximum(np.floor(centre - RADIUS - 1).astype(int), 0)
                box = tuple(slice(a, a + 14) for a in low)
                inside = ((points[box] - (*centre, SIZE[2] // 2)) ** 2).sum(-1) < RADIUS**2
                image[box][inside] = number
            lines.setdefault(number, [frame, frame, parent])[1] = frame
        frames.append(image)
        if label(image > 0, connectivity=3).max() != len(np.unique(image)) - 1:
            return None
    there = set(lines)
    for line in lines.values():
        while line[2] and line[2] not in there:  # lived between two frames
            line[2] = next(parent for cells in history for number, (parent, _) in cells.items() if number == line[2])
    return np.array(frames), lines


def write_ctc(folder, frames, lines):
    folder.mkdir(parents=True)
    for i, frame in enumerate(frames):
        tifffile.imwrite(folder / f"mask{i:03}.tif", frame.transpose(2, 1, 0).astype(np.uint16), photometric="minisblack")
    text = "".join(f"{one} {first} {last} {parent}\n" for one, (first, last, parent) in sorted(lines.items()))
    (folder / "res_track.txt").write_text(text)


def detections(frames):
    """Centroids of the components: a table of frame, label (in `components`), x, y, z; and the components."""
    components = [label(frame > 0, connectivity=3) for frame in frames]
    tables = []
    for i, image in enumerate(components):
        table = pd.DataFrame(regionprops_table(image, properties=("label", "centroid")))
        tables.append(table.rename(columns={f"centroid-{k}": axis for k, axis in enumerate("xyz")}).assign(frame=i))
    return pd.concat(tables, ignore_index=True), components


def relabelled(table, components, tracks, parents):
    """CTC images and lines of linked detections; a track with a gap goes on as a child."""
    labels, lines = {}, {}
    last_label, following = {}, max(tracks) + 1
    frames = [np.zeros_like(image, np.uint16) for image in components]
    for row, track in sorted(zip(table.itertuples(), tracks), key=lambda pair: pair[0].frame):
        current = last_label.get(track)
        if current is None or lines[current][1] + 1 < row.frame:
            new = track if current is None else following
            following += current is not None
            lines[new] = [row.frame, row.frame, current or 0]
            last_label[track] = current = new
            labels.setdefault(track, new)
        lines[current][1] = row.frame
        frames[row.frame][components[row.frame] == row.label] = current
    for child, parent in parents.items():
        if lines[last_label[parent]][1] < lines[labels[child]][0]:
            lines[labels[child]][2] = last_label[parent]
    return frames, lines


def by_laptrack(frames, reach):
    from laptrack import LapTrack

    table, components = detections(frames)
    tracker = LapTrack(cutoff=reach**2, splitting_cutoff=reach**2, gap_closing_cutoff=reach**2)
    tracked, splits, _ = tracker.predict_dataframe(table, ["x", "y", "z"], only_coordinate_cols=False)
    merged = table.merge(tracked[["frame", "label", "track_id"]], on=["frame", "label"])
    parents = {} if splits.empty else dict(zip(splits["child_track_id"] + 1, splits["parent_track_id"] + 1))
    return relabelled(merged, components, (merged["track_id"] + 1).tolist(), parents)


def by_trackpy(frames, reach):
    import trackpy

    trackpy.quiet()
    table, components = detections(frames)
    tracked = trackpy.link(table, search_range=reach, memory=0, pos_columns=["x", "y", "z"])
    return relabelled(tracked, components, (tracked["particle"] + 1).tolist(), {})


def by_t4d(program, folder, frames):
    np.save(folder / "frames.npy", (frames > 0).astype(np.uint8))
    size = ",".join(map(str, SIZE))
    for words in (["weave", "frames.npy", "--label=1", "-q", "-o", "cells.t4d"],
                  ["track", "cells.t4d", "--ctc", "t4d", "--origin=0,0,0", f"--size={size}"]):
        subprocess.run([program, *words], check=True, capture_output=True, cwd=folder)


def scores(truth, found):
    """DET, LNK and TRA of the CTC, and the F1 of divisions that may be a frame early or late."""
    from traccuracy import run_metrics
    from traccuracy.loaders import load_ctc_data
    from traccuracy.matchers import CTCMatcher
    from traccuracy.metrics import CTCMetrics, DivisionMetrics

    with contextlib.redirect_stderr(io.StringIO()):
        graphs = [load_ctc_data(str(folder), str(folder / "res_track.txt"), name=folder.name) for folder in (truth, found)]
        results, _ = run_metrics(*graphs, CTCMatcher(), [CTCMetrics(), DivisionMetrics(max_frame_buffer=1)])
    ctc, divisions = (one["results"] for one in results)
    return [ctc["DET"], ctc["LNK"], ctc["TRA"], divisions["Frame Buffer 1"]["Division F1"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--t4d", default="t4d", help="the program")
    parser.add_argument("--seeds", type=int, default=5, help="simulations (default: 5)")
    parser.add_argument("--every", default="1,2,4,6,8,10,14", help="times between frames, in which cells move as far")
    options = parser.parse_args()
    logging.disable(logging.WARNING)
    warnings.simplefilter("ignore")
    program = options.t4d if "/" not in options.t4d else str(Path(options.t4d).resolve())
    print("| between frames | cells | divisions | | DET | LNK | TRA | divisions, F1 |\n|---|---|---|---|---|---|---|---|")
    for every in map(float, options.every.split(",")):
        rows, counts, seed = {"t4d": [], "laptrack": [], "trackpy": []}, [], 0
        while len(counts) < options.seeds:
            seed += 1
            made = images(simulate(seed), every)
            if made is None:
                continue
            frames, lines = made
            parents = [parent for _, _, parent in lines.values() if parent]
            counts.append((len(lines), sum(parents.count(parent) == 2 for parent in set(parents))))
            reach = 1.5 * SPEED * every + RADIUS  # as far as a cell and its daughters may go
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                write_ctc(folder / "truth", frames, lines)
                by_t4d(program, folder, frames)
                write_ctc(folder / "laptrack", *by_laptrack(frames, reach))
                write_ctc(folder / "trackpy", *by_trackpy(frames, reach))
                for method, all_ in rows.items():
                    all_.append(scores(folder / "truth", folder / method))
        cells, divisions = np.sum(counts, axis=0)
        for method, all_ in rows.items():
            means = " | ".join("-" if np.isnan(mean) else f"{mean:.3f}" for mean in np.nanmean(np.array(all_, float), axis=0))
            print(f"| {every / (2 * RADIUS):.2f} diameters | {cells} | {divisions} | {method} | {means} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
