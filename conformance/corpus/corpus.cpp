#include "conformance/corpus/corpus.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <regex>
#include <set>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/slice_parts.h"
#include "conformance/corpus/texts.h"
#include "conformance/driver/reader_cases.h"
#include "formats/output_folder.h"
#include "model/number.h"
#include "platform/replaceable.h"
#include "platform/sha256.h"

namespace t4d::conformance {
namespace {

using nlohmann::ordered_json;

constexpr const char* kSpecVersion = "1.1";
/// Larger files may be missing when the corpus is verified: they are generated, and not kept in the
/// source tree.
constexpr std::size_t kKeptBytes = std::size_t{1} << 20;

std::string sha256(std::string_view bytes) {
  platform::Sha256 digest;
  digest.add(std::as_bytes(std::span(bytes)));
  return digest.finish();
}

template <class T>
ordered_json orNull(const T& value, bool there) {
  return there ? ordered_json(value) : ordered_json();
}

std::string decimal(double number) {
  std::string text;
  model::appendNumber(text, number);
  return text;
}

/// Every file of the corpus by its path in the directory.
std::vector<std::pair<std::string, std::string>> allTexts() {
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<std::pair<std::string, std::string>> texts;
  for (const CorpusFile& file : files) {
    texts.emplace_back(file.id + ".t4d", file.bytes);
    if (file.describe) texts.emplace_back(file.id + ".json", expectedText(file));
  }
  texts.emplace_back("manifest.json", manifestText(files));
  texts.emplace_back("manifest.schema.json", kManifestSchema);
  texts.emplace_back("answers.schema.json", kAnswersSchema);
  texts.emplace_back("damaged.json", damagedText(files));
  texts.emplace_back("damaged.schema.json", kDamagedSchema);
  texts.emplace_back("README.md", kReadme);
  texts.emplace_back("CHANGELOG.md", kChangelog);
  texts.emplace_back("LICENSE", kLicense);
  texts.emplace_back("VERSION",
                     fmt::format("corpus {}\nformat {}\n", kCorpusVersion, kSpecVersion));
  return texts;
}

Result<std::string> contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    return fail(ErrorCode::Io, fmt::format("cannot read: {}", std::strerror(errno)), path.string());
  }
  return bytes;
}

/// A time at which a slice of an invalid file must be refused, too: every slice, or this one, reads
/// what breaks the rule. Nothing where that depends on the reader: it may do without the file
/// header, and need not look at what INDX says of other chunks and slabs, or compare DONE with it.
std::optional<double> timeToRefuse(const InvalidCase& made) {
  static const std::regex always("[FM].*|D[123457]|I[378]|O4|S[78]|S12");
  static const std::regex ofChunk("[ACLNPT].*|K[1-5]|S[2-9]|S1[01]");
  const CorpusFile& file = made.file;
  if (std::regex_match(file.rule, always)) return 0.5;
  if (!std::regex_match(file.rule, ofChunk)) return std::nullopt;
  const auto time = timeThatReads(file.bytes, *file.offset);
  return time ? time : timeThatReads(made.repaired, *file.offset);
}

}  // namespace

const char* nameOf(Validity validity) {
  switch (validity) {
    case Validity::Valid:
      return "valid";
    case Validity::Invalid:
      return "invalid";
    case Validity::Either:
      break;
  }
  return "either";
}

std::vector<CorpusFile> makeCorpus() {
  std::vector<CorpusFile> files;
  for (AcceptedCase& made : validCases()) files.push_back(std::move(made.file));
  for (InvalidCase& made : invalidCases()) {
    if (made.file.slices.empty()) {
      if (const auto time = timeToRefuse(made)) made.file.slices.push_back({*time, {}, {}});
    }
    files.push_back(std::move(made.file));
  }
  for (AcceptedCase& made : implCases()) files.push_back(std::move(made.file));
  std::sort(files.begin(), files.end(),
            [](const CorpusFile& a, const CorpusFile& b) { return a.id < b.id; });
  return files;
}

std::string manifestText(const std::vector<CorpusFile>& files) {
  ordered_json manifest = {{"corpus_version", kCorpusVersion},
                           {"spec_version", kSpecVersion},
                           {"files", ordered_json::array()}};
  for (const CorpusFile& file : files) {
    manifest["files"].push_back(
        {{"id", file.id},
         {"file", file.id + ".t4d"},
         {"sha256", sha256(file.bytes)},
         {"bytes", file.bytes.size()},
         {"result", nameOf(file.validity)},
         {"features", file.features},
         {"spec_version", kSpecVersion},
         {"clause", orNull(file.rule, !file.rule.empty())},
         {"fault", file.fault},
         {"offset", orNull(file.offset.value_or(0), file.offset.has_value())},
         {"expected", orNull(file.id + ".json", file.describe.has_value())}});
    if (file.validity != Validity::Invalid || file.slices.empty()) continue;
    for (const ExpectedSlice& slice : file.slices) {
      manifest["files"].back()["refused_slices"].push_back(decimal(slice.time));
    }
  }
  return manifest.dump(1) + "\n";
}

std::vector<std::string> wordsFor(const slice::Hyperplane& hyperplane) {
  const Eigen::Vector4d& n = hyperplane.normal;
  for (int axis = 0; axis < 3; ++axis) {
    if (n == Eigen::Vector4d::Unit(axis)) {
      return {std::string(1, "xyz"[axis]), fmt::format("{}", hyperplane.offset)};
    }
  }
  return {fmt::format("{},{},{},{}", n[0], n[1], n[2], n[3]), fmt::format("{}", hyperplane.offset)};
}

std::string expectedText(const CorpusFile& file) {
  const auto json = [](const std::string& answer, const std::string& within) {
    return ordered_json{{"answer", ordered_json::parse(answer)},
                        {"within", ordered_json::parse(within)}};
  };
  ordered_json expected = {{"describe", json(file.describe->json, file.describe->within)},
                           {"slices", ordered_json::array()},
                           {"sections", ordered_json::array()}};
  for (const ExpectedSlice& slice : file.slices) {
    ordered_json entry = {{"time", decimal(slice.time)}};
    entry.update(json(slice.answer, slice.within));
    expected["slices"].push_back(std::move(entry));
  }
  for (const ExpectedSection& section : file.sections) {
    ordered_json entry = {{"by", fmt::format("{}", fmt::join(wordsFor(section.hyperplane), " "))}};
    entry.update(json(section.answer, section.within));
    expected["sections"].push_back(std::move(entry));
  }
  return expected.dump(1) + "\n";
}

Result<void> writeCorpus(const std::filesystem::path& directory) {
  const auto texts = allTexts();
  std::vector<std::string> names;
  for (const auto& [name, text] : texts) names.push_back(name);
  const auto any = [](const std::filesystem::path&) { return true; };
  if (auto good = platform::checkReplaceable(directory, names, any); !good) return good;
  for (const auto& [name, text] : texts) {
    if (auto done = formats::writeInFolder(directory, name, text); !done) return done;
  }
  return {};
}

Result<std::vector<std::string>> verifyCorpus(const std::filesystem::path& directory) {
  std::vector<std::string> differences;
  std::set<std::filesystem::path> expected;
  for (const auto& [name, text] : allTexts()) {
    expected.insert(name);
    if (!std::filesystem::exists(directory / name)) {
      if (text.size() <= kKeptBytes) differences.push_back(fmt::format("{} is missing", name));
      continue;
    }
    auto found = contents(directory / name);
    if (!found) return found.error();
    if (*found == text) continue;
    const auto [at, end] = std::mismatch(found->begin(), found->end(), text.begin(), text.end());
    differences.push_back(fmt::format("{} is different from byte {} on", name,
                                      static_cast<std::size_t>(at - found->begin())));
  }
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory, error)) {
    if (!entry.is_regular_file()) continue;
    const auto name = entry.path().lexically_relative(directory);
    if (!expected.contains(name)) {
      differences.push_back(fmt::format("{} is not a file of the corpus", name.string()));
    }
  }
  if (error) return fail(ErrorCode::Io, error.message(), directory.string());
  return differences;
}

}  // namespace t4d::conformance
