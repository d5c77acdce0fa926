#include "formats/gltf/draco_unpack.h"

#include <exception>
#include <string>

#include <draco/compression/decode.h>
#include <fmt/format.h>
#include <tiny_gltf.h>

#include "platform/isolated.h"

namespace t4d::formats {
namespace {

/// Appends the values of an attribute as numbers of one type. False if they do not fit it.
template <class T>
bool appendRows(const draco::PointAttribute& attribute, std::uint64_t points, std::string& rows) {
  const bool isInteger = std::is_integral_v<T>;
  const bool sameLength = draco::DataTypeLength(attribute.data_type()) == sizeof(T);
  if (isInteger && !draco::IsDataTypeIntegral(attribute.data_type())) return false;
  if (isInteger && attribute.normalized() && !sameLength) return false;
  std::vector<T> row(attribute.num_components());
  for (std::uint32_t point = 0; point < points; ++point) {
    const auto value = attribute.mapped_index(draco::PointIndex(point));
    if (value.value() >= attribute.size() || !attribute.ConvertValue(value, row.data())) {
      return false;
    }
    rows.append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(T));
  }
  return true;
}

bool appendRows(const draco::PointAttribute& attribute, int componentType, std::uint64_t points,
                std::string& rows) {
  switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return appendRows<std::int8_t>(attribute, points, rows);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return appendRows<std::uint8_t>(attribute, points, rows);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return appendRows<std::int16_t>(attribute, points, rows);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return appendRows<std::uint16_t>(attribute, points, rows);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return appendRows<std::uint32_t>(attribute, points, rows);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return appendRows<float>(attribute, points, rows);
    default:
      return false;
  }
}

/// Unpacks in this process.
Result<std::string> unpackedHere(const DracoMesh& wanted) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(wanted.bytes.data()), wanted.bytes.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return invalid(decoded.status().error_msg_string());
  const draco::Mesh& mesh = *decoded.value();
  if (mesh.num_points() != wanted.pointCount) {
    return invalid(fmt::format("it has {} points, but the accessors {}", mesh.num_points(),
                               wanted.pointCount));
  }
  std::string arrays;
  for (const DracoAttribute& asked : wanted.attributes) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(asked.id);
    if (attribute == nullptr) return invalid(fmt::format("it has no attribute {}", asked.id));
    if (attribute->num_components() != asked.components) {
      return invalid(fmt::format("its attribute {} has elements of {} numbers, but the accessor {}",
                                 asked.id, attribute->num_components(), asked.components));
    }
    if (!appendRows(*attribute, asked.componentType, wanted.pointCount, arrays)) {
      return invalid(fmt::format("its attribute {} has values that are not of component type {}",
                                 asked.id, asked.componentType));
    }
  }
  for (std::uint32_t i = 0; i < mesh.num_faces(); ++i) {
    for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(i))) {
      const std::uint32_t corner = point.value();
      arrays.append(reinterpret_cast<const char*>(&corner), sizeof corner);
    }
  }
  return arrays;
}

}  // namespace

bool hasDraco() { return true; }

Result<std::vector<unsigned char>> dracoUnpacked(const DracoMesh& mesh) {
  // A few damaged bytes may ask for any amount of memory. A triangle takes up to 200 bytes while it
  // is unpacked, and before that, in regular grids, only a tenth of a byte.
  constexpr std::uint64_t kBytes = std::uint64_t{1} << 30;
  constexpr std::uint64_t kBytesPerByte = 4000;
  constexpr std::uint64_t kSeconds = 20;
  constexpr std::uint64_t kBytesPerSecond = 20'000;
  const platform::WorkLimits limits = {kBytes + kBytesPerByte * mesh.bytes.size(),
                                       kSeconds + mesh.bytes.size() / kBytesPerSecond};
  constexpr char kGood = '+';
  const auto work = platform::runIsolated(
      [&] {
        const auto arrays = unpackedHere(mesh);
        return arrays ? kGood + *arrays : '-' + arrays.error().message;
      },
      limits);
  if (!work) return work.error();
  using End = platform::IsolatedWork::End;
  switch (work->end) {
    case End::Crashed:
      return invalid(fmt::format("Draco crashed, by signal {}", work->signal));
    case End::OutOfTime:
      return invalid(fmt::format("Draco was stopped after {} s", limits.cpuSeconds));
    case End::OutOfMemory:
      return invalid(fmt::format("Draco needs more than {} MB", limits.memoryBytes / 1'000'000));
    case End::Returned:
      break;
  }
  const std::string& result = work->result;
  if (!result.starts_with(kGood)) return invalid(result.empty() ? result : result.substr(1));
  return std::vector<unsigned char>(result.begin() + 1, result.end());
}

}  // namespace t4d::formats
