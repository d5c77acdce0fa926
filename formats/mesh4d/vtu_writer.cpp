#include "formats/mesh4d/vtu_writer.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "formats/output_file.h"
#include "formats/text/xml_text.h"
#include "formats/vtk/vtk_cells.h"
#include "formats/zlib_block.h"
#include "model/parallel.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 18;
/// Blocks compressed at once.
constexpr std::size_t kBatch = 64;

// Numbers are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

/// An array of appended data: a table of the sizes of its blocks, then the blocks.
class ArrayOutput {
 public:
  ArrayOutput(OutputFile& file, std::uint64_t bytes) : file_(file), offset_(file.size()) {
    const std::uint64_t blocks = (bytes + kBlockBytes - 1) / kBlockBytes;
    table_ = {blocks, kBlockBytes, bytes % kBlockBytes};
    left_ = bytes;
    raw_.reserve(std::min<std::uint64_t>(bytes, kBlockBytes * kBatch));
  }

  /// Reserves the place of the table.
  Result<void> begin() {
    const std::vector<std::uint64_t> empty(table_.size() + table_[0]);
    return file_.write(empty.data(), empty.size() * sizeof(std::uint64_t));
  }

  template <class T>
  Result<void> put(const T* values, std::size_t count) {
    const auto* from = reinterpret_cast<const char*>(values);
    std::size_t size = count * sizeof(T);
    while (size > 0) {
      const std::size_t now = std::min(size, kBlockBytes * kBatch - raw_.size());
      raw_.append(from, now);
      from += now;
      size -= now;
      if (raw_.size() == kBlockBytes * kBatch) {
        if (auto done = flush(); !done) return done;
      }
    }
    return {};
  }

  Result<void> finish() {
    if (auto done = flush(); !done) return done;
    if (left_ != 0) return invalid("the mesh does not have as many elements as stated");
    return file_.rewrite(offset_, table_.data(), table_.size() * sizeof(std::uint64_t));
  }

 private:
  Result<void> flush() {
    if (raw_.size() > left_) return invalid("the mesh has more elements than stated");
    left_ -= raw_.size();
    packed_.resize((raw_.size() + kBlockBytes - 1) / kBlockBytes);
    model::forEach(packed_.size(), [&](std::size_t i) {
      packed_[i] = zlibCompressed(std::string_view(raw_).substr(i * kBlockBytes, kBlockBytes));
    });
    raw_.clear();
    for (const std::string& block : packed_) {
      table_.push_back(block.size());
      if (auto done = file_.write(block.data(), block.size()); !done) return done;
    }
    return {};
  }

  OutputFile& file_;
  std::uint64_t offset_;
  std::vector<std::uint64_t> table_;
  std::uint64_t left_;
  std::string raw_;
  std::vector<std::string> packed_;
};

/// The XML before the data, with places for the offsets of the arrays.
class VtuHead {
 public:
  void add(std::string_view text) { text_ += text; }

  /// Returns the number of the array.
  std::size_t addArray(std::string_view type, std::string_view name, std::uint32_t components = 1) {
    text_ += fmt::format(R"(<DataArray type="{}" Name="{}")", type, name);
    if (components != 1) text_ += fmt::format(R"( NumberOfComponents="{}")", components);
    text_ += R"( format="appended" offset=")";
    places_.push_back(text_.size());
    text_.append(kDigits + 1, ' ');
    text_ += "/>\n";
    return places_.size() - 1;
  }

  const std::string& text() const { return text_; }

  /// Sets the offset of the array with this number.
  Result<void> place(OutputFile& file, std::size_t array, std::uint64_t offset) const {
    // Blanks follow the quote: not every reader takes them before it.
    const std::string text = fmt::format("{:<{}}", fmt::format("{}\"", offset), kDigits + 1);
    return file.rewrite(places_[array], text.data(), text.size());
  }

 private:
  static constexpr std::size_t kDigits = 20;
  std::string text_;
  std::vector<std::size_t> places_;
};

/// Text as the numbers of its bytes, as VTK has strings.
std::string asciiCodes(std::string_view text) {
  std::string codes;
  for (const char c : text) codes += fmt::format("{} ", static_cast<unsigned char>(c));
  return codes + "0 ";
}

const char* vtkTypeOf(model::ScalarType type) {
  switch (type) {
    case model::ScalarType::UInt8:
      return "UInt8";
    case model::ScalarType::Int8:
      return "Int8";
    case model::ScalarType::UInt16:
      return "UInt16";
    case model::ScalarType::Int16:
      return "Int16";
    case model::ScalarType::UInt32:
      return "UInt32";
    case model::ScalarType::Int32:
      return "Int32";
    case model::ScalarType::UInt64:
      return "UInt64";
    case model::ScalarType::Int64:
      return "Int64";
    case model::ScalarType::Float32:
      return "Float32";
    case model::ScalarType::Float64:
      return "Float64";
  }
  return "";
}

class VtuWriter {
 public:
  VtuWriter(OutputFile& file, const FlatBodies& mesh)
      : file_(file),
        mesh_(mesh),
        wide_(4 * mesh.cellCount() > std::numeric_limits<std::int32_t>::max()) {}

  Result<void> write() {
    writeHead();
    if (auto done = file_.write(head_.text().data(), head_.text().size()); !done) return done;
    begin_ = file_.size();
    if (auto done = writeVertices(); !done) return done;
    if (mesh_.bodies().size() > 1) {
      if (auto done = writeBodies(); !done) return done;
    }
    for (std::size_t i = 0; i < mesh_.attributes().size(); ++i) {
      if (auto done = writeAttribute(i); !done) return done;
    }
    if (auto done = wide_ ? writeCells<std::int64_t>() : writeCells<std::int32_t>(); !done) {
      return done;
    }
    const std::string_view end = "\n</AppendedData>\n</VTKFile>";
    return file_.write(end.data(), end.size());
  }

 private:
  void writeHead() {
    const auto bodies = mesh_.bodies();
    head_.add(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\" "
        "compressor=\"vtkZLibDataCompressor\">\n<!-- written by t4d: the point data t are the "
        "fourth coordinate, time -->\n<UnstructuredGrid>\n");
    // Names are written as numbers, not as strings, which meshio does not read.
    std::string names;
    std::size_t count = 0;
    for (const CountedBody& body : bodies) {
      names += asciiCodes(body.name);
      count += body.name.size() + 1;
    }
    head_.add(
        fmt::format("<FieldData>\n<DataArray type=\"UInt8\" Name=\"body_names\" "
                    "NumberOfTuples=\"{}\" format=\"ascii\">\n{}\n</DataArray>\n"
                    "<DataArray type=\"UInt8\" Name=\"{}\" NumberOfTuples=\"1\" "
                    "format=\"ascii\">\n1\n</DataArray>\n</FieldData>\n",
                    count, names, kOutwardContours));
    head_.add(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                          mesh_.vertexCount(), mesh_.cellCount()));
    head_.add("<PointData Scalars=\"t\">\n");
    times_ = head_.addArray("Float64", "t");
    attributes_.resize(mesh_.attributes().size());
    addAttributes(model::Domain::Vertex);
    head_.add("</PointData>\n<Points>\n");
    points_ = head_.addArray("Float64", "Points", 3);
    head_.add("</Points>\n<Cells>\n");
    connectivity_ = head_.addArray(wide_ ? "Int64" : "Int32", "connectivity");
    offsets_ = head_.addArray(wide_ ? "Int64" : "Int32", "offsets");
    types_ = head_.addArray("UInt8", "types");
    head_.add("</Cells>\n<CellData>\n");
    if (bodies.size() > 1) bodies_ = head_.addArray("Int32", "body");
    addAttributes(model::Domain::Cell);
    head_.add("</CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
  }

  void addAttributes(model::Domain domain) {
    for (std::size_t i = 0; i < attributes_.size(); ++i) {
      const model::Attribute& attribute = mesh_.attributes()[i];
      if (attribute.domain != domain) continue;
      attributes_[i] = head_.addArray(vtkTypeOf(attribute.type), xmlEscaped(attribute.name),
                                      attribute.components);
    }
  }

  /// An array that starts here, by its number in the head.
  Result<ArrayOutput> array(std::size_t which, std::uint64_t bytes) {
    if (auto placed = head_.place(file_, which, file_.size() - begin_); !placed) {
      return placed.error();
    }
    ArrayOutput output(file_, bytes);
    if (auto begun = output.begin(); !begun) return begun.error();
    return output;
  }

  Result<void> writeAttribute(std::size_t index) {
    const model::Attribute& attribute = mesh_.attributes()[index];
    const std::uint64_t rows =
        attribute.domain == model::Domain::Vertex ? mesh_.vertexCount() : mesh_.cellCount();
    auto output = array(attributes_[index], rows * attribute.rowBytes());
    if (!output) return output.error();
    auto done = mesh_.forRows(attribute, [&](std::span<const std::byte> bytes) {
      return output->put(bytes.data(), bytes.size());
    });
    if (!done) return done;
    return output->finish();
  }

  Result<void> writeVertices() {
    std::vector<double> times;
    times.reserve(mesh_.vertexCount());
    auto points = array(points_, 24 * mesh_.vertexCount());
    if (!points) return points.error();
    std::vector<double> some;
    auto done = mesh_.forVertices([&](std::span<const model::Point4> vertices) {
      some.clear();
      for (const model::Point4& v : vertices) {
        some.insert(some.end(), v.data(), v.data() + 3);
        times.push_back(v[3]);
      }
      return points->put(some.data(), some.size());
    });
    if (done) done = points->finish();
    if (!done) return done;
    auto output = array(times_, 8 * mesh_.vertexCount());
    if (!output) return output.error();
    if (done = output->put(times.data(), times.size()); !done) return done;
    return output->finish();
  }

  Result<void> writeBodies() {
    auto output = array(bodies_, 4 * mesh_.cellCount());
    if (!output) return output.error();
    std::int32_t number = 0;
    for (const CountedBody& body : mesh_.bodies()) {
      for (std::uint64_t i = 0; i < body.tetrahedra; ++i) {
        if (auto done = output->put(&number, 1); !done) return done;
      }
      ++number;
    }
    return output->finish();
  }

  template <class Index>
  Result<void> writeCells() {
    const std::uint64_t count = mesh_.cellCount();
    auto connectivity = array(connectivity_, 4 * sizeof(Index) * count);
    if (!connectivity) return connectivity.error();
    std::vector<Index> some;
    auto done = mesh_.forCells([&](std::size_t, std::span<const model::Cell> cells) {
      some.clear();
      for (const model::Cell& cell : cells) {
        model::Cell turned = cell;
        turnOver(turned);
        for (const std::uint32_t corner : turned) some.push_back(static_cast<Index>(corner));
      }
      return connectivity->put(some.data(), some.size());
    });
    if (done) done = connectivity->finish();
    if (!done) return done;

    auto offsets = array(offsets_, sizeof(Index) * count);
    if (!offsets) return offsets.error();
    Index end = 0;
    for (std::uint64_t i = 0; i < count; i += FlatBodies::kMostAtOnce) {
      some.resize(std::min<std::uint64_t>(FlatBodies::kMostAtOnce, count - i));
      for (Index& offset : some) offset = end += 4;
      if (done = offsets->put(some.data(), some.size()); !done) return done;
    }
    if (done = offsets->finish(); !done) return done;

    auto types = array(types_, count);
    if (!types) return types.error();
    const std::vector<std::uint8_t> same(FlatBodies::kMostAtOnce, kVtkTetrahedron);
    for (std::uint64_t i = 0; i < count; i += same.size()) {
      done = types->put(same.data(), std::min<std::uint64_t>(same.size(), count - i));
      if (!done) return done;
    }
    return types->finish();
  }

  OutputFile& file_;
  const FlatBodies& mesh_;
  bool wide_;  // indices of 64 bits
  VtuHead head_;
  // The numbers of the arrays in the head.
  std::size_t times_ = 0;
  std::size_t points_ = 0;
  std::size_t connectivity_ = 0;
  std::size_t offsets_ = 0;
  std::size_t types_ = 0;
  std::size_t bodies_ = 0;
  std::vector<std::size_t> attributes_;
  std::uint64_t begin_ = 0;  // of the appended data
};

}  // namespace

bool keptInVtu(const model::Attribute& attribute) {
  if (attribute.domain == model::Domain::Cell) return attribute.name != "body";
  return attribute.name != "t" && attribute.name != "time";
}

void turnOver(model::Cell& cell) { std::swap(cell[2], cell[3]); }

Result<void> writeVtu(const std::filesystem::path& path, const FlatBodies& mesh) {
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  if (auto done = VtuWriter(*file, mesh).write(); !done) return done;
  return file->commit();
}

}  // namespace t4d::formats
