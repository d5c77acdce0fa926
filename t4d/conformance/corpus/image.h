#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "t4d/conformance/corpus/record.h"
#include "t4d/formats/t4d/chunks.h"

namespace t4d::conformance {

/// The slabs of a body, as they are to be read again.
struct BodySlabs {
  std::string name;
  std::vector<model::Slab> slabs;
};

struct ImageOptions {
  bool index = true;
  std::uint16_t minorVersion = 0;
  bool float32 = false;
  Storage storage = Storage::Raw;
};

/// The JSON of HEAD. `more` is further members as JSON text: `"up": "z", "details": {}`.
std::string headJson(const std::vector<std::string>& features,
                     const std::vector<std::string>& bodies, const std::string& more = "");

/// A .t4d file as named chunks, put together by `bytes`. Offsets, sums, index, footer and checksums
/// come out right, whatever is in the chunks, unless they have been `set`.
///
/// Places are called CHUNK/FIELD: fields of the payload as in record.h, and "header/type",
/// "header/flags", "header/length", "header/payload checksum", "header/header checksum" and
/// "padding" of every chunk. Those outside of chunks are "file/signature", "file/major",
/// "file/minor", "file/flags", "file/reserved", "file/checksum" and "footer/index", "footer/done",
/// "footer/file length", "footer/reserved", "footer/checksum", "footer/end signature". DONE has
/// "body 0/slabs" and so on, INDX "record 0/slab" and so on; CHUNK alone is the payload.
class Image {
 public:
  struct Chunk {
    enum class Sum : std::uint8_t { None, Done, Index };  ///< what is made when all else is known

    std::string name;
    std::string type;
    Record payload;
    std::uint32_t flags = 1;
    std::map<std::string, std::string> offsets;  ///< fields that are offsets of named chunks
    std::optional<std::uint32_t> slabOf;         ///< the body that it is a slab of
    Sum sum = Sum::None;
  };

  /// HEAD alone.
  explicit Image(const std::string& head, const ImageOptions& options = {});

  /// A whole file, as the writer makes it: parts directly before the first slab that needs them,
  /// bodies taking turns. HEAD is `head`; without it, it names the bodies and the features that are
  /// used. Chunks are called HEAD, CONN 0, LAYR 0, SLAB 0, ..., DONE, INDX.
  static Image of(const std::vector<BodySlabs>& bodies, const ImageOptions& options = {},
                  const std::optional<std::string>& head = {});

  /// Appends a chunk; with `before`, in front of the one of that name.
  void add(Chunk chunk, const std::string& before = "");
  void addConnectivity(const std::string& name, const model::Connectivity& connectivity);
  void addLayer(const std::string& name, double time, std::span<const model::Point4> vertices);
  /// The parts are names of chunks, "" for a layer that is not there.
  void addSlab(const std::string& name, std::uint32_t body, const model::Slab& slab,
               const std::string& connectivity, const std::string& lower, const std::string& upper);
  /// DONE, and INDX where there is an index. The bodies are those of the slabs added.
  void addEnd();

  Chunk& chunk(const std::string& name);
  void remove(const std::string& name);
  void move(const std::string& name, const std::string& before);

  /// How the arrays of what is added next are stored.
  ImageOptions& options() { return options_; }
  /// What DONE says of the bodies, for those who add slabs by hand.
  std::vector<formats::BodySummary>& summaries() { return summaries_; }

  /// Gives a field a value after all has been put together. Checksums over it are right all the
  /// same.
  template <class T>
  void set(const std::string& place, T value) {
    setBytes(place, bytesOf(value));
  }
  /// Overwrites from `at` bytes after the place's beginning.
  void setBytes(const std::string& place, std::string_view bytes, std::size_t at = 0);
  /// Flips the lowest bit of a byte.
  void flip(const std::string& place, std::size_t at = 0);
  /// Makes the payload of DONE or INDX as it is now, to be changed as that of any chunk.
  void freeze(const std::string& name);

  std::string bytes() const { return assemble().bytes(); }
  /// Where in `bytes()` the place is.
  std::uint64_t offset(const std::string& place) const { return assemble().place(place).offset; }
  std::size_t size(const std::string& place) const { return assemble().place(place).size; }

 private:
  struct Patch {
    std::string place;
    std::string bytes;
    std::size_t at = 0;
    bool flip = false;
  };

  std::size_t position(const std::string& name) const;
  void patch(Record& record, const std::string& prefix, const std::string& field = "") const;
  std::size_t payloadBytes(const Chunk& chunk) const;
  std::vector<std::uint64_t> chunkOffsets() const;
  Record header() const;
  Record footer(std::uint64_t offset, const std::vector<std::uint64_t>& chunkOffsets) const;
  Record chunkHeader(const Chunk& chunk, const Record& payload) const;
  static Record donePayload(std::size_t chunksBefore,
                            const std::vector<formats::BodySummary>& summaries);
  static Record indexRecord(const Record& slab, std::uint64_t offset, std::uint64_t size);
  std::vector<Record> payloads(const std::vector<std::uint64_t>& offsets) const;
  Record assemble() const;

  ImageOptions options_;
  std::vector<Chunk> chunks_;
  std::vector<formats::BodySummary> summaries_;
  std::vector<Patch> patches_;
};

}  // namespace t4d::conformance
