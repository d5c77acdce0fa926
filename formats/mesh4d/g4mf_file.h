#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "formats/input_file.h"

/// The JSON of a G4MF file (.g4tf, .g4b), and its accessors as numbers. g4mf_reader.cpp knows what
/// they mean.
namespace t4d::formats {

class G4mfFile {
 public:
  /// Fails if the container or the JSON is wrong, or the dimension is not 4.
  static Result<G4mfFile> open(const InputFile& file);

  const nlohmann::json& document() const { return document_; }

  /// The numbers of an accessor, whose vectors must have so many. Integers are exact up to 2^53.
  Result<std::vector<double>> accessor(std::uint64_t index, std::uint64_t vectorSize = 4);

  /// A member that is an index into an array of the document; nothing if it is missing or -1.
  Result<std::optional<std::uint64_t>> index(const nlohmann::json& object, const char* member,
                                             const char* array) const;

  /// Bytes of the JSON and of all buffers read so far, unpacked.
  std::uint64_t bytes() const { return bytes_; }

  /// Files of buffers that were read.
  const std::vector<std::filesystem::path>& otherFiles() const { return otherFiles_; }

  Error wrong(const std::string& message) const { return invalid(message, path_.string()); }

 private:
  Result<void> readChunks(const InputFile& file);
  Result<void> parseJson(const InputFile& file);
  Result<const std::string*> buffer(std::uint64_t index);
  Result<std::string> loadBuffer(const nlohmann::json& about, std::uint64_t index,
                                 std::uint64_t size);
  Result<std::string> externalFile(const std::string& uri);

  struct Chunk {
    std::string_view type;
    std::string_view bytes;
    bool zstd = false;
  };
  Result<Chunk> chunkOf(const nlohmann::json& about, std::uint64_t buffer) const;

  std::filesystem::path path_;
  nlohmann::json document_;
  std::vector<Chunk> chunks_;  // of binary G4MF, in the order of the file
  std::vector<std::optional<std::string>> buffers_;
  std::vector<std::filesystem::path> otherFiles_;
  std::uint64_t bytes_ = 0;
};

}  // namespace t4d::formats
