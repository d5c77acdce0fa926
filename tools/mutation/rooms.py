"""The rooms of the library, as mutation testing counts them: each its folder's sources, or some."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# The first room that has a file's path counts it.
ROOMS = {
    "model": ["model/*.cpp"],
    "mesh4d": ["mesh4d/*.cpp"],
    "voxel4d": ["voxel4d/*.cpp", "voxel4d/volumes/*.cpp"],
    "t4d files": ["formats/t4d/*.cpp"],
    "slicing": ["slice/*.cpp"],
    "measure": ["measure/*.cpp", "tools/t4d/diff.cpp", "tools/t4d/validation.cpp"],
    "edit": ["edit/*.cpp", "tools/t4d/recover.cpp"],
    "mill": ["mill/*.cpp"],
    "readers": ["formats/*/*_reader.cpp", "formats/gltf/gltf_[acghims]*.cpp",
                "formats/animation/point_cache.cpp", "formats/mesh4d/g4mf_file.cpp",
                "formats/mesh4d/gmsh_entities.cpp", "formats/mesh4d/gmsh_mesh.cpp",
                "formats/mesh4d/mesh4d_builder.cpp", "formats/mesh4d/polyhedron.cpp",
                "formats/motion/joint_table.cpp", "formats/motion/motion_csv.cpp",
                "formats/motion/time_column.cpp", "formats/text/number_table.cpp",
                "formats/text/text_scanner.cpp", "formats/toolpath/tool_path.cpp",
                "formats/triangle/mesh_builder.cpp", "formats/triangle/ply_header.cpp",
                "formats/triangle/polygon_triangulation.cpp", "formats/vtk/vtk_file.cpp"],
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
