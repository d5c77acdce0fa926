#include <algorithm>
#include <cstring>
#include <utility>

#include "t4d/voxel4d/volumes/dicom_codec.h"
#include "t4d/voxel4d/volumes/dicom_series.h"
#include "t4d/voxel4d/volumes/plane_reader.h"

namespace t4d::voxel4d {
namespace {

/// Sample number i, its bits beyond those that count left out.
template <class T>
T storedSample(const char* bytes, std::size_t i, unsigned unused) {
  std::make_unsigned_t<T> sample;
  std::memcpy(&sample, bytes + i * sizeof(T), sizeof(T));
  // Shifted up and down again; a sign comes down with the shift.
  return static_cast<T>(static_cast<T>(sample << unused) >> unused);
}

template <class T>
void convert(const DicomPlanes& planes, const DicomImage& image, std::string& stored,
             std::byte* into) {
  const std::uint64_t count = planes.layout.samples();
  const unsigned unused = planes.layout.bits - planes.layout.stored;
  if (planes.layout.bigEndian) {
    for (std::uint64_t i = 0; i < count; ++i) {
      std::reverse(stored.data() + i * sizeof(T), stored.data() + (i + 1) * sizeof(T));
    }
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    const T sample = storedSample<T>(stored.data(), i, unused);
    if (planes.scaled) {
      const auto value =
          static_cast<float>(image.slope * static_cast<double>(sample) + image.intercept);
      std::memcpy(into + i * sizeof value, &value, sizeof value);
    } else {
      std::memcpy(into + i * sizeof sample, &sample, sizeof sample);
    }
  }
}

std::uint64_t planeBytes(const DicomPlanes& planes) {
  return planes.layout.samples() * (planes.scaled ? sizeof(float) : planes.layout.bits / 8);
}

class DicomReader : public PlaneReader {
 public:
  explicit DicomReader(std::shared_ptr<const DicomPlanes> planes)
      : PlaneReader(planeBytes(*planes)), planes_(std::move(planes)) {}

 private:
  Result<void> readPlane(std::uint64_t number, std::span<std::byte> into) override {
    const DicomImage& image = planes_->images.at(number);
    const DicomLayout& layout = planes_->layout;
    const std::filesystem::path& file = planes_->files[image.file];
    auto stored = readDicomPieces(file, image);
    if (!stored) return stored.error();
    if (layout.encapsulated) {
      stored = unpackDicomImage({*stored, layout.syntax, layout.columns, layout.rows, layout.bits,
                                 layout.stored, layout.isSigned});
      if (!stored) {
        Error error = stored.error();
        error.where = file.string();
        return error;
      }
    }
    if (stored->size() < layout.bytes()) {
      return invalid("has become shorter while it was read", file.string());
    }
    const auto as = [&]<class T>(T) { convert<T>(*planes_, image, *stored, into.data()); };
    switch (layout.type()) {
      case SampleType::Int8:
        as(std::int8_t{});
        break;
      case SampleType::UInt8:
        as(std::uint8_t{});
        break;
      case SampleType::Int16:
        as(std::int16_t{});
        break;
      case SampleType::UInt16:
        as(std::uint16_t{});
        break;
      case SampleType::Int32:
        as(std::int32_t{});
        break;
      default:  // floats, too, which are not scaled
        as(std::uint32_t{});
    }
    return {};
  }

  std::shared_ptr<const DicomPlanes> planes_;
};

}  // namespace

std::unique_ptr<SampleReader> openDicomSamples(std::shared_ptr<const DicomPlanes> planes) {
  return std::make_unique<DicomReader>(std::move(planes));
}

}  // namespace t4d::voxel4d
