#include "formats/vtk/vtk_file.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <type_traits>

#include <expat.h>
#include <fmt/format.h>

#include "formats/text/base64.h"
#include "formats/text/text_scanner.h"
#include "model/number.h"
#include "model/parallel.h"
#include "platform/xml_position.h"

namespace t4d::formats {
namespace {

using Attributes = std::map<std::string, std::string>;

/// A piece of an array that is not compressed: a multiple of the size of every type.
constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 20;

/// Compressed arrays of a mesh are smaller by a factor of 5 to 200; most for numbers that count up
/// and types that are all the same. Larger factors are attacks on memory.
constexpr std::uint64_t kMostUnpackedRatio = 1000;
constexpr std::uint64_t kAlwaysUnpacked = std::uint64_t{1} << 28;
/// The largest size of names.
constexpr std::uint64_t kMostStringBytes = std::uint64_t{1} << 25;

const std::map<std::string_view, Compressor> kCompressors = {
    {"", Compressor::None},
    {"vtkZLibDataCompressor", Compressor::Zlib},
    {"vtkLZ4DataCompressor", Compressor::Lz4},
    {"vtkLZMADataCompressor", Compressor::Lzma},
};

std::optional<std::uint64_t> wholeNumberOf(const std::string& text) {
  std::string_view rest = text;
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  const auto value = model::takeNumber<std::uint64_t>(rest);
  return rest.find_first_not_of(' ') == rest.npos ? value : std::nullopt;
}

std::string_view nameOf(VtkType type) {
  switch (type) {
    case VtkType::UnstructuredGrid:
      return "UnstructuredGrid";
    case VtkType::PolyData:
      return "PolyData";
    case VtkType::Collection:
      return "Collection";
  }
  return {};
}

/// The arrays of an element of this name; null if it has none.
std::vector<VtkArray>* sectionOf(VtkPiece& piece, std::string_view name) {
  if (name == "PointData") return &piece.pointData;
  if (name == "CellData") return &piece.cellData;
  if (name == "Points") return &piece.coordinates;
  if (name == "Cells") return &piece.cells.arrays;
  if (name == "Verts") return &piece.vertices.arrays;
  if (name == "Lines") return &piece.lines.arrays;
  if (name == "Strips") return &piece.strips.arrays;
  if (name == "Polys") return &piece.polygons.arrays;
  return nullptr;
}

/// Bytes of a value of this type; 0 for an unknown one.
std::size_t sizeOf(std::string_view type) {
  if (type == "Float64" || type == "Int64" || type == "UInt64") return 8;
  if (type == "Float32" || type == "Int32" || type == "UInt32") return 4;
  if (type == "Int16" || type == "UInt16") return 2;
  if (type == "Int8" || type == "UInt8") return 1;
  return 0;
}

/// Calls `put` with each number of type `Stored`.
template <class Stored, class Put>
void convert(std::string_view bytes, std::endian order, Put put) {
  const auto each = [&](auto constantOrder) {
    for (std::size_t i = 0; i < bytes.size() / sizeof(Stored); ++i) {
      put(loadNumber<Stored>(bytes.data() + i * sizeof(Stored), constantOrder));
    }
  };
  if (order == std::endian::little) {
    each(std::integral_constant<std::endian, std::endian::little>());
  } else {
    each(std::integral_constant<std::endian, std::endian::big>());
  }
}

/// Passes each number of an array to `put`; `type` is a name that sizeOf knows.
template <class Put>
void convert(std::string_view type, std::string_view bytes, std::endian order, Put put) {
  if (type == "Float64") {
    convert<double>(bytes, order, put);
  } else if (type == "Float32") {
    convert<float>(bytes, order, put);
  } else if (type == "Int64") {
    convert<std::int64_t>(bytes, order, put);
  } else if (type == "UInt64") {
    convert<std::uint64_t>(bytes, order, put);
  } else if (type == "Int32") {
    convert<std::int32_t>(bytes, order, put);
  } else if (type == "UInt32") {
    convert<std::uint32_t>(bytes, order, put);
  } else if (type == "Int16") {
    convert<std::int16_t>(bytes, order, put);
  } else if (type == "UInt16") {
    convert<std::uint16_t>(bytes, order, put);
  } else if (type == "Int8") {
    convert<std::int8_t>(bytes, order, put);
  } else {
    convert<std::uint8_t>(bytes, order, put);
  }
}

}  // namespace

/// Follows the elements of the XML.
class VtkParser {
 public:
  VtkParser(const InputFile& file, VtkType type) : file_(file), type_(type) {
    result_.file_ = &file;
  }

  Result<VtkFile> parse() {
    const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                         XML_ParserFree);
    parser_ = parser.get();
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(parser_, onStart, onEnd);
    XML_SetCharacterDataHandler(parser_, onText);
    constexpr std::size_t kChunk = std::size_t{1} << 24;
    std::string_view left = file_.bytes;
    XML_Status status = XML_STATUS_OK;
    while (status == XML_STATUS_OK && !left.empty()) {
      const std::string_view chunk = left.substr(0, kChunk);
      left.remove_prefix(chunk.size());
      status = XML_Parse(parser_, chunk.data(), static_cast<int>(chunk.size()), left.empty());
    }
    if (problem_) return *problem_;
    if (status != XML_STATUS_OK && !atAppended_) {
      return invalid(fmt::format("is not XML: {}", XML_ErrorString(XML_GetErrorCode(parser_))),
                     file_.atLine(platform::xmlLine(parser_)));
    }
    if (!isRight_) return otherFile();
    if (atAppended_) {
      if (auto found = findAppended(); !found) return found.error();
    }
    return std::move(result_);
  }

 private:
  static void onStart(void* self, const char* name, const char** attributes) {
    Attributes given;
    for (; *attributes != nullptr; attributes += 2) given[attributes[0]] = attributes[1];
    static_cast<VtkParser*>(self)->start(name, given);
  }
  static void onEnd(void* self, const char* name) { static_cast<VtkParser*>(self)->end(name); }
  static void onText(void* self, const char* text, int size) {
    auto* parser = static_cast<VtkParser*>(self);
    if (parser->array_ != nullptr && parser->nested_ == 0) {
      parser->array_->text.append(text, static_cast<std::size_t>(size));
    }
  }

  void stop(Error error) {
    problem_ = std::move(error);
    XML_StopParser(parser_, XML_FALSE);
  }
  Error otherFile() const {
    return invalid(fmt::format("is not a VTKFile of type {}", nameOf(type_)), file_.path.string());
  }
  Place here() const { return file_.atLine(platform::xmlLine(parser_)); }

  void start(const std::string& name, Attributes& attributes) {
    if (problem_ || atAppended_) return;
    if (array_ != nullptr) {
      ++nested_;  // what VTK notes about an array
    } else if (name == "VTKFile") {
      startFile(attributes);
    } else if (name == "Piece") {
      startPiece(attributes);
    } else if (name == "FieldData") {
      enter(name, &result_.fieldData_);
    } else if (name == "DataSet") {
      result_.dataSets_.push_back({attributes["timestep"], attributes["part"], attributes["file"],
                                   platform::xmlLine(parser_)});
    } else if (name == "DataArray" || name == "Array") {
      startArray(attributes);
    } else if (name == "AppendedData") {
      const std::string encoding = attributes["encoding"];
      result_.rawAppended_ = encoding == "raw";
      if (encoding != "raw" && encoding != "base64") {
        return stop(invalid(
            fmt::format("found encoding {}, expected 'raw' or 'base64'", inQuotes(encoding)),
            here()));
      }
      atAppended_ = true;
      appendedAt_ = platform::xmlByte(parser_);
      XML_StopParser(parser_, XML_FALSE);
    } else if (!result_.pieces_.empty()) {
      VtkPiece& piece = result_.pieces_.back();
      enter(name, sectionOf(piece, name));
      if (name != "PointData") return;
      piece.normals = attributes["Normals"];
      piece.textureCoordinates = attributes["TCoords"];
    }
  }

  void enter(const std::string& name, std::vector<VtkArray>* section) {
    if (section == nullptr) return;
    section_ = section;
    sectionName_ = name;
  }

  void startFile(Attributes& attributes) {
    isRight_ = attributes["type"] == nameOf(type_);
    if (!isRight_) return stop(otherFile());
    const std::string& order = attributes["byte_order"];
    if (!order.empty() && order != "LittleEndian" && order != "BigEndian") {
      return stop(invalid(fmt::format("found byte_order {}, expected 'LittleEndian' or 'BigEndian'",
                                      inQuotes(order)),
                          here()));
    }
    if (order == "BigEndian") result_.order_ = std::endian::big;
    const std::string& name = attributes["compressor"];
    const auto compressor = kCompressors.find(name);
    if (compressor == kCompressors.end()) {
      return stop(fail(ErrorCode::Unsupported,
                       fmt::format("is compressed by {}, expected vtkZLibDataCompressor, "
                                   "vtkLZ4DataCompressor or vtkLZMADataCompressor",
                                   inQuotes(name)),
                       here()));
    }
    result_.compressor_ = compressor->second;
    result_.wideHeader_ = attributes["header_type"] == "UInt64";
  }

  void startPiece(Attributes& attributes) {
    VtkPiece piece;
    for (const auto& [name, count] : {std::pair{"NumberOfPoints", &piece.points},
                                      {"NumberOfCells", &piece.cells.count},
                                      {"NumberOfVerts", &piece.vertices.count},
                                      {"NumberOfLines", &piece.lines.count},
                                      {"NumberOfStrips", &piece.strips.count},
                                      {"NumberOfPolys", &piece.polygons.count}}) {
      // Files may leave out the cells that they do not have.
      const bool needed = count == &piece.points ||
                          (type_ == VtkType::UnstructuredGrid && count == &piece.cells.count);
      if (!needed && attributes.count(name) == 0) continue;
      const auto number = wholeNumberOf(attributes[name]);
      if (!number || *number > std::numeric_limits<std::uint32_t>::max()) {
        return stop(invalid(fmt::format("{} is {}, expected a whole number below 2^32", name,
                                        inQuotes(attributes[name])),
                            here()));
      }
      *count = *number;
    }
    result_.pieces_.push_back(std::move(piece));
    section_ = nullptr;  // of a piece that may have been moved
  }

  void startArray(Attributes& attributes) {
    if (section_ == nullptr) return;
    VtkArray array;
    array.name = attributes["Name"];
    array.type = attributes["type"];
    array.format = attributes["format"].empty() ? "ascii" : attributes["format"];
    const auto read = [&](const char* name, std::uint64_t& into) {
      const std::string& text = attributes[name];
      if (text.empty()) return true;
      const auto number = wholeNumberOf(text);
      if (number) into = *number;
      return number.has_value();
    };
    if (!read("NumberOfComponents", array.components) || !read("offset", array.offset)) {
      return stop(invalid(fmt::format("the array {} has attributes that are not whole numbers",
                                      inQuotes(array.name)),
                          here()));
    }
    section_->push_back(std::move(array));
    array_ = &section_->back();
  }

  void end(std::string_view name) {
    if (nested_ > 0) {
      --nested_;
    } else if (name == "DataArray" || name == "Array") {
      array_ = nullptr;
    } else if (name == sectionName_) {
      section_ = nullptr;
    }
  }

  /// The data begin behind an underscore.
  Result<void> findAppended() {
    const std::string_view bytes = file_.bytes;
    const std::size_t tagEnd = bytes.find('>', appendedAt_);
    const std::size_t begin =
        tagEnd == bytes.npos ? bytes.npos : bytes.find_first_not_of(" \t\r\n", tagEnd + 1);
    if (begin == bytes.npos || bytes[begin] != '_') {
      return invalid("the appended data do not begin with '_'", file_.atByte(appendedAt_));
    }
    // What is cut off would otherwise show only where an array ends beyond it.
    const std::size_t last = bytes.find_last_not_of(" \t\r\n");
    if (!bytes.substr(0, last + 1).ends_with("</VTKFile>")) {
      return invalid("the file ends before '</VTKFile>'", file_.atByte(bytes.size()));
    }
    result_.appended_ = bytes.substr(begin + 1);
    if (!result_.rawAppended_) {
      result_.appended_ = result_.appended_.substr(0, result_.appended_.find('<'));
    }
    return {};
  }

  const InputFile& file_;
  VtkType type_;
  VtkFile result_;
  XML_Parser parser_ = nullptr;
  std::vector<VtkArray>* section_ = nullptr;
  std::string sectionName_;
  VtkArray* array_ = nullptr;
  int nested_ = 0;  // elements inside the array
  bool isRight_ = false;
  bool atAppended_ = false;
  std::size_t appendedAt_ = 0;
  std::optional<Error> problem_;
};

Result<VtkFile> VtkFile::open(const InputFile& file, VtkType type) {
  return VtkParser(file, type).parse();
}

const VtkArray* arrayNamed(const std::vector<VtkArray>& arrays, std::string_view name) {
  const auto found = std::ranges::find(arrays, name, &VtkArray::name);
  return found == arrays.end() ? nullptr : &*found;
}

std::string VtkFile::dialect() const {
  std::string text = "ASCII";
  for (const VtkPiece& piece : pieces_) {
    for (const VtkArray& array : piece.coordinates) {
      if (array.format == "binary") text = "base64";
      if (array.format == "appended") text = rawAppended_ ? "appended" : "appended base64";
    }
  }
  if (text == "ASCII") return text;
  if (compressor_ != Compressor::None) {
    text += fmt::format(", compressed with {}", nameOf(compressor_));
  }
  if (order_ == std::endian::big) text += ", big-endian";
  return text;
}

Error VtkFile::wrong(const VtkArray& array, const std::string& message) const {
  return invalid(fmt::format("the array {} {}", inQuotes(array.name), message),
                 file_->path.string());
}

Result<std::string_view> VtkFile::storedOf(const VtkArray& array) const {
  if (array.format == "binary") return array.text;
  if (array.format != "appended") {
    return wrong(array, fmt::format("has the format {}", inQuotes(array.format)));
  }
  if (array.offset > appended_.size()) {
    return wrong(array, fmt::format("begins at byte {} of {} appended bytes", array.offset,
                                    appended_.size()));
  }
  return appended_.substr(array.offset);
}

Result<std::uint64_t> VtkFile::sizeSaidBy(const VtkArray& array) const {
  const auto stored = storedOf(array);
  if (!stored) return stored.error();
  const std::size_t word = wideHeader_ ? 8 : 4;
  const std::size_t words = compressor_ == Compressor::None ? 1 : 3;
  std::string head(stored->substr(0, words * word));
  if (array.format == "binary" || !rawAppended_) {
    auto bytes = fromBase64(*stored, words * word);
    if (!bytes) return wrong(array, "is not Base64");
    head = std::move(*bytes);
  }
  head.resize(words * word);
  const auto wordAt = [&](std::size_t index) -> std::uint64_t {
    const char* at = head.data() + index * word;
    return wideHeader_ ? loadNumber<std::uint64_t>(at, order_)
                       : loadNumber<std::uint32_t>(at, order_);
  };
  if (words == 1 || wordAt(0) == 0) return wordAt(0);
  const std::uint64_t last = wordAt(2) > 0 ? wordAt(2) : wordAt(1);
  return (wordAt(0) - 1) * wordAt(1) + last;
}

/// The blocks of an array that is not ASCII, which must unpack to `size` bytes. They follow a
/// header: the number of bytes; or if compressed the number of blocks, the size of a block, that of
/// the last block unless it is as large, and the compressed size of each.
Result<VtkFile::Blocks> VtkFile::blocksOf(const VtkArray& array, std::uint64_t size) {
  const auto all = storedOf(array);
  if (!all) return all.error();
  const std::string_view stored = *all;
  const bool isRaw = array.format == "appended" && rawAppended_;
  Blocks result;
  // The first bytes, unpacked from Base64 where they are so; fewer if there are no more.
  const auto first = [&](std::uint64_t count) -> Result<std::string_view> {
    if (isRaw) return stored.substr(0, count);
    auto bytes = fromBase64(stored, count);
    if (!bytes) return wrong(array, "is not Base64");
    *result.decoded = std::move(*bytes);
    return std::string_view(*result.decoded).substr(0, count);
  };
  const std::size_t word = wideHeader_ ? 8 : 4;
  const auto wordAt = [&](std::string_view bytes, std::size_t index) -> std::uint64_t {
    const char* at = bytes.data() + index * word;
    return wideHeader_ ? loadNumber<std::uint64_t>(at, order_)
                       : loadNumber<std::uint32_t>(at, order_);
  };
  const std::string tooShort = "ends before its data";
  if (compressor_ == Compressor::None) {
    // One more byte would show that there are too many.
    const auto bytes = first(word + size);
    if (!bytes) return bytes.error();
    if (bytes->size() < word) return wrong(array, tooShort);
    if (wordAt(*bytes, 0) != size) {
      return wrong(array, fmt::format("has {} bytes, expected {}", wordAt(*bytes, 0), size));
    }
    if (bytes->size() < word + size) return wrong(array, tooShort);
    result.add(bytes->substr(word));
    return result;
  }
  auto head = first(3 * word);
  if (!head) return head.error();
  if (head->size() < 3 * word) {
    // An array without blocks may have a shorter header.
    if (size == 0) return result;
    return wrong(array, tooShort);
  }
  const std::uint64_t blocks = wordAt(*head, 0);
  const std::uint64_t blockSize = wordAt(*head, 1);
  const std::uint64_t partial = wordAt(*head, 2);
  if (blocks == 0 && size == 0) return result;
  if (blocks > stored.size() / word) return wrong(array, tooShort);
  const std::uint64_t last = partial > 0 ? partial : blockSize;
  const bool fits = blocks == 1 || (blockSize > 0 && blocks - 1 <= size / blockSize);
  if (blocks == 0 || last > blockSize || !fits || (blocks - 1) * blockSize + last != size) {
    return wrong(array, fmt::format("has {} blocks of {} bytes, the last of {}, expected {} bytes",
                                    blocks, blockSize, last, size));
  }
  head = first((3 + blocks) * word);
  if (!head) return head.error();
  if (head->size() < (3 + blocks) * word) return wrong(array, tooShort);
  std::vector<std::uint64_t> sizes;
  std::uint64_t packedSize = 0;
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const std::uint64_t packed = wordAt(*head, 3 + i);
    if (packed > stored.size()) return wrong(array, tooShort);
    sizes.push_back(packed);
    packedSize += packed;
  }
  if (packedSize > stored.size()) return wrong(array, tooShort);
  if (size / mostRatio(compressor_) > packedSize) {
    return wrong(array, fmt::format("cannot unpack {} bytes to {}", packedSize, size));
  }
  unpacked_ += size;
  const std::uint64_t most = std::max(kAlwaysUnpacked, kMostUnpackedRatio * file_->bytes.size());
  if (unpacked_ > most) {
    return wrong(array, fmt::format("would make {} bytes of a file of {}, expected at most {}",
                                    unpacked_, file_->bytes.size(), most));
  }
  const auto bytes = first((3 + blocks) * word + packedSize);
  if (!bytes) return bytes.error();
  if (bytes->size() < (3 + blocks) * word + packedSize) return wrong(array, tooShort);
  result.compressor = compressor_;
  std::uint64_t at = (3 + blocks) * word;
  for (std::uint64_t i = 0; i < blocks; ++i) {
    result.list.push_back(
        {bytes->substr(at, sizes[i]), i * blockSize, i + 1 < blocks ? blockSize : last});
    at += sizes[i];
  }
  return result;
}

void VtkFile::Blocks::add(std::string_view bytes) {
  for (std::uint64_t begin = 0; begin < bytes.size(); begin += kPieceBytes) {
    const std::string_view piece = bytes.substr(begin, kPieceBytes);
    list.push_back({piece, begin, piece.size()});
  }
}

Result<void> VtkFile::unpack(const VtkArray& array, const Blocks& blocks,
                             const TakeBytes& take) const {
  std::atomic<bool> damaged = false;
  model::PerThread<std::string> buffers;
  model::forEach(blocks.list.size(), [&](std::size_t i) {
    const Block& block = blocks.list[i];
    if (blocks.compressor == Compressor::None) return take(block.begin, block.packed);
    std::string& buffer = buffers.local();
    buffer.resize(block.size);
    if (!unpackBlock(blocks.compressor, block.packed, buffer)) {
      damaged = true;
    } else if (!damaged) {
      take(block.begin, buffer);
    }
  });
  if (damaged) return wrong(array, "is damaged: a block does not unpack to its size");
  return {};
}

template <class Text, class Allocate, class MakePut>
Result<void> VtkFile::forValues(const VtkArray& array, std::uint64_t count, Allocate allocate,
                                MakePut makePut) {
  if (array.format == "ascii") {
    // Each value takes a digit and a blank.
    if (count > array.text.size() / 2 + 1) {
      return wrong(array, fmt::format("has fewer than {} values", count));
    }
    allocate();
    const InputFile text{file_->path, array.text};
    TextScanner scanner(text);
    auto put = makePut(0);
    for (std::uint64_t i = 0; i < count; ++i) {
      Text number{};
      if (!scanner.parse(scanner.wordAcrossLines(), number, "a number")) {
        return wrong(array, "is wrong: " + scanner.error().message);
      }
      put(number);
    }
    if (!scanner.wordAcrossLines().empty()) {
      return wrong(array, fmt::format("has more than {} values", count));
    }
    return {};
  }
  const std::size_t width = sizeOf(array.type);
  if (width == 0) return wrong(array, fmt::format("has the type {}", inQuotes(array.type)));
  auto blocks = blocksOf(array, count * width);
  if (!blocks) return blocks.error();
  std::string whole;
  if (blocks->list.size() > 1 && blocks->list.front().size % width != 0) {
    // A number may begin in one block and end in the next.
    whole.resize(count * width);
    auto done = unpack(array, *blocks, [&](std::uint64_t begin, std::string_view bytes) {
      std::ranges::copy(bytes, whole.begin() + static_cast<std::ptrdiff_t>(begin));
    });
    if (!done) return done;
    blocks->compressor = Compressor::None;
    blocks->list.clear();
    blocks->add(whole);
  }
  allocate();
  return unpack(array, *blocks, [&](std::uint64_t begin, std::string_view bytes) {
    convert(array.type, bytes, order_, makePut(begin / width));
  });
}

template <class Point>
Result<void> VtkFile::coordinates(const VtkArray& array, int axis, std::vector<Point>& into,
                                  std::uint64_t count) {
  const std::uint64_t columns = array.components;
  return forValues<double>(
      array, columns * count, [&] { into.resize(count); },
      [&](std::uint64_t first) {
        return
            [=, at = into.data() + first / columns, column = first % columns](auto number) mutable {
              (*at)[axis + static_cast<int>(column)] = static_cast<double>(number);
              if (++column < columns) return;
              column = 0;
              ++at;
            };
      });
}

template Result<void> VtkFile::coordinates(const VtkArray&, int, std::vector<model::Point3>&,
                                           std::uint64_t);
template Result<void> VtkFile::coordinates(const VtkArray&, int, std::vector<model::Point4>&,
                                           std::uint64_t);

Result<std::vector<std::int64_t>> VtkFile::integers(const VtkArray& array, std::uint64_t count) {
  if (array.type.starts_with("Float") && array.format != "ascii") {
    return wrong(array, "has numbers that are not whole");
  }
  std::vector<std::int64_t> values;
  auto done = forValues<std::int64_t>(
      array, count, [&] { values.resize(count); },
      [&](std::uint64_t first) {
        return [at = values.data() + first](auto number) mutable {
          *at++ = static_cast<std::int64_t>(number);
        };
      });
  if (!done) return done.error();
  return values;
}

template <class Index, class Allocate>
Result<void> VtkFile::indicesBelow(const VtkArray& array, std::uint64_t count, std::uint64_t limit,
                                   Allocate allocate) {
  if (array.type.starts_with("Float") && array.format != "ascii") {
    return wrong(array, "has numbers that are not whole");
  }
  Index* into = nullptr;
  std::atomic<bool> beyond = false;
  auto done = forValues<std::int64_t>(
      array, count, [&] { into = allocate(); },
      [&](std::uint64_t first) {
        return [&beyond, limit, at = into + first](auto number) mutable {
          const auto integer = static_cast<std::int64_t>(number);
          if (static_cast<std::uint64_t>(integer) >= limit) {
            beyond.store(true, std::memory_order_relaxed);
          }
          *at++ = static_cast<Index>(integer);
        };
      });
  if (!done || !beyond) return done;
  const auto all = integers(array, count);
  if (!all) return all.error();
  const auto first = std::ranges::find_if(
      *all, [&](std::int64_t number) { return static_cast<std::uint64_t>(number) >= limit; });
  return wrong(array, fmt::format("has the number {}, expected 0 to {}", *first, limit - 1));
}

Result<std::vector<std::uint32_t>> VtkFile::indices(const VtkArray& array, std::uint64_t count,
                                                    std::uint32_t limit) {
  std::vector<std::uint32_t> values;
  auto done = indicesBelow<std::uint32_t>(array, count, limit, [&] {
    values.resize(count);
    return values.data();
  });
  if (!done) return done.error();
  return values;
}

Result<std::vector<std::uint8_t>> VtkFile::types(const VtkArray& array, std::uint64_t count) {
  std::vector<std::uint8_t> values;
  auto done = indicesBelow<std::uint8_t>(array, count, 256, [&] {
    values.resize(count);
    return values.data();
  });
  if (!done) return done.error();
  return values;
}

Result<std::vector<model::Cell>> VtkFile::tetrahedra(const VtkArray& array, std::uint64_t count,
                                                     std::uint32_t limit) {
  std::vector<model::Cell> cells;
  auto done = indicesBelow<std::uint32_t>(array, 4 * count, limit, [&] {
    cells.resize(count);
    return reinterpret_cast<std::uint32_t*>(cells.data());
  });
  if (!done) return done.error();
  return cells;
}

std::optional<model::ScalarType> VtkFile::scalarTypeOf(const VtkArray& array) {
  using model::ScalarType;
  static const std::map<std::string_view, ScalarType> types = {
      {"UInt8", ScalarType::UInt8},     {"Int8", ScalarType::Int8},
      {"UInt16", ScalarType::UInt16},   {"Int16", ScalarType::Int16},
      {"UInt32", ScalarType::UInt32},   {"Int32", ScalarType::Int32},
      {"UInt64", ScalarType::UInt64},   {"Int64", ScalarType::Int64},
      {"Float32", ScalarType::Float32}, {"Float64", ScalarType::Float64}};
  const auto found = types.find(array.type);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

Result<model::Attribute> VtkFile::attribute(const VtkArray& array, model::Domain domain,
                                            std::uint64_t count) {
  const auto type = scalarTypeOf(array);
  if (!type) return wrong(array, fmt::format("has the type {}", inQuotes(array.type)));
  model::Attribute made{
      array.name, domain, *type, static_cast<std::uint32_t>(array.components), {}};
  // Numbers that are not text are of the type of the array.
  bool textFits = true;
  const auto read = [&]<class Stored, class Text>(Stored, Text) {
    return forValues<Text>(
        array, count * array.components, [&] { made.values.resize(count * made.rowBytes()); },
        [&](std::uint64_t first) {
          return [&, at = made.values.data() + first * sizeof(Stored)](auto number) mutable {
            const auto stored = static_cast<Stored>(number);
            if constexpr (std::is_integral_v<Stored>) {
              if (static_cast<decltype(number)>(stored) != number) textFits = false;
            }
            std::memcpy(at, &stored, sizeof stored);
            at += sizeof stored;
          };
        });
  };
  const auto readAs = [&]() -> Result<void> {
    switch (*type) {
      case model::ScalarType::UInt8:
        return read(std::uint8_t{}, std::int64_t{});
      case model::ScalarType::Int8:
        return read(std::int8_t{}, std::int64_t{});
      case model::ScalarType::UInt16:
        return read(std::uint16_t{}, std::int64_t{});
      case model::ScalarType::Int16:
        return read(std::int16_t{}, std::int64_t{});
      case model::ScalarType::UInt32:
        return read(std::uint32_t{}, std::int64_t{});
      case model::ScalarType::Int32:
        return read(std::int32_t{}, std::int64_t{});
      case model::ScalarType::UInt64:
        return read(std::uint64_t{}, std::uint64_t{});
      case model::ScalarType::Int64:
        return read(std::int64_t{}, std::int64_t{});
      case model::ScalarType::Float32:
        return read(float{}, double{});
      case model::ScalarType::Float64:
        return read(double{}, double{});
    }
    return {};
  };
  if (auto done = readAs(); !done) return done.error();
  if (!textFits) return wrong(array, fmt::format("has numbers that are not {}", array.type));
  return made;
}

Result<std::string> VtkFile::strings(const VtkArray& array) {
  std::string bytes;
  if (array.format == "ascii") {
    const auto count = static_cast<std::uint64_t>(
        std::ranges::count_if(array.text, [previous = ' '](char c) mutable {
          const bool begins = c > ' ' && previous <= ' ';
          previous = c;
          return begins;
        }));
    const auto codes = integers(array, count);
    if (!codes) return codes.error();
    for (const std::int64_t code : *codes) bytes += static_cast<char>(code);
    return bytes;
  }
  const auto size = sizeSaidBy(array);
  if (!size) return size.error();
  if (*size > kMostStringBytes) return wrong(array, fmt::format("has {} bytes of text", *size));
  const auto blocks = blocksOf(array, *size);
  if (!blocks) return blocks.error();
  bytes.resize(*size);
  auto done = unpack(array, *blocks, [&](std::uint64_t begin, std::string_view some) {
    std::ranges::copy(some, bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  });
  if (!done) return done.error();
  return bytes;
}

}  // namespace t4d::formats
