"""What is no file, wherever a file is expected, and output folders with files of others."""

import os
import shutil
from pathlib import Path

from .attack import BASE_SECONDS, Run, input_class


@input_class(weight=3)
def files(attack):
    """pipes, folders, devices, loops of links, empty, cut and missing files as inputs by name
    alone, with the endings of all formats, and as outputs"""
    rng = attack.rng
    kind = rng.choice(["fed", "folder", "zeros", "loop", "missing", "empty", "cut"])
    verb = rng.choice(["info", "validate", "slice", "flipbook", "recover", "rasterize",
                       "compare", "sweep", "motion", "cache", "weave", "series", "output"])
    extension = rng.choice({
        "sweep": ["obj", "stl", "ply", "off", "gltf", "glb", "vtp", "vtu", "pvd", "nc", "t4d"],
        "motion": ["json", "csv", "nc", "gcode", "cl", "t4d"],
        "cache": ["pc2", "mdd"],
        "weave": ["vdb", "nrrd", "nhdr", "npy", "raw", "nii", "nii.gz", "hdr", "vtp", "pvd",
                  "t4d"],
        "series": ["obj", "stl", "gltf"],
    }.get(verb, ["t4d"]))
    path = attack.path(f"odd.{extension}")
    content = attack.pick("t4d").read_bytes()
    if kind == "cut":
        path.write_bytes(content[:50])
    else:
        attack.make_odd(path, kind, content[:-1])
    out = attack.path("out.t4d")
    mesh, motion = attack.pick("obj"), attack.pick("motion")
    if verb == "output" and kind in ("loop", "folder"):
        return Run(["sweep", mesh, "-m", motion, "--steps", 1, "-o", path], [path],
                   expect={1, 2})
    choices = {
        "validate": ["validate", path],
        "slice": ["slice", path, "-t", 0, "-o", attack.path("out.stl")],
        "flipbook": ["flipbook", path, "-n", 2, "-o", attack.path("out.glb")],
        "recover": ["recover", path, "-o", out],
        "rasterize": ["rasterize", path, "--voxel-size", 1, "--frames", 2, "-o",
                      attack.path("frames")],
        "compare": ["compare", path, attack.pick("t4d")],
        "sweep": ["sweep", path, "-m", motion, "-o", out],
        "motion": ["sweep", mesh, "-m", path, "-o", out],
        "cache": ["sweep", mesh, path, "--frame-time", 1, "-o", out],
        "weave": ["weave", path, "-o", out],
        "series": ["weave", path, mesh, "--voxel-size", 1, "-o", out],
    }
    return Run(choices.get(verb, ["info", path]), [path], expect={1, 2, 4})


@input_class(weight=5)
def inputs(attack):
    """each verb with one of its inputs, of every format, a pipe without or with a writer, a folder,
    an endless device, a loop of links, a socket, unreadable, empty or missing"""
    rng = attack.rng
    command = list(rng.choice(attack.commands))
    place = rng.choice([i for i, word in enumerate(command) if word.startswith(str(attack.folder))])
    source = Path(command[place])
    # Beside the others of its kind: a volume has its samples there, a mesh its buffers.
    for other in source.parent.glob(f"{source.name.split('.')[0]}.*"):
        if other.is_file():
            shutil.copy(other, attack.scene)
    path = attack.path(source.name)
    kind = rng.choice(["fifo", "fed", "folder", "zeros", "unreadable", "loop", "missing",
                       "dangling", "empty", "socket", "null", "as it is"])
    if kind == "fifo" and command[0] in ("info", "validate", "du", "cat"):
        kind = "fed"  # these read from pipes, and wait for a writer
    if kind != "as it is":
        path.unlink()
        attack.make_odd(path, kind, source.read_bytes()[:-1])
    command[place] = str(path)
    out = attack.path("out")
    command = [word.replace("OUT", str(out)) if word.startswith("OUT") else word
               for word in command]
    output = next((Path(word) for word in command if word.startswith(f"{out}.")), None)
    # A text of no lines may be a motion that rests, say; what is read from a pipe may do.
    expect = ({0, 3} if kind == "as it is" else {0, 1, 2, 3, 4} if kind in ("empty", "null", "fed")
              else {1, 2, 4})
    return Run(command, [path], output, expect=expect, seconds=BASE_SECONDS / 2)


@input_class(weight=2)
def folders(attack):
    """output folders with files, links and pipes of others under the names that are written, for
    every verb that writes one: nothing of others changes"""
    rng = attack.rng
    folder = attack.path("out")
    mesh, motion, file = attack.pick("obj"), attack.pick("motion"), attack.pick("t4d")
    grids = ["--voxel-size", 5, "--frames", 2, "-o"]
    extension = rng.choice(["glb", "gltf", "ply", "stl", "obj", "off", "vtp", "usda"])
    collection = "usda" if extension == "usda" else "pvd"
    command, names = rng.choice([
        (["frames", file, "--count", 2, "--format", extension, "-o", folder],
         [f"frame_0000.{extension}", f"frame_0001.{extension}", "manifest.json", f"frames.{collection}"]),
        (["frames", file, "--count", 2, "-o", folder / f"a_%d.{extension}"],
         [f"a_0.{extension}", f"a_1.{extension}", "a.manifest.json", f"a.{collection}"]),
        (["frames", file, "--count", 2, "--format", "vdb", "--voxel-size", 5, "-o", folder],
         ["frame_0000.vdb", "manifest.json"]),
        (["rasterize", file, *grids, folder], ["frame_0000.vdb", "frame_0001.vdb"]),
        (["voxelize", mesh, "-m", motion, *grids, folder], ["frame_0000.vdb"]),
        (["view", file, "-o", folder], [file.name, "index.html"]),
        (["conform", "copy", folder, *rng.choice([[], ["--force"]])],
         ["valid/one-simplex.t4d", "manifest.json", "valid"]),
        (["conform", "reader", "--reader", "true", "--only", "valid/one-simplex", "--keep",
          folder], ["valid/one-simplex.t4d", "valid"]),
        (["conform", "writer", "--writer", "true", "--only", "plain/one-simplex", "--keep",
          folder], ["plain/one-simplex.json", "plain"]),
    ])
    own = []  # of the user, though shown by a page that is written beside it
    if rng.random() < 0.5:
        attack.t4d(*command)
    elif command[0] == "view":
        own = [folder / file.name]
        folder.mkdir()
        own[0].write_bytes(attack.pick("t4d").read_bytes())
        attack.t4d("view", *own, "-o", folder)
    outside = attack.path("outside")
    outside.mkdir()
    content = rng.choice([b"", b"mine", rng.randbytes(2000), attack.pick("mesh").read_bytes()])
    (outside / "mine").write_bytes(content)
    for name in rng.sample(names + ["notes.txt"], rng.randrange(1, len(names) + 1)):
        path = folder / name
        if any(p.is_symlink() or p.exists() and not p.is_dir() for p in path.parents):
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            if any(path.iterdir()):
                continue
            path.rmdir()
        kind = rng.choice(["file", "link", "dangling", "loop", "folder", "pipe", "endless"])
        path.unlink(missing_ok=True)
        if kind == "file":
            path.write_bytes(b"mine" + rng.randbytes(50))
        elif kind == "link":
            path.symlink_to(outside / "mine")
        elif kind == "dangling":
            path.symlink_to(outside / "nothing")
        elif kind == "loop":
            path.symlink_to(path.name)
        elif kind == "pipe":
            os.mkfifo(path)
        elif kind == "endless":
            path.symlink_to("/dev/zero")
        else:
            path.symlink_to(outside)
    links = {p: os.readlink(p) for p in folder.rglob("*") if p.is_symlink()}
    # --force replaces files, but no links; so does a folder that says it is for kept files.
    replaces = "--force" in command or (folder / ".t4d-kept").exists()
    kept = [p for p in folder.rglob("*") if p.is_file() and not p.is_symlink()
            and (p in own or p.read_bytes().startswith(b"mine")) and not replaces]
    files = {p: p.read_bytes() for p in [*kept, outside / "mine"]}
    entries = set(outside.iterdir())

    def check(_):
        problems = [f"{p.name} is no link any more" for p, to in links.items()
                    if not p.is_symlink() or os.readlink(p) != to]
        problems += [f"{p.name} has changed" for p, was in files.items()
                     if not p.is_file() or p.read_bytes() != was]
        if set(outside.iterdir()) != entries:
            problems.append("something was written outside of the folder")
        return problems
    return Run(command, check=check)
