#include "t4d/formats/t4d/shared_join.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "t4d/formats/input_file.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/joiner.h"
#include "t4d/formats/t4d/member_reader.h"
#include "t4d/formats/t4d/reader.h"
#include "t4d/formats/t4d/url.h"
#include "t4d/formats/t4d/within_memory.h"
#include "t4d/formats/text/json_check.h"
#include "t4d/model/progress.h"
#include "t4d/system/crc32c.h"
#include "t4d/system/part_file.h"
#include "t4d/system/temporary_folder.h"

namespace t4d::formats {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kPlanVersion = 1;
constexpr const char* kPlanName = "plan.json";
constexpr const char* kRunsName = "runs";
constexpr const char* kMeshName = "mesh.t4d";

fs::path folderOf(const fs::path& into) {
  fs::path folder = followLinks(into);
  folder += ".joining";
  return folder;
}

/// The file that says that a part has been copied.
fs::path markOf(const fs::path& folder, std::size_t part) {
  return folder / fmt::format("copied-{}", part + 1);
}

/// Bytes of a part that are copied as they are.
struct Run {
  std::uint64_t from = 0;
  std::uint64_t to = 0;
  std::uint64_t bytes = 0;
};

/// A part, as far as its copying needs it.
struct PlannedPart {
  ManifestPart file;       // place, bytes and footer
  model::PartRange runs;   // its own of all runs
  std::string checksum;    // of these runs
  model::PartRange place;  // bytes of the joined file
};

struct Plan {
  fs::path folder;
  std::uint64_t bytes = 0;  // of the joined file
  std::vector<PlannedPart> parts;
};

/// Leaves room for the chunks of parts, and notes what goes there. Fronts that change are stored.
class RoomForParts : public CopyTarget {
 public:
  RoomForParts(ChunkWriter& file, OutputFile& runs) : CopyTarget(file), runs_(runs) {}

  Result<ChunkFile::Chunk> read(const ChunkFile& from, const ChunkHeader& known) const override {
    auto front = from.readFront(known);
    if (!front) return front.error();
    return ChunkFile::Chunk{known, {std::move(*front), {}}};
  }

  Result<std::uint64_t> put(const ChunkHeader& chunk, std::span<const std::byte> payload,
                            bool changed) override {
    const auto front = payload.first(changed ? chunk.frontBytes : 0);
    const auto offset = file().leaveRoom(chunk, front);
    if (!offset) return offset;
    const std::uint64_t stored = changed ? t4d_layout::kChunkHeaderBytes + front.size() : 0;
    const auto added = add({chunk.offset + stored, *offset + stored, chunk.bytes() - stored});
    return added ? offset : added.error();
  }

  Result<void> atBorder() override {
    if (auto done = flush(); !done) return done;
    borders_.push_back({count_, file().size(), fmt::format("{:08x}", std::exchange(sum_, 0))});
    return {};
  }

  /// Sets what is known of a part after the last border.
  void describe(std::size_t part, PlannedPart& planned) const {
    planned.runs = {borders_[part].runs, borders_[part + 1].runs};
    planned.checksum = borders_[part + 1].checksum;
    planned.place = {borders_[part].bytes, borders_[part + 1].bytes};
  }

 private:
  /// What there is before it.
  struct Border {
    std::uint64_t runs = 0;
    std::uint64_t bytes = 0;
    std::string checksum;  // of the runs since the last border
  };

  Result<void> add(const Run& run) {
    if (run.bytes == 0) return {};
    if (last_.bytes > 0 && last_.from + last_.bytes == run.from &&
        last_.to + last_.bytes == run.to) {
      last_.bytes += run.bytes;
      return {};
    }
    if (auto done = flush(); !done) return done;
    last_ = run;
    return {};
  }

  Result<void> flush() {
    const Run run = std::exchange(last_, Run());
    if (run.bytes == 0) return {};
    ++count_;
    sum_ = system::crc32c(&run, sizeof run, sum_);
    return runs_.write(&run, sizeof run);
  }

  OutputFile& runs_;
  Run last_;
  std::uint64_t count_ = 0;
  std::uint32_t sum_ = 0;
  std::vector<Border> borders_;
};

std::string planText(const Plan& plan) {
  ordered_json parts = ordered_json::array();
  for (const PlannedPart& part : plan.parts) {
    parts.push_back({{"path", part.file.path},
                     {"bytes", part.file.bytes},
                     {"footer", part.file.footer},
                     {"runs", part.runs.size()},
                     {"checksum", part.checksum},
                     {"begin", part.place.begin},
                     {"end", part.place.end}});
  }
  return ordered_json({{"joining", kPlanVersion}, {"bytes", plan.bytes}, {"parts", parts}})
             .dump(1) +
         "\n";
}

Result<Plan> parsePlan(const std::string& text, const std::string& name) {
  if (auto sound = checkJson(text, name); !sound) return sound.error();
  const ordered_json json = ordered_json::parse(text, nullptr, false);
  MemberReader from(json, "the plan");
  const std::uint64_t version = from.count("joining");
  Plan plan;
  plan.bytes = from.count("bytes");
  const ordered_json& parts = from.array("parts");
  if (auto sound = from.result(); !sound) return sound.error();
  if (version != kPlanVersion) {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("is a plan of version {}; this program reads {}", version, kPlanVersion));
  }
  std::uint64_t runs = 0;
  std::uint64_t end = 0;
  for (const ordered_json& each : parts) {
    MemberReader row(each, fmt::format("part {}", plan.parts.size() + 1));
    PlannedPart part;
    part.file.path = row.text("path");
    part.file.bytes = row.count("bytes");
    part.file.footer = row.hex("footer", 2 * t4d_layout::kFooterBytes);
    part.runs = {runs, runs + row.count("runs")};
    part.checksum = row.hex("checksum", 2 * sizeof(std::uint32_t));
    part.place = {row.count("begin"), row.count("end")};
    if (auto sound = row.result(); !sound) return sound.error();
    if (part.place.begin < end || part.place.end < part.place.begin ||
        part.place.end > plan.bytes) {
      return invalid(fmt::format("part {} has no place in the file", plan.parts.size() + 1));
    }
    runs = part.runs.end;
    end = part.place.end;
    plan.parts.push_back(std::move(part));
  }
  return plan;
}

/// Where the paths of parts begin in the plan.
fs::path baseOf(const fs::path& folder) { return fs::absolute(folder).parent_path(); }

bool isPlanned(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / kPlanName, ignored);
}

Result<Plan> readPlan(const fs::path& into) {
  const fs::path folder = folderOf(into);
  const fs::path name = folder / kPlanName;
  std::error_code error;
  if (!fs::exists(name, error)) {
    return fail(
        ErrorCode::InvalidInput,
        error ? fmt::format("cannot read {}: {}", name.string(), error.message())
              : fmt::format("no join into this file is planned: there is no {}", name.string()),
        into.string());
  }
  const auto file = readInputFile(name);
  if (!file) return file.error();
  auto plan = parsePlan(file->bytes, name.string());
  if (!plan) {
    return fail(plan.error().code,
                fmt::format("{}; remove the folder {} and plan again", plan.error().message,
                            folder.string()),
                name.string());
  }
  plan->folder = folder;
  for (PlannedPart& part : plan->parts) {
    const bool remote = !schemeOf(part.file.path).empty();
    part.file.place = part.file.path;
    if (!remote) part.file.place = (baseOf(folder) / part.file.place).lexically_normal();
  }
  return plan;
}

/// Checks that a file can get this name, and that no join into it is planned.
Result<void> checkTarget(const fs::path& into, const fs::path& folder) {
  std::error_code ignored;
  const fs::file_status there = fs::status(into, ignored);
  if (into == "-" ||
      (fs::exists(there) && !fs::is_regular_file(there) && !fs::is_directory(there))) {
    return fail(ErrorCode::Options,
                "is not a regular file, and cannot be written by many processes", into.string());
  }
  if (const auto possible = OutputFile::create(into); !possible) return possible.error();
  if (isPlanned(folder)) {
    return fail(ErrorCode::Failed,
                fmt::format("a join into this file is planned already; finish it, or remove the "
                            "folder {}",
                            folder.string()),
                into.string());
  }
  fs::remove_all(folder, ignored);  // what a finished join has left
  return {};
}

Result<void> checkRoom(const fs::path& folder, std::uint64_t bytes, const fs::path& into) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error || space.available >= bytes) return {};
  return fail(ErrorCode::Failed,
              fmt::format("needs {} bytes, and the disk has room for {}", bytes, space.available),
              into.string());
}

/// Fails if the file has no index.
Result<std::string> footerOf(ByteSource& file) {
  auto footer = footerText(file);
  if (footer) return footer;
  return fail(ErrorCode::InvalidInput,
              "has no index, which a planned join needs; join without a plan, or rewrite it with "
              "an index",
              file.name());
}

/// Path, size and footer of the parts.
Result<std::vector<PlannedPart>> identify(const std::vector<JoinedPart>& parts,
                                          const fs::path& base) {
  std::vector<PlannedPart> planned;
  for (const JoinedPart& part : parts) {
    auto file = openByteSource(part.place);
    if (!file) return file.error();
    auto footer = footerOf(**file);
    if (!footer) return footer.error();
    PlannedPart one;
    const bool remote = !schemeOf(part.place.native()).empty();
    one.file.path =
        remote ? part.place.string()
               : fs::absolute(part.place).lexically_normal().lexically_proximate(base).string();
    one.file.bytes = (*file)->size();
    one.file.footer = std::move(*footer);
    planned.push_back(std::move(one));
  }
  return planned;
}

/// Opens a part; fails if it is not the one that was planned.
Result<std::unique_ptr<ByteSource>> openPlanned(const ManifestPart& part) {
  auto file = openByteSource(part.place);
  if (!file) return file;
  const auto footer = footerText(**file);
  if ((*file)->size() == part.bytes && footer && *footer == part.footer) return file;
  return fail(ErrorCode::InvalidInput,
              "is not the file that was planned; restore it, or remove the plan and plan again",
              shownName(part.place.native()));
}

/// Writes the joined file without what is copied, and the plan, into `folder`.
Result<JoinReport> writePlan(const Joiner& joiner, const fs::path& folder,
                             std::vector<PlannedPart> parts, const model::Progress& progress) {
  auto runs = OutputFile::create(folder / kRunsName);
  if (!runs) return runs.error();
  auto file = joiner.beginFile(folder / kMeshName);
  if (!file) return file.error();
  RoomForParts room(*file, *runs);
  auto report = joiner.write(room, progress);
  if (!report) return report;
  if (auto done = runs->commit(); !done) return done.error();
  for (std::size_t i = 0; i < parts.size(); ++i) room.describe(i, parts[i]);
  const std::string text = planText({folder, report->bytes, std::move(parts)});
  const auto written = writeOutputFile(folder / kPlanName, text);
  return written ? report : written.error();
}

Result<std::vector<Run>> readRuns(const Plan& plan, const PlannedPart& part) {
  const fs::path name = plan.folder / kRunsName;
  auto file = openFileSource(name);
  if (!file) return file.error();
  const auto wrong = [&] {
    return fail(ErrorCode::InvalidInput, "is not what the plan says: it is damaged", name.string());
  };
  if ((*file)->size() / sizeof(Run) < part.runs.end) return wrong();
  std::vector<Run> runs(part.runs.size());
  const auto bytes = std::as_writable_bytes(std::span(runs));
  if (auto done = (*file)->read(part.runs.begin * sizeof(Run), bytes); !done) {
    return done.error();
  }
  if (fmt::format("{:08x}", system::crc32c(bytes.data(), bytes.size())) != part.checksum) {
    return wrong();
  }
  for (const auto& [from, to, size] : runs) {
    const bool inPart = size <= part.file.bytes && from <= part.file.bytes - size;
    const bool inPlace =
        to >= part.place.begin && to <= part.place.end && size <= part.place.end - to;
    if (!inPart || !inPlace) return wrong();
  }
  return runs;
}

Result<void> copyRun(ByteSource& from, const Run& run, OutputFile& into,
                     const std::function<void(std::uint64_t)>& copied) {
  constexpr std::uint64_t kAtOnce = std::uint64_t{4} << 20;
  std::vector<std::byte> some(std::min(run.bytes, kAtOnce));
  for (std::uint64_t done = 0; done < run.bytes; done += some.size()) {
    some.resize(std::min<std::uint64_t>(some.size(), run.bytes - done));
    if (auto read = from.read(run.from + done, some); !read) return read;
    if (auto put = into.rewrite(run.to + done, some.data(), some.size()); !put) return put;
    copied(some.size());
  }
  return {};
}

/// Checks every chunk of a part in the joined file.
Result<void> checkCopy(const Plan& plan, const PlannedPart& part,
                       const std::function<void(std::uint64_t)>& checked) {
  const auto file = ChunkFile::open(plan.folder / kMeshName);
  if (!file) return file.error();
  for (std::uint64_t at = part.place.begin; at < part.place.end;) {
    const auto header = file->readChunkHeader(at);
    if (!header) return header.error();
    if (auto payload = file->readPayload(*header); !payload) return payload.error();
    checked(header->bytes());
    at = header->end();
  }
  return {};
}

Result<void> copyPart(const Plan& plan, const PlannedPart& part, const model::Progress& progress) {
  const auto from = openPlanned(part.file);
  if (!from) return from.error();
  const auto runs = readRuns(plan, part);
  if (!runs) return runs.error();
  auto into = OutputFile::openToRewrite(plan.folder / kMeshName, OutputFile::Sharing::Shared);
  if (!into) return into.error();
  std::uint64_t done = 0;
  const auto add = [&](std::uint64_t bytes) {
    done += bytes;
    if (progress) {
      progress(std::min(
          1.0, static_cast<double>(done) / (2.0 * static_cast<double>(part.place.size()))));
    }
  };
  for (const Run& run : *runs) {
    if (auto copied = copyRun(**from, run, *into, add); !copied) return copied;
  }
  if (auto onDisk = into->commit(); !onDisk) return onDisk;
  if (auto sound = checkCopy(plan, part, add); !sound) {
    return fail(sound.error().code,
                fmt::format("its copy is damaged: {}; check the file, and copy it again",
                            sound.error().text()),
                shownName(part.file.place.native()));
  }
  return {};
}

Result<void> checkMesh(const Plan& plan, const fs::path& into) {
  std::vector<std::string> missing;
  std::error_code ignored;
  for (std::size_t i = 0; i < plan.parts.size(); ++i) {
    if (fs::exists(markOf(plan.folder, i), ignored)) continue;
    missing.push_back(plan.parts[i].file.place.filename().string());
  }
  if (missing.empty()) return {};
  constexpr std::size_t kShown = 10;
  const bool many = missing.size() > kShown;
  const std::size_t count = missing.size();
  if (many) missing.resize(kShown);
  return fail(ErrorCode::InvalidInput,
              fmt::format("{} of {} files {} not copied yet: {}{}", count, plan.parts.size(),
                          count == 1 ? "is" : "are", fmt::join(missing, ", "), many ? ", ..." : ""),
              into.string());
}

/// Gives the folder of a plan its name, and the rights that folders usually have.
Result<void> place(const system::TemporaryFolder& plan, const fs::path& folder,
                   const fs::path& into) {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::chmod(plan.path().c_str(), 0777 & ~mask);
  std::error_code error;
  fs::rename(plan.path(), folder, error);
  if (!error) return system::syncNames(folder);
  const std::string reason =
      isPlanned(folder) ? "another process has planned a join into this file meanwhile"
                        : fmt::format("cannot make {}: {}", folder.string(), error.message());
  return fail(ErrorCode::Failed, reason, into.string());
}

/// Removes the folder of a plan that is done; what is left of it, if that fails, is no plan.
Result<void> removePlan(const fs::path& folder, const fs::path& into) {
  std::error_code error;
  fs::remove(folder / kPlanName, error);
  if (!error) fs::remove_all(folder, error);
  if (!error) return {};
  return fail(ErrorCode::Failed,
              fmt::format("is complete, but the folder {} cannot be removed: {}", folder.string(),
                          error.message()),
              into.string());
}

/// The report on the joined file, at `place`.
Result<JoinReport> reportOf(const Plan& plan, const fs::path& place) {
  const auto reader = T4dReader::open(place, T4dOpen::Whole, {}, kAnyCells);
  if (!reader) return reader.error();
  if (reader->fileBytes() != plan.bytes) {
    return fail(ErrorCode::InvalidInput,
                fmt::format("has {} bytes, and {} were planned: the plan, or this, is damaged",
                            reader->fileBytes(), plan.bytes),
                place.string());
  }
  JoinReport report{{}, plan.bytes, {}, plan.parts.size()};
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) report.bodies.push_back(reader->summary(i));
  return report;
}

/// Gives the joined file its name, while nobody else writes to it.
Result<void> nameMesh(const fs::path& mesh, const fs::path& into) {
  const auto alone = OutputFile::openToRewrite(mesh, OutputFile::Sharing::Alone);
  if (!alone) {
    return fail(alone.error().code,
                fmt::format("cannot be finished: {}; wait until no part is copied any more",
                            alone.error().text()),
                into.string());
  }
  std::error_code error;
  fs::rename(mesh, followLinks(into), error);
  if (!error) return system::syncNames(followLinks(into));
  return fail(ErrorCode::Failed, "cannot be written: " + error.message(), into.string());
}

}  // namespace

Result<JoinReport> planJoin(const std::vector<fs::path>& files, const fs::path& into,
                            const model::Progress& progress) {
  const fs::path folder = folderOf(into);
  if (auto free = checkTarget(into, folder); !free) return free.error();
  const auto parts = joinedParts(files);
  if (!parts) return parts.error();
  Joiner joiner;
  if (auto read = joiner.addAll(*parts, model::partOf(progress, 0, Joiner::kReading)); !read) {
    return read.error();
  }
  auto planned = identify(*parts, baseOf(folder));
  if (!planned) return planned.error();
  const auto temporary = system::TemporaryFolder::createIn(
      baseOf(folder), fmt::format(".{}-", folder.filename().string()));
  if (!temporary) return temporary.error();
  auto report = withinMemory(into.string(), [&] {
    return writePlan(joiner, temporary->path(), std::move(*planned),
                     model::partOf(progress, Joiner::kReading, 1));
  });
  if (report) {
    if (auto room = checkRoom(temporary->path(), report->bytes, into); !room) {
      return room.error();
    }
    if (auto placed = place(*temporary, folder, into); !placed) return placed.error();
    return report;
  }
  Error error = report.error();
  if (error.where.file.starts_with(temporary->path().string())) error.where = into.string();
  return error;
}

Result<std::uint64_t> plannedParts(const fs::path& into) {
  const auto plan = readPlan(into);
  if (!plan) return plan.error();
  return plan->parts.size();
}

Result<SharedCopy> copyPlannedParts(const fs::path& into, const model::Part& share,
                                    const model::Progress& progress) {
  const auto plan = readPlan(into);
  if (!plan) return plan.error();
  const model::PartRange own = share.of(plan->parts.size());
  SharedCopy copied;
  for (std::uint64_t i = own.begin; i < own.end; ++i) {
    const fs::path mark = markOf(plan->folder, i);
    std::error_code ignored;
    if (fs::exists(mark, ignored)) continue;
    const PlannedPart& part = plan->parts[i];
    const auto done = withinMemory(part.file.place.string(), [&] {
      return copyPart(*plan, part, model::eachOf(progress, i - own.begin, own.size()));
    });
    if (!done) {
      if (isPlanned(plan->folder)) return done.error();
      return fail(ErrorCode::Failed, "the join was finished, or given up, meanwhile",
                  into.string());
    }
    if (auto marked = writeOutputFile(mark, ""); !marked) return marked.error();
    ++copied.parts;
    copied.bytes += part.place.size();
  }
  return copied;
}

Result<JoinReport> finishJoin(const fs::path& into) {
  const auto plan = readPlan(into);
  if (!plan) return plan.error();
  const fs::path mesh = plan->folder / kMeshName;
  std::error_code ignored;
  // Otherwise it has been finished, but for the folder.
  const bool isThere = fs::exists(mesh, ignored);
  if (isThere) {
    if (auto complete = checkMesh(*plan, into); !complete) return complete.error();
  }
  auto report = reportOf(*plan, isThere ? mesh : into);
  if (!report) return report;
  if (isThere) {
    if (auto named = nameMesh(mesh, into); !named) return named.error();
  }
  const auto removed = removePlan(plan->folder, into);
  return removed ? std::move(report) : removed.error();
}

}  // namespace t4d::formats
