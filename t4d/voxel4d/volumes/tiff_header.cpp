#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include <expat.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/model/limits.h"
#include "t4d/system/xml_position.h"
#include "t4d/voxel4d/volumes/header_text.h"
#include "t4d/voxel4d/volumes/headers.h"
#include "t4d/voxel4d/volumes/tiff_file.h"
#include "t4d/voxel4d/volumes/unit_names.h"

namespace t4d::voxel4d {
namespace {

/// What a description says of the pages: their axes, the slowest first, from z, t and c (channels).
struct Planes {
  std::string axes;
  std::vector<std::uint64_t> sizes;
  /// The page of each plane, in the order of these axes; empty if they are in that order.
  std::vector<std::uint64_t> pages;
  std::array<std::optional<double>, 3> spacing;
  std::optional<double> frameTime;
  std::string lengthUnit;
  std::string timeUnit;
  std::string notice;
  bool assumed = false;  ///< no description says what the pages are, and neither does the caller

  std::uint64_t size(char axis) const {
    const auto at = axes.find(axis);
    return at == std::string::npos ? 1 : sizes[at];
  }
  /// Saturated.
  std::uint64_t count() const {
    std::uint64_t product = 1;
    for (const std::uint64_t one : sizes) {
      if (__builtin_mul_overflow(product, one, &product)) return ~std::uint64_t{0};
    }
    return product;
  }
};

constexpr std::uint64_t kMostPlanes = std::uint64_t{1} << 31U;

/// unitNamed, but "" for pixels.
std::string lengthUnitNamed(const std::string& name) {
  return name == "pixel" || name == "pixels" ? "" : unitNamed(name);
}

// ImageJ ----------------------------------------------------------------------------------------

Result<Planes> readImageJ(const std::string& text, const TiffFile& file, const std::string& where) {
  Planes planes;
  std::array<std::uint64_t, 3> sizes = {1, 1, 1};  // frames, slices, channels
  std::uint64_t images = 1;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = trimmed(std::string_view(text).substr(at, end - at));
    at = end + 1;
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string name = line.substr(0, equals);
    const std::string value = line.substr(equals + 1);
    const auto wrong = [&] {
      return invalid(fmt::format("its ImageJ description has '{}'", shown(line)), where);
    };
    constexpr std::array<const char*, 4> kCounts = {"frames", "slices", "channels", "images"};
    const auto count = std::ranges::find(kCounts, name);
    if (count != kCounts.end()) {
      const auto number = numberIn<std::uint64_t>(value);
      if (!number || *number == 0 || *number > kMostPlanes) return wrong();
      const auto which = static_cast<std::size_t>(count - kCounts.begin());
      (which < 3 ? sizes[which] : images) = *number;
    } else if (name == "spacing" || name == "finterval") {
      const auto number = numberIn<double>(value);
      if (!number || !std::isfinite(*number)) return wrong();
      // Stacks may be recorded downward; a frame interval that is not known is 0.
      if (name == "spacing" && *number != 0) planes.spacing[2] = std::abs(*number);
      if (name == "finterval" && *number > 0) planes.frameTime = number;
    } else if (name == "unit") {
      planes.lengthUnit = lengthUnitNamed(value);
    } else if (name == "tunit") {
      planes.timeUnit = unitNamed(value);
    }
  }
  if (sizes == std::array<std::uint64_t, 3>{1, 1, 1}) sizes[1] = images;  // a plain stack
  planes.axes = "tzc";
  planes.sizes.assign(sizes.begin(), sizes.end());
  for (const int axis : {0, 1}) {
    const double pixels = file.resolution(axis == 1);
    if (pixels > 0 && std::isfinite(pixels) && !planes.lengthUnit.empty()) {
      planes.spacing[static_cast<std::size_t>(axis)] = 1 / pixels;
    }
  }
  if (planes.frameTime && planes.timeUnit.empty()) planes.timeUnit = "s";
  return planes;
}

// OME-TIFF --------------------------------------------------------------------------------------

using Attributes = std::vector<std::pair<std::string, std::string>>;

std::optional<std::string> valueOf(const Attributes& attributes, std::string_view name) {
  const auto found = std::ranges::find(attributes, name, &Attributes::value_type::first);
  return found == attributes.end() ? std::nullopt : std::optional(found->second);
}

/// What the first image of an OME-XML text has.
struct OmeImage {
  Attributes pixels;
  std::vector<Attributes> data;         // TiffData
  std::vector<std::string> otherFiles;  // named by UUIDs
  std::uint64_t images = 0;
  bool inFirst = false;
};

Result<OmeImage> parseOme(const std::string& text, const std::string& where) {
  OmeImage image;
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  XML_SetUserData(parser.get(), &image);
  XML_SetElementHandler(
      parser.get(),
      [](void* to, const char* element, const char** attributes) {
        auto& found = *static_cast<OmeImage*>(to);
        const char* colon = std::strrchr(element, ':');
        const std::string_view name = colon == nullptr ? element : colon + 1;
        Attributes all;
        for (; attributes[0] != nullptr; attributes += 2) {
          all.emplace_back(attributes[0], attributes[1]);
        }
        if (name == "Image") ++found.images;
        if (found.images > 1) return;
        if (name == "Pixels" && found.pixels.empty()) found.pixels = std::move(all);
        if (name == "TiffData") found.data.push_back(std::move(all));
        if (name == "UUID") {
          if (const auto file = valueOf(all, "FileName")) found.otherFiles.push_back(*file);
        }
      },
      nullptr);
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) != XML_STATUS_OK) {
    return invalid(
        fmt::format("its OME-XML is damaged in line {}: {}", system::xmlLine(parser.get()),
                    XML_ErrorString(XML_GetErrorCode(parser.get()))),
        where);
  }
  if (image.pixels.empty()) return invalid("its OME-XML has no Pixels", where);
  return image;
}

Result<Planes> readOme(const std::string& text, std::uint64_t pagesInFile,
                       const std::string& where) {
  const auto image = parseOme(text, where);
  if (!image) return image.error();
  const auto wrong = [&](const std::string& name, const std::string& value) {
    return invalid(fmt::format("its OME-XML has {}=\"{}\"", name, shown(value)), where);
  };
  for (const std::string& other : image->otherFiles) {
    if (other == image->otherFiles.front()) continue;
    return fail(ErrorCode::Unsupported,
                fmt::format("is one of several files of an image, with {}; only images in one file "
                            "can be read",
                            shown(other)),
                where);
  }
  Planes planes;
  if (image->images > 1) {
    planes.notice = fmt::format("holds {} images, of which the first is used", image->images);
  }
  const std::string order = valueOf(image->pixels, "DimensionOrder").value_or("XYCZT");
  std::string sorted = order;
  std::ranges::sort(sorted);
  if (sorted != "CTXYZ" || !order.starts_with("XY")) return wrong("DimensionOrder", order);
  for (const char axis : {order[4], order[3], order[2]}) {
    const std::string name = std::string("Size") + axis;
    const std::string value = valueOf(image->pixels, name).value_or("1");
    const auto size = numberIn<std::uint64_t>(value);
    if (!size || *size == 0 || *size > kMostPlanes) return wrong(name, value);
    planes.axes += static_cast<char>(axis - 'A' + 'a');
    planes.sizes.push_back(*size);
  }
  std::string unit;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("PhysicalSize") + "XYZ"[axis];
    const auto value = valueOf(image->pixels, name);
    if (!value) continue;
    const auto number = numberIn<double>(*value);
    if (!number || !(*number > 0) || !std::isfinite(*number)) return wrong(name, *value);
    planes.spacing[axis] = *number;
    const std::string own = lengthUnitNamed(valueOf(image->pixels, name + "Unit").value_or("µm"));
    if (!unit.empty() && own != unit) return wrong(name + "Unit", own);
    unit = own;
  }
  planes.lengthUnit = unit;
  if (const auto value = valueOf(image->pixels, "TimeIncrement")) {
    const auto number = numberIn<double>(*value);
    if (!number || !std::isfinite(*number)) return wrong("TimeIncrement", *value);
    if (*number > 0) {
      planes.frameTime = number;
      planes.timeUnit = unitNamed(valueOf(image->pixels, "TimeIncrementUnit").value_or("s"));
    }
  }

  // Where the planes are, if that is said.
  if (planes.count() > pagesInFile) return planes;  // which is an error
  if (image->data.empty() || (image->data.size() == 1 && image->data[0].empty())) return planes;
  constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::vector<std::uint64_t> pages(planes.count(), kNone);
  std::uint64_t stated = 0;
  for (const Attributes& data : image->data) {
    std::array<std::uint64_t, 3> first{};  // in the order of the axes
    const auto take = [&](const std::string& name, std::uint64_t otherwise) {
      const auto value = valueOf(data, name);
      return value ? numberIn<std::uint64_t>(*value) : std::optional(otherwise);
    };
    const auto page = take("IFD", 0);
    const auto count = take("PlaneCount", valueOf(data, "IFD") ? 1 : planes.count());
    if (!page || !count || *page >= pagesInFile || *count > pagesInFile - *page) {
      return invalid("its OME-XML has a TiffData that is damaged", where);
    }
    stated += *count;
    std::uint64_t plane = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = take(std::string("First") + static_cast<char>(planes.axes[i] - 'a' + 'A'), 0);
      if (!at || *at >= planes.sizes[i]) {
        return invalid("its OME-XML has a TiffData outside of the image", where);
      }
      first[i] = *at;
      plane = plane * planes.sizes[i] + first[i];
    }
    if (plane + *count > pages.size()) {
      return invalid("its OME-XML has a TiffData outside of the image", where);
    }
    for (std::uint64_t i = 0; i < *count; ++i) {
      if (pages[plane + i] != kNone) return invalid("its OME-XML places planes twice", where);
      pages[plane + i] = *page + i;
    }
  }
  if (std::ranges::count(pages, kNone) > 0) {
    return invalid(
        fmt::format("its OME-XML says where {} of {} planes are", stated, planes.count()), where);
  }
  planes.pages = std::move(pages);
  return planes;
}

// Other descriptions ----------------------------------------------------------------------------

/// What tifffile writes: {"shape": [4, 10, 64, 64], "axes": "TZYX"}, the latter if it is told.
std::optional<Planes> readShape(const std::string& text, const std::string& axes) {
  const auto value = nlohmann::json::parse(text, nullptr, false);
  if (!value.is_object() || !value.contains("shape") || !value["shape"].is_array()) return {};
  std::vector<std::uint64_t> shape;
  for (const auto& size : value["shape"]) {
    if (!size.is_number_unsigned() || size.get<std::uint64_t>() == 0) return {};
    shape.push_back(size.get<std::uint64_t>());
  }
  std::string named = axes;
  if (named.empty() && value.contains("axes") && value["axes"].is_string()) {
    named = lowerCase(value["axes"].get<std::string>());
  }
  const bool assumed = named.empty();
  if (named.empty() && shape.size() == 4) named = "tzyx";
  if (named.empty() && shape.size() == 3) named = "zyx";
  if (named.size() != shape.size() || !named.ends_with("yx")) return {};
  Planes planes;
  planes.axes = named.substr(0, named.size() - 2);
  planes.sizes.assign(shape.begin(), shape.end() - 2);
  planes.assumed = assumed;
  return planes;
}

Result<Planes> planesOf(const TiffFile& file, const std::string& description, std::uint64_t pages,
                        const std::string& axes, const std::string& where) {
  if (description.starts_with("ImageJ=")) return readImageJ(description, file, where);
  if (description.find("<OME") != std::string::npos) return readOme(description, pages, where);
  if (const auto shape = readShape(description, axes)) return *shape;
  // One axis of pages.
  const std::string of = axes.empty() ? "zyx" : axes;
  if (of.size() != 3 || !of.ends_with("yx")) {
    return invalid(fmt::format("does not say how its {} pages are arranged", pages), where,
                   Remedy::PageAxes);
  }
  Planes planes;
  planes.axes = of.substr(0, 1);
  planes.sizes = {pages};
  planes.assumed = axes.empty();
  return planes;
}

}  // namespace

Result<Volume> readTiffHeader(const std::filesystem::path& path, std::string_view axes,
                              std::optional<std::uint32_t> channel) {
  const std::string where = path.string();
  auto file = TiffFile::open(path);
  if (!file) return file.error();
  const auto layout = file->layout();
  if (!layout) return layout.error();
  const std::string description = file->description();
  const auto plain = file->plainOffset();
  // Where the pages with samples are, all alike.
  std::vector<std::uint64_t> pages;
  for (bool more = true; more;) {
    if (!file->isAuxiliary()) {
      const auto other = file->layout();
      if (!other) return other.error();
      if (*other != *layout) {
        return invalid(fmt::format("page {} (counted from 0) has {} x {} pixels of type {}, page 0 "
                                   "{} x {} of type {}",
                                   pages.size(), other->width, other->height, nameOf(other->type),
                                   layout->width, layout->height, nameOf(layout->type)),
                       where);
      }
      pages.push_back(file->byte());
    }
    const auto next = file->next();
    if (!next) return next.error();
    more = *next;
  }
  if (pages.empty()) return invalid("has no page with samples", where);
  const auto planes = planesOf(*file, description, pages.size(), std::string(axes), where);
  if (!planes) return planes.error();

  std::string sorted = planes->axes;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) != sorted.end() ||
      sorted.find_first_not_of("ctz") != std::string::npos) {
    return invalid(fmt::format("has the axes '{}yx'; x and y are those of a page, and others can "
                               "be z, t and c",
                               shown(planes->axes)),
                   where);
  }
  const auto chosen = chosenChannel(planes->size('c'), channel, where);
  if (!chosen) return chosen.error();

  Volume volume;
  volume.where = where;
  volume.type = layout->type;
  volume.order = std::endian::native;
  volume.axes = "xyzt";
  volume.sizes = {layout->width, layout->height, planes->size('z'), planes->size('t')};
  for (int axis = 0; axis < 3; ++axis) {
    const auto& spacing = planes->spacing[static_cast<std::size_t>(axis)];
    volume.place(axis, axis) = spacing.value_or(1);
    if (!spacing) volume.unsized += "xyz"[axis];
  }
  if (planes->assumed) volume.assumedAxes = planes->axes + "yx";
  volume.notice = planes->notice;
  volume.frameTime = planes->frameTime;
  volume.lengthUnit = planes->lengthUnit;
  volume.timeUnit = planes->timeUnit;

  SampleData data{.path = path};
  const std::uint64_t count = planes->count();
  if (pages.size() == 1 && count > 1 && plain && description.starts_with("ImageJ=")) {
    // Files of more than 4 GiB have one page, after which all planes follow.
    if (planes->size('c') > 1) {
      return fail(ErrorCode::Unsupported,
                  "is larger than a TIFF can be, and has several channels; save it as BigTIFF or "
                  "with one channel",
                  where);
    }
    volume.order = file->bigEndian() ? std::endian::big : std::endian::little;
    data.offset = *plain;
    data.mayHaveMore = true;
    volume.data = {data};
    return volume;
  }
  if (planes->pages.empty() && count != pages.size()) {
    return invalid(fmt::format("its description says that it has {} planes, but it has {} pages",
                               count, pages.size()),
                   where);
  }
  data.encoding = SampleEncoding::Tiff;
  const auto planeAt = [&](std::uint64_t frame, std::uint64_t slice) {
    std::uint64_t plane = 0;
    for (std::size_t i = 0; i < planes->axes.size(); ++i) {
      const char axis = planes->axes[i];
      plane = plane * planes->sizes[i] + (axis == 't' ? frame : axis == 'z' ? slice : *chosen);
    }
    return plane;
  };
  for (std::uint64_t frame = 0; frame < planes->size('t'); ++frame) {
    for (std::uint64_t slice = 0; slice < planes->size('z'); ++slice) {
      const std::uint64_t plane = planeAt(frame, slice);
      data.pages.push_back(pages[planes->pages.empty() ? plane : planes->pages[plane]]);
    }
  }
  volume.data = {std::move(data)};
  return volume;
}

}  // namespace t4d::voxel4d
