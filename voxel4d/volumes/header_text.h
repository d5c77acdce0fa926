#pragma once

#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "model/number.h"
#include "voxel4d/volumes/volume.h"

/// Functions that readers of headers share. For the sources of this folder only.
namespace t4d::voxel4d {

inline std::vector<std::string> wordsOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

inline std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1));
}

/// The whole word as a number; nothing if it is none.
template <class T>
std::optional<T> numberIn(std::string_view word) {
  return model::numberIn<T>(model::withoutPlus(word));
}

inline std::string lowerCase(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// A file with a header, open for reading. Fails unless it is a regular file
/// with content.
Result<std::ifstream> openHeader(const std::filesystem::path& path);

Error namesOtherFolder(const std::string& header, std::string_view name);

/// Fails if a file of samples that a header names is not in its folder or below, once links are
/// followed. A file that is not there passes.
Result<void> checkDataFile(const std::string& header, const std::filesystem::path& file);

/// A word of a file for a message: short, and without controls.
inline std::string shown(std::string_view text) {
  std::string word(text.substr(0, 40));
  for (char& c : word) {
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  }
  return word;
}

/// The type with one of the names bool, int8, ..., uint64, float32, float64.
std::optional<SampleType> sampleTypeNamed(std::string_view name);
std::string_view nameOf(SampleType type);

/// Bytes of all samples. Fails if an axis has none, or more than 2^31 - 1, or all together have
/// more bytes than 2^62.
Result<std::uint64_t> bytesOfSamples(const Volume& volume);

}  // namespace t4d::voxel4d
