#include "conformance/driver/reader_cases.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "conformance/driver/damage.h"
#include "formats/t4d/layout.h"

namespace t4d::conformance {
namespace {

using nlohmann::json;

/// The number of damaged copies that are made of valid files. A reader in Python (about 30 ms per
/// start) should take a minute or two for all of them; a thorough run is meant for a reader in C++
/// (1 ms) or one that serves.
struct DamageLimits {
  std::uint64_t smallBytes;  ///< a file of at most this size is truncated to every length
  std::size_t cuts;          ///< per larger file
  std::size_t flips;         ///< per larger file; small files get one in every part
};
constexpr DamageLimits kUsual = {730, 6, 8};
constexpr DamageLimits kThorough = {1000, 100, 100};
/// Larger files show nothing more when they are damaged, and take long.
constexpr std::size_t kMostDamaged = std::size_t{1} << 20;

std::string nameOf(const CorpusFile& file) { return file.id.substr(file.id.find('/') + 1); }

/// The first feature in HEAD that the reader does not support; empty if there is none.
std::string unknownFeature(const CorpusFile& file, const std::vector<std::string>& without) {
  if (!file.describe || without.empty()) return {};
  const json description = json::parse(file.describe->json);
  for (std::string feature : description["features"]) {
    if (std::find(without.begin(), without.end(), feature) != without.end()) return feature;
  }
  return {};
}

std::vector<std::string> sliceRequest(double time) { return {"slice", fmt::format("{}", time)}; }

/// "SLAB at byte 304, CONN at byte 152 and 3 more".
std::string namesOf(const std::vector<Part>& parts) {
  constexpr std::size_t kNamed = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(parts.size(), kNamed); ++i) {
    names += (i == 0 ? "" : ", ") + parts[i].name;
  }
  if (parts.size() > kNamed) names += fmt::format(" and {} more", parts.size() - kNamed);
  return names;
}

/// The trial with its request replaced by a slice.
Trial sliceInstead(Trial trial, double time) {
  trial.request = sliceRequest(time);
  trial.about = trial.about == "describe"
                    ? "slice " + trial.request[1]
                    : fmt::format("slice {}, {}", trial.request[1], trial.about);
  return trial;
}

ReaderCase corpusCase(const CorpusFile& file, const std::string& unknown, bool hyperplanes) {
  ReaderCase test{.id = file.id, .file = &file, .trials = {}, .skipped = {}};
  Trial trial;
  trial.about = "describe";
  trial.request = {"describe"};
  if (!unknown.empty()) {
    trial.wrongToAccept =
        fmt::format("it names the feature {}, which the reader does not know (M6)", unknown);
  } else if (file.validity == Validity::Invalid) {
    const std::string where = file.offset ? fmt::format(" at byte {}", *file.offset) : "";
    trial.wrongToAccept = fmt::format("rule {} is broken{}: {}", file.rule, where, file.fault);
  } else {
    if (file.validity == Validity::Valid) trial.wrongToRefuse = "the file is valid";
    if (file.describe) trial.answer = *file.describe;
  }
  test.trials.push_back(trial);
  if (file.validity == Validity::Invalid && unknown.empty()) {
    for (const ExpectedSlice& slice : file.slices) {
      test.trials.push_back(sliceInstead(trial, slice.time));
    }
  }
  if (!trial.wrongToAccept.empty()) return test;
  for (const ExpectedSlice& slice : file.slices) {
    trial.request = sliceRequest(slice.time);
    trial.about = "slice " + trial.request[1];
    trial.answer = {slice.answer, slice.within};
    test.trials.push_back(trial);
  }
  if (!hyperplanes) return test;
  for (const ExpectedSection& section : file.sections) {
    const std::vector<std::string> words = wordsFor(section.hyperplane);
    trial.request = {"slice", words[0], words[1]};
    trial.about = fmt::format("slice {} {}", words[0], words[1]);
    trial.answer = {section.answer, section.within};
    test.trials.push_back(trial);
  }
  return test;
}

std::vector<std::uint64_t> cutLengthsOf(const std::string& bytes, const DamageLimits& limits) {
  std::vector<std::uint64_t> lengths(bytes.size());
  std::iota(lengths.begin(), lengths.end(), 0);
  if (bytes.size() <= limits.smallBytes) return lengths;
  lengths.clear();
  const std::vector<std::uint64_t> all = cutLengths(bytes);
  for (const std::size_t i : someOf(all.size(), limits.cuts, bytes.size())) {
    lengths.push_back(all[i]);
  }
  return lengths;
}

/// One of the times at which the file is sliced.
double timeOf(const CorpusFile& file) { return file.slices[file.slices.size() / 2].time; }

ReaderCase cutCase(const CorpusFile& file, const DamageLimits& limits) {
  ReaderCase test{.id = "cut/" + nameOf(file), .file = &file, .trials = {}, .skipped = {}};
  const auto parts = partsForSlice(file.bytes, timeOf(file));
  const std::vector<std::uint64_t> lengths = cutLengthsOf(file.bytes, limits);
  // A slice starts from the footer, so a few lengths are enough.
  const std::size_t step = std::max<std::size_t>(1, lengths.size() / limits.cuts);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    Trial trial;
    trial.about = fmt::format("cut to {} bytes", lengths[i]);
    trial.request = {"describe"};
    trial.wrongToAccept =
        fmt::format("the end of the file is missing ({})", parts ? "F1" : "O3 and O5");
    trial.damage = Cut{lengths[i]};
    test.trials.push_back(trial);
    if (parts && i % step == 0) test.trials.push_back(sliceInstead(trial, timeOf(file)));
  }
  return test;
}

ReaderCase flipCase(const CorpusFile& file, const DamageLimits& limits) {
  ReaderCase test{.id = "flip/" + nameOf(file), .file = &file, .trials = {}, .skipped = {}};
  const std::vector<Part> parts = partsOf(file.bytes);
  const auto forSlice = partsForSlice(file.bytes, timeOf(file));
  const auto isRead = [&](std::uint64_t offset) {
    return forSlice && std::ranges::any_of(forSlice->read, [&](const Part& part) {
             return offset >= part.offset && offset < part.offset + part.size;
           });
  };
  const bool small = file.bytes.size() <= limits.smallBytes;
  const std::size_t most = small ? parts.size() : limits.flips;
  for (const std::size_t i : someOf(parts.size(), most, file.bytes.size())) {
    const Bit bit = bitOf(parts[i]);
    Trial trial;
    trial.about = fmt::format("bit {} of byte {} flipped", bit.bit, bit.offset);
    trial.request = {"describe"};
    trial.wrongToAccept = fmt::format("{} is damaged", parts[i].name);
    trial.damage = bit;
    test.trials.push_back(trial);
    if (isRead(bit.offset)) test.trials.push_back(sliceInstead(trial, timeOf(file)));
  }
  return test;
}

/// No trials if every slice needs everything, or the file has no index.
ReaderCase overwriteCase(const CorpusFile& file) {
  ReaderCase test{.id = "overwrite/" + nameOf(file), .file = &file, .trials = {}, .skipped = {}};
  Trial describing;
  for (const ExpectedSlice& slice : file.slices) {
    const auto parts = partsForSlice(file.bytes, slice.time);
    if (!parts || parts->unneeded.empty()) continue;
    Trial trial;
    trial.request = sliceRequest(slice.time);
    trial.about =
        fmt::format("slice {} with {} destroyed", trial.request[1], namesOf(parts->unneeded));
    trial.wrongToRefuse = "the slice needs none of these";
    trial.answer = {slice.answer, slice.within};
    const Garbage garbage = test.trials.size() % 2 == 0 ? Garbage::Ones : Garbage::Noise;
    trial.damage = Overwrite{parts->unneeded, garbage};
    describing = trial;
    describing.about = fmt::format("describe with {} destroyed", namesOf(parts->unneeded));
    test.trials.push_back(std::move(trial));
  }
  if (test.trials.empty()) return test;
  describing.request = {"describe"};
  describing.wrongToRefuse.clear();
  describing.wrongToAccept = "these are not readable";
  test.trials.push_back(std::move(describing));
  return test;
}

std::string kindOfCase(const ReaderCase& test) { return test.id.substr(0, test.id.find('/')); }

/// See CaseOptions::quick. The simplest cases come first, and are kept.
std::vector<ReaderCase> quickOf(std::vector<ReaderCase> cases) {
  std::map<std::string, std::size_t> smallest;  // file of each rule
  for (const ReaderCase& test : cases) {
    const std::size_t bytes = test.file->bytes.size();
    const auto [rule, isNew] = smallest.try_emplace(test.file->rule, bytes);
    if (!isNew) rule->second = std::min(rule->second, bytes);
  }
  std::set<std::string> seen;
  std::vector<ReaderCase> kept;
  for (ReaderCase& test : cases) {
    const CorpusFile& file = *test.file;
    bool shows = false;  // something that no case before does
    if (test.id != file.id) {
      shows = seen.insert(kindOfCase(test)).second;
    } else if (file.validity == Validity::Invalid) {
      shows = file.bytes.size() == smallest.at(file.rule) && seen.insert(file.rule).second;
    } else if (file.validity == Validity::Valid) {
      shows = file.features.empty() && seen.insert("").second;
      for (const std::string& feature : file.features) {
        shows = seen.insert("feature " + feature).second || shows;
      }
    }
    if (!shows) continue;
    const std::size_t most = file.validity == Validity::Invalid ? 1 : 3;
    const std::vector<std::size_t> some = someOf(test.trials.size(), most, 0);
    std::vector<Trial> trials;
    trials.reserve(some.size());
    for (const std::size_t i : some) trials.push_back(std::move(test.trials[i]));
    test.trials = std::move(trials);
    kept.push_back(std::move(test));
  }
  return kept;
}

}  // namespace

std::vector<std::string> whatAReaderMayLack() {
  std::vector<std::string> names(formats::t4d_layout::kFeatures.begin(),
                                 formats::t4d_layout::kFeatures.end());
  names.emplace_back(kHyperplanes);
  return names;
}

std::vector<ReaderCase> readerCases(const std::vector<CorpusFile>& files,
                                    const CaseOptions& options) {
  const DamageLimits& limits = options.thorough ? kThorough : kUsual;
  std::vector<const CorpusFile*> ordered;
  ordered.reserve(files.size());
  for (const CorpusFile& file : files) ordered.push_back(&file);
  const auto rank = [](Validity validity) {
    return validity == Validity::Valid ? 0 : validity == Validity::Either ? 1 : 2;
  };
  std::stable_sort(ordered.begin(), ordered.end(), [&](const auto* a, const auto* b) {
    if (a->validity != b->validity) return rank(a->validity) < rank(b->validity);
    if (a->validity != Validity::Valid) return false;
    return std::pair(a->features.size(), a->bytes.size()) <
           std::pair(b->features.size(), b->bytes.size());
  });
  std::vector<ReaderCase> cases;
  std::vector<ReaderCase> cuts;
  std::vector<ReaderCase> flips;
  std::vector<ReaderCase> overwrites;
  const bool hyperplanes = std::find(options.without.begin(), options.without.end(),
                                     kHyperplanes) == options.without.end();
  for (const CorpusFile* file : ordered) {
    const std::string unknown = unknownFeature(*file, options.without);
    cases.push_back(corpusCase(*file, unknown, hyperplanes));
    if (file->validity != Validity::Valid || file->bytes.size() > kMostDamaged) continue;
    cuts.push_back(cutCase(*file, limits));
    flips.push_back(flipCase(*file, limits));
    ReaderCase overwrite = overwriteCase(*file);
    if (!overwrite.trials.empty()) overwrites.push_back(std::move(overwrite));
    // A file that is refused because of its features shows nothing about damage.
    if (unknown.empty()) continue;
    for (auto* damaged : {&cuts, &flips, &overwrites}) {
      if (damaged->empty() || damaged->back().file != file) continue;
      damaged->back().skipped = "the file uses a feature named by --without";
    }
  }
  for (auto* more : {&cuts, &flips, &overwrites}) {
    std::move(more->begin(), more->end(), std::back_inserter(cases));
  }
  return options.quick ? quickOf(std::move(cases)) : cases;
}

std::string damagedText(const std::vector<CorpusFile>& files) {
  using nlohmann::ordered_json;
  std::vector<std::string> cases;  // a line each
  for (const ReaderCase& test : readerCases(files)) {
    if (test.id == test.file->id) continue;
    ordered_json trials = ordered_json::array();
    for (const Trial& trial : test.trials) {
      ordered_json entry = {{"request", fmt::format("{}", fmt::join(trial.request, " "))}};
      if (const auto* cut = std::get_if<Cut>(&trial.damage)) {
        entry["cut"] = cut->length;
      } else if (const auto* bit = std::get_if<Bit>(&trial.damage)) {
        entry["flip"] = {bit->offset, bit->bit};
      } else {
        const auto& over = std::get<Overwrite>(trial.damage);
        entry["overwrite"] = ordered_json::array();
        for (const Part& part : over.parts) entry["overwrite"].push_back({part.offset, part.size});
        entry["with"] = over.garbage == Garbage::Ones ? "ones" : "noise";
      }
      trials.push_back(std::move(entry));
    }
    const ordered_json entry = {
        {"id", test.id}, {"file", test.file->id + ".t4d"}, {"trials", std::move(trials)}};
    cases.push_back(entry.dump());
  }
  return fmt::format("{{\"corpus_version\": \"{}\", \"cases\": [\n{}\n]}}\n", kCorpusVersion,
                     fmt::join(cases, ",\n"));
}

}  // namespace t4d::conformance
