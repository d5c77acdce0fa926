#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "formats/triangle/rounding_loss.h"
#include "formats/triangle/vertex_normals.h"
#include "t4d/surface.h"

/// Functions that the writers of triangle meshes share.
namespace t4d::formats {

/// Fails on a mesh that cannot be written: coordinates that are not finite, indices out of range.
Result<void> checkWritable(const NamedMesh& named);

/// The coordinates less `center` in float32, and what that does to the shape. Fails when one is out
/// of its range.
Result<std::vector<Eigen::Vector3f>> roundedVertices(const NamedMesh& named,
                                                     const model::Point3& center,
                                                     RoundingLoss& loss);

/// "origin X Y Z", the comment that says where the origin of the file lies (MeshWriteOptions); ""
/// when it was not moved.
std::string originComment(const MeshWriteOptions& options);

/// One number of an attribute. 64-bit integers are rounded to the nearest double.
double attributeNumber(const model::Attribute& attribute, std::size_t row, std::size_t component);

/// True when the attribute has a row for each vertex or triangle of its mesh.
bool fits(const model::Attribute& attribute, const model::TriangleMesh& mesh);

/// The name with everything but ASCII letters, digits and `_` replaced by `_`.
std::string plainName(std::string_view name);

/// The line "vertex attribute 'NAME': WHY" about a lost attribute.
std::string lostLine(const model::Attribute& attribute, std::string_view why);

/// The name of the attribute that numbers the materials of triangles.
inline constexpr const char* kMaterial = "material";

/// The number of each triangle's material in `options.materials`. Empty if the mesh has none, or
/// they are not to be written.
std::vector<std::uint32_t> writtenMaterials(const NamedMesh& named,
                                            const MeshWriteOptions& options);

/// A line for each attribute name of the meshes, for a format without attributes.
std::vector<std::string> allAttributesLost(std::span<const NamedMesh> meshes, std::string_view why);

/// Puts the path before the place of a writer's error. Errors of the file itself have it already.
Error inFile(const std::filesystem::path& path, Error error);

/// The vertices as they are written: with normals, if the options ask for them.
VerticesWithNormals verticesToWrite(const NamedMesh& named, const MeshWriteOptions& options);

/// The colour in 8-bit sRGB, with opacity.
std::array<std::uint8_t, 4> sRgbOf(const Color& color);

/// True if a mesh has colours of this domain. One colour for a mesh is one for each vertex, or for
/// each triangle, as `single` says.
bool hasColors(std::span<const NamedMesh> meshes, model::Domain domain, model::Domain single);

/// The colour of a vertex or triangle in 8-bit sRGB; grey where the mesh has none of that domain,
/// and none for all.
std::array<std::uint8_t, 4> sRgbOf(const NamedMesh& named, model::Domain domain, std::size_t row);

/// Adds the line unless it is there.
void addOnce(std::vector<std::string>& lines, std::string line);

}  // namespace t4d::formats
