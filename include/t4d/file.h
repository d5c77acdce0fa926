#pragma once

/// Files of 4D meshes: .t4d, slab by slab, and the formats of other programs.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// A lattice of positions (SPEC.md, section "Positions"): each coordinate is
/// origin + step x number, in double precision.
struct Grid {
  model::Point3 origin = model::Point3::Zero();
  double step = 1;  ///< positive and finite

  double coordinate(int axis, std::int32_t number) const;
  /// The number of the nearest coordinate; empty if it is out of range.
  std::optional<std::int32_t> number(int axis, double coordinate) const;
  /// The nearest point, whose numbers must be in range.
  model::Point3 nearest(const model::Point3& point) const;

  /// The grid of this step for a mesh about `point`: its origin is 0 on each axis on which numbers
  /// suffice for twice as far, and otherwise the multiple of the step that is nearest to the point.
  static Grid about(const model::Point3& point, double step);

  friend bool operator==(const Grid& a, const Grid& b) {
    return a.origin == b.origin && a.step == b.step;
  }
};

/// Summary of one body in a .t4d file.
struct BodySummary {
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;  ///< vertices on a seam counted once
  std::uint64_t tetrahedra = 0;
  model::TimeSpan time;
  model::Bounds3 bounds;  ///< of all vertices
};

/// Data about a body in HEAD.
struct BodyInfo {
  std::string name = {};  ///< checkName accepts it
  std::vector<double> color =
      {};  ///< linear red, green, blue, perhaps opacity, from 0 to 1; or none
  std::string material = {};
  std::string parent = {};         ///< name of another body; "" for none
  std::string detailsJson = "{}";  ///< a JSON object
  std::string otherJson = "{}";    ///< a JSON object of its members that are not known
};

/// Metadata of a .t4d file, in its HEAD chunk (JSON; SPEC.md, section "HEAD").
struct Metadata {
  std::string generator = {};   ///< program and version
  std::string backend = {};     ///< "mesh4d", "voxel4d", ...
  std::string lengthUnit = {};  ///< "mm", "m", ...; "" if unknown
  std::string timeUnit = {};    ///< "s", ...
  std::string up = "y";         ///< the axis that points up: "y" or "z"
  std::string space = {};       ///< where the axes point in a patient: "RAS", "LPS", or ""
  model::AttributeMeanings attributes = {};  ///< of attributes that slabs may have
  std::vector<BodyInfo> bodies = {};         ///< at least one, with different names
  std::string detailsJson = "{}";  ///< a JSON object with any members: source, parameters, ...
  /// A JSON object of the members that are not known. Written as they were read; members of the
  /// same name in this struct come first.
  std::string otherJson = "{}";
  /// The features that a reader must support. Set by readers; writers name the features they use.
  std::vector<std::string> features = {};
  /// The grid that integer positions refer to. Set by readers.
  std::optional<Grid> grid = {};
};

class OptionalChunks;

enum class T4dOpen : std::uint8_t {
  /// The file must be complete. If it has an index, only footer and index are read; otherwise the
  /// file is read through from the front.
  Whole,
  /// Like Whole, but every byte is read and checked: the checksums and the order of all chunks, and
  /// that index and footer agree with them.
  Checked,
  /// Read from the front, ignoring the footer, up to the first damage. Everything before it can be
  /// used.
  FromFront,
};

struct T4dVersion {
  std::uint16_t major = 0;
  std::uint16_t minor = 0;
};

/// The most cells, of all slabs together, that a file of this size may have unless its reader
/// allows more: 100 million, and 10,000 for each byte. Slabs may share their connectivity, so that
/// a small file can ask for any amount of work.
std::uint64_t usualCellLimit(std::uint64_t fileBytes);

/// Allows any number of cells.
inline constexpr std::uint64_t kAnyCells = ~std::uint64_t{0};

/// The chunks of one type.
struct T4dChunks {
  std::string type;
  std::uint64_t count = 0;
  std::uint64_t bytes = 0;  ///< with headers and padding
};

/// The contents of a slab, without its mesh.
struct T4dSlab {
  model::TimeSpan time;
  std::uint64_t cells = 0;
  model::Bounds3 bounds;  ///< of all its vertices
};

/// From now on T4dReader::open takes URLs, too, which it reads with libcurl. It is in t4d::formats,
/// not in t4d::file, so that a program that reads files only does not link libcurl. It does nothing
/// in a build without libcurl. Call it once, before anything is opened.
void readUrls();

/// Reads a .t4d file slab by slab, with one or two slabs in memory. Every number from the file is
/// checked before it is used, and every slab against its checksums before it is returned.
///
/// For any file, reading takes at most kMemoryPerFileByte bytes per byte of the file, plus
/// kMemoryAlways. The worst case is one compressed float32 layer of which those below and above a
/// slab are poses: 12 bytes per vertex, of which one byte of the file can unpack to 1,024, become
/// 24 bytes in one place and 32 in two, and half as much again while the next slab is read. An
/// uncompressed file takes about one hundredth of that.
class T4dReader {
 public:
  class File;
  static constexpr std::size_t kMemoryPerFileByte = 12 * 1024;
  static constexpr std::size_t kMemoryAlways = std::size_t{1} << 20;

  /// Opens a file by its path, or by its URL on a web server (http:// or https://). There it
  /// requests a part of the file at a time, and fails if the file changes between two requests.
  ///
  /// A path or URL that ends in .t4dm is a file in parts: its manifest is read, and of its parts
  /// those that are asked for. A part is compared with the manifest when it is opened, by its size
  /// and its footer; with Checked, all of them are read and their SHA-256 compared as well.
  ///
  /// Fails for a file with more than `maxCells` cells, which is usualCellLimit if not given.
  /// FromFront does not count them.
  static Result<T4dReader> open(const std::filesystem::path& pathOrUrl,
                                T4dOpen how = T4dOpen::Whole, const model::Progress& progress = {},
                                std::optional<std::uint64_t> maxCells = {});

  T4dReader(T4dReader&&) noexcept;
  T4dReader& operator=(T4dReader&&) noexcept;
  ~T4dReader();

  T4dVersion version() const;
  const Metadata& metadata() const;
  bool indexed() const;
  /// The name for messages: the path, or the URL without credentials.
  const std::string& name() const;
  std::uint64_t fileBytes() const;
  /// Differs for different files, as surely as a checksum of 32 bits can; 0 without an index.
  std::uint32_t fingerprint() const;
  /// Bytes read from the file so far.
  std::uint64_t bytesRead() const;
  /// Requests made to a web server so far; 0 for a local file.
  std::uint64_t requests() const;
  /// The chunks of the file by type, in the order in which the types appear.
  const std::vector<T4dChunks>& chunks() const;

  /// The chunks that this version does not know, for T4dWriter::keep; valid as long as the reader.
  const OptionalChunks& optionalChunks() const;

  std::size_t bodyCount() const;
  /// The summary of a body as stored, without reading its slabs. That of a damaged file covers the
  /// slabs that were found.
  const BodySummary& summary(std::size_t body) const;
  /// The slabs of a body; valid as long as the reader.
  const model::Source& body(std::size_t index) const;
  /// Puts all slabs of a body into `sink`, then checks the file's summary of the body against them.
  Result<void> readThrough(std::size_t body, model::Sink& sink,
                           const model::Progress& progress = {}) const;
  /// The offset of a slab's chunk in the file, or in the part that has it.
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const;

  /// The contents of a slab from the index; without an index the slab is read.
  Result<T4dSlab> slabContents(std::size_t body, std::size_t slab) const;

  /// The reason why reading stopped before the end of the file; only with FromFront.
  const std::optional<Error>& damage() const;

 private:
  explicit T4dReader(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

/// Checks a file against all rules of SPEC.md: every byte, every slab, every sum. Whether the slabs
/// are closed and oriented is left to measure::MeshChecker. There may be any number of cells.
Result<void> checkT4dFile(const std::filesystem::path& path, const model::Progress& progress = {});

/// Whether the path is `-`, the standard input, or a pipe or terminal: whether T4dStream can read
/// it, and T4dReader cannot.
bool isPipe(const std::filesystem::path& path);

/// Whether the path is a regular file with the signature of .t4d, whatever its name and its damage.
bool isT4d(const std::filesystem::path& path);

/// Reads a .t4d file once, from the front, as it comes through a pipe. Keeps a slab or two in
/// memory, what is stored of the parts that slabs to come may name, and some 300 bytes for each
/// chunk. While a chunk is read it is in memory up to three times as it is stored. Checks
/// all that checkT4dFile does.
class T4dStream {
 public:
  /// Opens a pipe, or any other file; `-` is the standard input. Cells are counted as they come: at
  /// most `maxCells`, or usualCellLimit of the bytes so far if that is not given.
  static Result<T4dStream> open(const std::filesystem::path& path,
                                std::optional<std::uint64_t> maxCells = {});

  T4dStream(T4dStream&&) noexcept;
  T4dStream& operator=(T4dStream&&) noexcept;
  ~T4dStream();

  T4dVersion version() const;
  const Metadata& metadata() const;
  bool indexed() const;
  const std::string& name() const;
  std::size_t bodyCount() const;

  struct Item {
    std::size_t body = 0;
    std::uint64_t offset = 0;  ///< of the slab's chunk
    std::shared_ptr<const model::Slab> slab;
  };
  /// The next slab in the order of the file. Nothing after the last one, when all that follows it
  /// has been read and checked, too.
  Result<std::optional<Item>> next();

  /// Complete when next() has returned nothing.
  std::uint64_t fileBytes() const;
  const std::vector<T4dChunks>& chunks() const;
  const BodySummary& summary(std::size_t body) const;

 private:
  class File;
  explicit T4dStream(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

struct T4dWriteOptions {
  /// zstd level, 1 to 19; 0 stores arrays as they are.
  int compression = 3;
  /// Store positions as 32-bit floats. Times stay 64-bit, so that slabs still join.
  bool float32 = false;
  /// End the file with an index and a footer, so that a reader finds a slab without reading
  /// everything before it.
  bool index = true;
  /// Store positions as whole numbers on a grid of this step: at most half of it off on each axis.
  /// Not with float32.
  std::optional<double> step = {};
  /// Number of slabs after which connectivity and the reference of posed layers are stored again,
  /// so that damage to one copy costs no more slabs than this; at least 2, or 0 for no copies.
  std::uint64_t spareEvery = 0;
  /// Slabs in a page of the index, at least 1. A file with eight times as many has pages.
  std::size_t pageSlabs = 2048;
};

/// Writes a .t4d file slab by slab. Memory use is one slab, plus some MB for the index, of which
/// the rest waits in a temporary file; of a slab that is made piece by piece (model::StreamedSlab),
/// what is stored of it, unless positions are rounded. Blocks are compressed on all threads. The
/// target path stays untouched until `finish` returns successfully.
///
/// Connectivity is stored once for consecutive slabs of one body that share the object, and where
/// one of the last 4 MiB, and 16 for each body, of stored connectivity has the same content; layers
/// are stored once; means are not stored. Layers that are a reference moved (Slab::upperPose) are
/// stored as the reference and the pose if that gives them to the bit. They are then not rounded to
/// a grid; with float32, reference and result are rounded.
class T4dWriter {
 public:
  /// Fails if body names are invalid or the file cannot be opened.
  static Result<T4dWriter> create(const std::filesystem::path& path, const Metadata& metadata,
                                  const T4dWriteOptions& options = {});

  T4dWriter(T4dWriter&&) noexcept;
  T4dWriter& operator=(T4dWriter&&) noexcept;
  ~T4dWriter();

  /// Takes the slabs of one body in time order; bodies may alternate. Rejects a slab that is
  /// invalid (checkSlab), whose lower layer does not equal the last upper layer of the body, or
  /// whose means differ from those its connectivity defines; the same goes for attributes of
  /// vertices, to the bit. -0 equals 0, and the file keeps the sign of the upper layer. The sink is
  /// valid as long as the writer.
  model::Sink& body(std::size_t index) const;

  /// Copies chunks of the file that is edited which this version does not know, as far as they may
  /// be copied (SPEC.md, section "Editors"); losses() names the others. Call after the first slab.
  Result<void> keep(const OptionalChunks& chunks);

  /// A line if rounding has made cells flat or turned them over, and for each type of chunks that
  /// were not kept; empty otherwise.
  std::vector<std::string> losses() const;

  /// Writes the end of the file and moves it to its path. Fails if a body has no slab, or is so
  /// small that its hypervolume vanishes in doubles. Returns the
  /// size of the file in bytes.
  Result<std::uint64_t> finish();

 private:
  class File;
  explicit T4dWriter(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

/// One body of a 4D mesh in a format without slabs: all vertices and all tetrahedra.
struct Mesh4d {
  std::string name = {};                     ///< of the body; empty if the file does not name it
  std::vector<model::Point4> vertices = {};  ///< (x, y, z, t)
  std::vector<model::Cell> cells = {};
  std::vector<model::Attribute> attributes = {};
};

/// A 4D mesh as read from a file, neither checked nor mended (edit::mendMesh4d does both).
struct LoadedMesh4d {
  std::vector<Mesh4d> bodies;  ///< at least one, each with cells
  /// The way in which the file uses its format, if there are several: "Stella", "ASCII", ...
  std::string dialect = {};
  /// Changes made while reading, a sentence each: dropped cells, unused vertices, ...
  std::vector<std::string> notices = {};
  /// Contents of the file that the mesh does not have, a sentence each.
  std::vector<std::string> losses = {};
  /// Files that were read besides the one named.
  std::vector<std::filesystem::path> otherFiles = {};
};

/// Reads a 4D mesh in another format than .t4d (docs/formats.md: .off, .4do, .vtu, .msh, .mesh,
/// ...): that with the id `format`, or that which the content and, where that is not enough, the
/// extension tells. Coordinates are the doubles nearest to the numbers in the file. Fails on a file
/// that cannot be read, has an unknown format or breaks it, and holds no tetrahedra.
Result<LoadedMesh4d> readMesh4d(const std::filesystem::path& path, std::string_view format = {});

/// Writes bodies in another format than .t4d: that with the id `format`, or that of the extension.
/// The file appears whole or not at all. Returns what is lost, a sentence each; metadata, which no
/// such format holds, excepted.
Result<std::vector<std::string>> writeMesh4d(const std::filesystem::path& path,
                                             std::span<const model::Body> bodies,
                                             std::string_view format = {});

}  // namespace t4d::formats
