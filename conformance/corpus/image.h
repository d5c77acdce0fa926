#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "conformance/corpus/record.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/index_chunk.h"

namespace t4d::conformance {

/// The slabs of a body, as a reader must return them.
struct BodySlabs {
  std::string name;
  std::vector<model::Slab> slabs;
};

struct ImageOptions {
  bool index = true;
  std::uint16_t minorVersion = 0;
  bool float32 = false;
  Storage storage = Storage::Raw;
  std::optional<formats::Grid> grid = {};
  bool cellBounds = true;  ///< whether SLAB has the bounds of blocks of cells

  formats::ArrayOptions positions() const { return {0, float32, grid}; }
};

/// The JSON of HEAD. `more` holds further members as JSON text: `"up": "z", "details": {}`.
std::string headJson(const std::vector<std::string>& features,
                     const std::vector<std::string>& bodies, const std::string& more = "");

/// The member `grid` of HEAD.
std::string gridJson(const formats::Grid& grid);

/// A .t4d file as named chunks, assembled by `bytes`. Offsets, sums, index, footer and checksums
/// are computed from the contents of the chunks, unless they have been `set`.
///
/// Places are called CHUNK/FIELD: fields of the payload as in record.h, and "header/type",
/// "header/flags", "header/length", "header/front", "header/blocks", "header/front checksum",
/// "header/header checksum" and "padding" of every chunk; of a block called BLOCK also "BLOCK
/// size", "BLOCK checksum" and "BLOCK padding". Places outside of chunks are "file/signature",
/// "file/major", "file/minor", "file/flags", "file/reserved", "file/checksum" and "footer/index",
/// "footer/done", "footer/file length", "footer/index checksum", "footer/checksum", "footer/end
/// signature". DONE has "body 0/slabs" and so on, INDX the arrays "times" and so on; CHUNK alone is
/// the payload.
class Image {
 public:
  struct Chunk {
    enum class Sum : std::uint8_t { None, Done, Index };  ///< payloads computed last

    std::string name;
    std::string type;
    Record payload;
    std::uint32_t flags = 1;
    std::map<std::string, std::string> offsets;  ///< fields with the distance back to a named chunk
    std::optional<std::uint32_t> slabOf;         ///< the body, if the chunk is a slab
    Sum sum = Sum::None;
    formats::SlabExtent extent = {};  ///< the slab's entry in INDX
  };

  /// An image with only a HEAD chunk.
  explicit Image(const std::string& head, const ImageOptions& options = {});

  /// A complete file, laid out as by the writer: parts directly before the first slab that needs
  /// them, bodies alternating. HEAD is `head`; by default it names the bodies and the features
  /// used. Chunks are called HEAD, CONN 0, LAYR 0, SLAB 0, ..., DONE, INDX.
  static Image of(const std::vector<BodySlabs>& bodies, const ImageOptions& options = {},
                  const std::optional<std::string>& head = {});

  /// Appends a chunk, or inserts it in front of the chunk named `before`.
  void add(Chunk chunk, const std::string& before = "");
  void addConnectivity(const std::string& name, const model::Connectivity& connectivity);
  void addLayer(const std::string& name, double time, std::span<const model::Point4> vertices,
                std::span<const model::Attribute> attributes = {});
  /// `layer` is the name of a LAYR.
  void addPose(const std::string& name, double time, const model::Affine3x4& pose,
               const std::string& layer);
  /// The parts are chunk names, "" for an absent layer.
  void addSlab(const std::string& name, std::uint32_t body, const model::Slab& slab,
               const std::string& connectivity, const std::string& lower, const std::string& upper);
  /// Adds DONE, and INDX if there is an index, for the bodies of the slabs added.
  void addEnd();

  Chunk& chunk(const std::string& name);
  void remove(const std::string& name);
  void move(const std::string& name, const std::string& before);

  /// Options for the arrays of chunks added later.
  ImageOptions& options() { return options_; }
  /// The bodies' summaries in DONE, for callers that add slabs by hand.
  std::vector<formats::BodySummary>& summaries() { return summaries_; }

  /// Overrides a field after the file has been assembled. Checksums that cover it remain valid.
  template <class T>
  void set(const std::string& place, T value) {
    setBytes(place, bytesOf(value));
  }
  /// Overwrites bytes from `at` bytes after the start of the place.
  void setBytes(const std::string& place, std::string_view bytes, std::size_t at = 0);
  /// Flips the lowest bit of a byte.
  void flip(const std::string& place, std::size_t at = 0);
  /// Computes the payload of DONE or INDX now, so that it can be changed like any other.
  void freeze(const std::string& name);

  std::string bytes() const { return assemble().bytes(); }
  /// The offset of the place in `bytes()`.
  std::uint64_t offset(const std::string& place) const { return assemble().place(place).offset; }
  std::size_t size(const std::string& place) const { return assemble().place(place).size; }

 private:
  struct Patch {
    std::string place;
    std::string bytes;
    std::size_t at = 0;
    bool flip = false;
  };

  struct Indexed {
    Record slab;  // its fields
    formats::SlabExtent extent;
  };
  struct Payload {
    Record bytes;
    std::size_t front = 0;
    std::size_t blocks = 0;
  };
  struct Laid {
    Record fields;
    Payload payload;
    Record header;
  };

  std::size_t position(const std::string& name) const;
  void patch(Record& record, const std::string& prefix, const std::string& field = "",
             const Record& before = {}) const;
  Record header() const;
  Record footer(std::uint64_t offset, const std::vector<std::uint64_t>& chunkOffsets,
                std::uint32_t indexChecksum) const;
  Record chunkHeader(const Chunk& chunk, const Payload& payload) const;
  static Record donePayload(std::size_t chunksBefore,
                            const std::vector<formats::BodySummary>& summaries);
  Record indexPayload(const std::vector<Indexed>& slabs, const std::string& headers) const;
  std::string headOfFile() const;
  Payload finished(const Chunk& chunk, const Record& fields) const;
  std::vector<Laid> layOut() const;
  Record assemble() const;

  ImageOptions options_;
  std::vector<Chunk> chunks_;
  std::vector<formats::BodySummary> summaries_;
  std::vector<Patch> patches_;
};

}  // namespace t4d::conformance
