#include "conformance/driver/writer_suite.h"

#include <bit>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/corpus.h"
#include "formats/output_folder.h"
#include "formats/t4d/chunk_list.h"
#include "model/progress.h"
#include "platform/replaceable.h"
#include "platform/temporary_folder.h"
#include "t4d/check.h"
#include "t4d/file.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;
using model::Attribute;
using model::Connectivity;
using model::Domain;
using model::Slab;

bool sameJson(const std::string& a, const std::string& b) {
  return nlohmann::json::parse(a, nullptr, false) == nlohmann::json::parse(b, nullptr, false);
}

/// Differences between what is expected and what is found, in words.
class Differences {
 public:
  template <class T>
  void compare(const std::string& what, const T& expected, const T& found) {
    if (expected == found) return;
    add(fmt::format("{} is {}; expected {}", what, found, expected));
  }
  void add(std::string text) { texts.push_back(std::move(text)); }

  std::vector<std::string> texts;
};

void compareHeads(const formats::Metadata& expected, const formats::Metadata& found,
                  Differences& differences) {
  differences.compare("length_unit", expected.lengthUnit, found.lengthUnit);
  differences.compare("time_unit", expected.timeUnit, found.timeUnit);
  differences.compare("up", expected.up, found.up);
  differences.compare("backend", expected.backend, found.backend);
  if (!sameJson(expected.detailsJson, found.detailsJson)) differences.add("details are others");
  differences.compare("the number of bodies", expected.bodies.size(), found.bodies.size());
  if (expected.bodies.size() != found.bodies.size()) return;
  for (std::size_t i = 0; i < expected.bodies.size(); ++i) {
    const formats::BodyInfo& a = expected.bodies[i];
    const formats::BodyInfo& b = found.bodies[i];
    const auto named = [&](const char* what) { return fmt::format("{} of body {}", what, i); };
    differences.compare(named("the name"), a.name, b.name);
    differences.compare(named("the color"), a.color, b.color);
    differences.compare(named("the material"), a.material, b.material);
    differences.compare(named("the parent"), a.parent, b.parent);
    if (!sameJson(a.detailsJson, b.detailsJson)) differences.add(named("the details") + " differ");
  }
}

std::string textOfPoint(const model::Point4& p) {
  return fmt::format("({}, {}, {}, {})", p[0], p[1], p[2], p[3]);
}

/// Coordinates have to have the same bits; a time is a number, and -0 equals 0.
bool sameVertex(const model::Point4& a, const model::Point4& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0 && a[3] == b[3];
}

void compareVertices(const Slab& expected, const Slab& found, const std::string& where,
                     Differences& differences) {
  for (std::size_t i = 0; i < expected.vertices.size(); ++i) {
    const model::Point4& a = expected.vertices[i];
    const model::Point4& b = found.vertices[i];
    if (sameVertex(a, b)) continue;
    model::Point4 rounded = a;
    rounded.head<3>() = a.head<3>().cast<float>().cast<double>();
    differences.add(fmt::format(
        "vertex {} of {} is {}; expected {}{}", i, where, textOfPoint(b), textOfPoint(a),
        sameVertex(rounded, b) ? ": it is rounded to binary32; store type 10" : ""));
    return;
  }
}

std::vector<const Attribute*> ofDomain(const Slab& slab, Domain domain) {
  std::vector<const Attribute*> list;
  for (const Attribute& attribute : slab.attributes) {
    if (attribute.domain == domain) list.push_back(&attribute);
  }
  return list;
}

void compareAttributes(const std::vector<const Attribute*>& expected,
                       const std::vector<const Attribute*>& found, const std::string& where,
                       Differences& differences) {
  const auto names = [](const std::vector<const Attribute*>& list) {
    std::string text;
    for (const Attribute* each : list) {
      text += fmt::format("{}'{}' of type {}, {} components", text.empty() ? "" : ", ", each->name,
                          static_cast<int>(each->type), each->components);
    }
    return text.empty() ? std::string("none") : text;
  };
  if (names(expected) != names(found)) {
    differences.add(fmt::format("the attributes of {} are {}; expected {}", where, names(found),
                                names(expected)));
    return;
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Attribute& a = *expected[i];
    const Attribute& b = *found[i];
    if (a.values == b.values) continue;
    std::size_t row = 0;
    while (row < std::min(a.rows(), b.rows()) &&
           std::memcmp(a.row(row), b.row(row), a.rowBytes()) == 0) {
      ++row;
    }
    differences.add(
        fmt::format("attribute '{}' of {} has other values from row {} on", a.name, where, row));
  }
}

void compareConnectivity(const Connectivity& expected, const Connectivity& found,
                         const std::string& where, Differences& differences) {
  const auto named = [&](const char* what) {
    return fmt::format("the number of {} of {}", what, where);
  };
  differences.compare(named("vertices"), expected.vertexCount, found.vertexCount);
  differences.compare(named("vertices of the lower layer"), expected.lowerCount, found.lowerCount);
  differences.compare(named("vertices of the upper layer"), expected.upperCount, found.upperCount);
  differences.compare(named("cells"), expected.cells.size(), found.cells.size());
  differences.compare(named("means"), expected.means.size(), found.means.size());
  if (expected.cells.size() == found.cells.size() && expected.cells != found.cells) {
    std::size_t i = 0;
    while (expected.cells[i] == found.cells[i]) ++i;
    const auto text = [](const model::Cell& c) {
      return fmt::format("({}, {}, {}, {})", c[0], c[1], c[2], c[3]);
    };
    differences.add(fmt::format("cell {} of {} is {}; expected {}", i, where, text(found.cells[i]),
                                text(expected.cells[i])));
  }
  if (expected.means.size() == found.means.size() && expected.means != found.means) {
    differences.add(fmt::format("means of {} have other sources", where));
  }
}

void compareSlabs(const Slab& expected, const Slab& found, const std::string& where,
                  Differences& differences) {
  differences.compare("begin of " + where, expected.timeBegin, found.timeBegin);
  differences.compare("end of " + where, expected.timeEnd, found.timeEnd);
  const Connectivity& a = *expected.connectivity;
  const Connectivity& b = *found.connectivity;
  compareConnectivity(a, b, where, differences);
  if (a.vertexCount == b.vertexCount) compareVertices(expected, found, where, differences);
  for (const Domain domain : {Domain::Vertex, Domain::Cell}) {
    compareAttributes(ofDomain(expected, domain), ofDomain(found, domain),
                      where + (domain == Domain::Vertex ? ", per vertex" : ", per cell"),
                      differences);
  }
  const auto pointers = [](const std::vector<Attribute>& attributes) {
    std::vector<const Attribute*> list;
    for (const Attribute& attribute : attributes) list.push_back(&attribute);
    return list;
  };
  compareAttributes(pointers(a.cellAttributes), pointers(b.cellAttributes),
                    "the connectivity of " + where, differences);
}

/// Whether the body bounds a solid: what it lacks, or an empty text.
Result<std::string> openness(const model::Source& body) {
  const auto report = measure::checkMesh(body);
  if (!report) return report.error();
  if (!report->closed) return std::string("not closed");
  return std::string(report->oriented ? report->hypervolume < 0 ? "turned inside out" : ""
                                      : "not oriented");
}

Result<void> compareBodies(const WriterCase& test, const formats::T4dReader& reader,
                           Differences& differences) {
  for (std::size_t i = 0; i < test.bodies.size(); ++i) {
    const model::Mesh& expected = test.bodies[i];
    const model::Source& found = reader.body(i);
    const std::string name = fmt::format("body {}", i);
    const auto before = openness(expected);
    const auto after = openness(found);
    if (!before) return before.error();
    if (!after) return after.error();
    if (before->empty() && !after->empty()) {
      differences.add(fmt::format("{} is {}, other than the mesh in MESH.json", name, *after));
    }
    differences.compare("the number of slabs of " + name, expected.slabCount(), found.slabCount());
    if (expected.slabCount() != found.slabCount()) continue;
    for (std::size_t k = 0; k < expected.slabCount(); ++k) {
      const auto slab = found.slab(k);
      if (!slab) return slab.error();
      compareSlabs(expected.slabs()[k], **slab, fmt::format("slab {} of {}", k, name), differences);
    }
  }
  return {};
}

/// Whether each part is in the file once. Readers do not notice.
Result<void> countParts(const WriterCase& test, const fs::path& path, Differences& differences) {
  auto source = formats::openFileSource(path);
  if (!source) return source.error();
  std::string bytes((*source)->size(), '\0');
  if (auto done = (*source)->read(0, std::as_writable_bytes(std::span(bytes))); !done) return done;
  std::map<std::string, std::size_t> counts;
  for (const formats::ChunkHeader& chunk : formats::listChunks(bytes)) ++counts[chunk.name()];
  const MeshText text = textOf(test);
  const auto check = [&](const char* type, const char* what, std::size_t listed,
                         std::size_t again) {
    if (counts[type] <= listed + again) return;
    differences.add(fmt::format(
        "{} {} are stored; MESH.json has {} {}, each of which is stored once and named by all "
        "slabs that have it{}",
        counts[type], type, listed, what,
        again > 0 ? fmt::format(", but {}, which S12 asks for again", again) : ""));
  };
  check("CONN", "connectivities", text.connectivities, test.storedAgain);
  check("LAYR", "layers", text.layers, 0);
  return {};
}

/// Runs the cases, each in a process. Threads take them from one queue, in order.
class WriterRun {
 public:
  WriterRun(const std::vector<WriterCase>& cases, const WriterOptions& options,
            const fs::path& folder, const model::Progress& progress)
      : cases_(cases), options_(options), folder_(folder), progress_(progress) {
    for (const WriterCase& test : cases) {
      reports_.push_back({test.id, Outcome::Skipped,
                          test.skipped.empty() ? "not run: the run ended before" : test.skipped});
    }
  }

  Result<std::vector<CaseReport>> run() {
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < std::max(1U, options_.parallel); ++i) {
      threads.emplace_back([this, i] { work(folder_ / fmt::format("{}", i)); });
    }
    for (std::thread& thread : threads) thread.join();
    if (error_) return *error_;
    return reports_;
  }

 private:
  void work(const fs::path& folder) {
    while (!ended_ && !(options_.stop != nullptr && *options_.stop)) {
      const std::size_t i = next_++;
      if (i >= cases_.size()) break;
      if (!cases_[i].skipped.empty()) continue;
      auto report = tried(cases_[i], folder);
      const std::lock_guard lock(mutex_);
      if (!report) {
        error_ = report.error();
        ended_ = true;
        return;
      }
      if (report->isWrong() && options_.first) ended_ = true;
      if (report->outcome != Outcome::Skipped) reports_[i] = std::move(*report);
      if (auto on = model::report(progress_, i + 1, cases_.size()); !on) {
        error_ = on.error();
        ended_ = true;
      }
    }
  }

  Result<CaseReport> tried(const WriterCase& test, const fs::path& folder) const {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    const fs::path mesh = folder / "MESH.json";
    const fs::path file = folder / "OUT.t4d";
    if (auto written = formats::writeInFolder(folder, "MESH.json", textOf(test).json); !written) {
      return written.error();
    }
    std::vector<std::string> words = options_.command;
    words.insert(words.end(), {mesh.string(), file.string()});
    auto run = platform::runProgram(
        words, {.limit = platform::TimeLimit::ofProcessor(options_.timeoutSeconds),
                .stop = options_.stop});
    if (!run) return run.error();
    Trial trial;
    trial.wrongToRefuse = "a .t4d can hold this mesh";
    const TrialResult ended =
        evaluate(trial, replyOf(std::move(*run)), mesh.string(), options_.timeoutSeconds);
    CaseReport report{test.id, ended.outcome, ended.message, ended.seconds};
    if (report.outcome == Outcome::Passed) {
      const std::vector<std::string> faults = faultsOf(test, file);
      if (!faults.empty()) report.outcome = Outcome::Failed;
      constexpr std::size_t kShown = 3;
      for (std::size_t i = 0; i < std::min(faults.size(), kShown); ++i) {
        report.message += (i == 0 ? "" : "; ") + faults[i];
      }
      if (faults.size() > kShown) {
        report.message += fmt::format("; and {} more", faults.size() - kShown);
      }
    }
    if (report.isWrong() && !options_.keep.empty()) {
      const std::string copy = test.id + ".t4d";
      const auto any = [](const fs::path&) { return true; };
      auto written = platform::checkReplaceable(options_.keep, {&copy, 1}, any);
      if (written) {
        written = formats::writeInFolder(options_.keep, test.id + ".json", textOf(test).json);
      }
      if (!written) return written.error();
      fs::copy_file(file, options_.keep / copy, fs::copy_options::overwrite_existing, ignored);
    }
    return report;
  }

  const std::vector<WriterCase>& cases_;
  const WriterOptions& options_;
  const fs::path& folder_;
  const model::Progress& progress_;
  std::vector<CaseReport> reports_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> ended_ = false;  // by an error, or WriterOptions::first
  std::mutex mutex_;                 // guards reports_, error_ and progress_
  std::optional<Error> error_;
};

}  // namespace

std::vector<std::string> faultsOf(const WriterCase& test, const fs::path& file) {
  const auto fault = [](Error error) -> std::vector<std::string> {
    error.where = "OUT.t4d";
    return {error.text()};
  };
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {"exited with 0 and wrote no OUT.t4d"};
  if (auto checked = formats::checkT4dFile(file); !checked) return fault(checked.error());
  auto reader = formats::T4dReader::open(file, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return fault(reader.error());
  Differences differences;
  compareHeads(test.metadata, reader->metadata(), differences);
  if (reader->bodyCount() == test.bodies.size()) {
    if (auto done = compareBodies(test, *reader, differences); !done) return fault(done.error());
  }
  if (auto done = countParts(test, file, differences); !done) return fault(done.error());
  return differences.texts;
}

Result<std::vector<CaseReport>> runWriterCases(const std::vector<WriterCase>& cases,
                                               const WriterOptions& options,
                                               const model::Progress& progress) {
  const auto folder = platform::TemporaryFolder::create();
  if (!folder) return folder.error();
  return WriterRun(cases, options, folder->path(), progress).run();
}

std::string writerReportText(const std::string& writer, const std::string& command,
                             const std::vector<WriterCase>& cases,
                             const std::vector<CaseReport>& reports, std::size_t most) {
  std::string text;
  std::size_t wrong = 0;
  const CaseReport* first = nullptr;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!reports[i].isWrong()) continue;
    if (first == nullptr) first = &reports[i];
    if (++wrong <= most) text += failureText(reports[i], cases[i].about);
  }
  if (wrong > most) text += fmt::format("and {} more (--verbose lists all)\n", wrong - most);
  if (wrong > 0) text += "\n";
  text += outcomeTable(reports);
  if (first == nullptr) {
    return text + fmt::format("{} of {} cases of corpus {} passed, none failed\n",
                              countsOf(reports)[static_cast<std::size_t>(Outcome::Passed)],
                              cases.size(), kCorpusVersion);
  }
  return text + fmt::format(
                    "\nLook first at {0}:\n  {1} --only {0} --keep kept\n"
                    "  {2} kept/{0}.json out.t4d; echo $?\n  t4d validate out.t4d\n",
                    first->id, command, writer);
}

}  // namespace t4d::conformance
