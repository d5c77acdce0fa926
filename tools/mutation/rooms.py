"""The rooms of the library, as mutation testing counts them: each its folder's sources, or some."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# The first room that has a file's path counts it.
ROOMS = {
    "model": ["t4d/model/*.cpp"],
    "mesh4d": ["t4d/mesh4d/*.cpp"],
    "voxel4d": ["t4d/voxel4d/*.cpp", "t4d/voxel4d/volumes/*.cpp"],
    "t4d files": ["t4d/formats/t4d/*.cpp"],
    "slicing": ["t4d/slice/*.cpp"],
    "measure": ["t4d/measure/*.cpp", "t4d/verbs/diff.cpp", "t4d/verbs/validate.cpp"],
    "edit": ["t4d/edit/*.cpp", "t4d/verbs/recover.cpp"],
    "mill": ["t4d/mill/*.cpp"],
    "readers": ["t4d/formats/*/*_reader.cpp", "t4d/formats/gltf/gltf_[acghims]*.cpp",
                "t4d/formats/animation/point_cache.cpp", "t4d/formats/mesh4d/g4mf_file.cpp",
                "t4d/formats/mesh4d/gmsh_entities.cpp", "t4d/formats/mesh4d/gmsh_mesh.cpp",
                "t4d/formats/mesh4d/mesh4d_builder.cpp", "t4d/formats/mesh4d/polyhedron.cpp",
                "t4d/formats/motion/joint_table.cpp", "t4d/formats/motion/motion_csv.cpp",
                "t4d/formats/motion/time_column.cpp", "t4d/formats/text/number_table.cpp",
                "t4d/formats/text/text_scanner.cpp", "t4d/formats/toolpath/tool_path.cpp",
                "t4d/formats/triangle/mesh_builder.cpp", "t4d/formats/triangle/ply_header.cpp",
                "t4d/formats/triangle/polygon_triangulation.cpp", "t4d/formats/vtk/vtk_file.cpp"],
}
NOT_MUTATED = ("_test.cpp", "_samples.cpp", "_writer.cpp")


def files_of(room):
    found = {path for pattern in ROOMS[room] for path in ROOT.glob(pattern)}
    return sorted(str(path.relative_to(ROOT)) for path in found
                  if room == "t4d files" and path.name in ("writer.cpp", "chunk_writer.cpp")
                  or not path.name.endswith(NOT_MUTATED))


def room_of(file):
    """The room of a file, or its folder."""
    for room in ROOMS:
        if file in files_of(room):
            return room
    return str(Path(file).parent)
