#include "tools/verbs/view.h"

#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/input_file.h"
#include "formats/output_file.h"
#include "formats/t4d/join.h"
#include "formats/t4d/manifest.h"
#include "formats/t4d/url.h"
#include "formats/text/json_check.h"
#include "model/amount_text.h"
#include "platform/kept_inputs.h"
#include "platform/temporary_folder.h"
#include "tools/verbs/input.h"
#include "tools/verbs/members.h"

namespace t4d::verbs {
namespace {

namespace fs = std::filesystem;

/// Browsers take pages of this size; a folder has no limit.
constexpr std::uint64_t kMostInPage = std::uint64_t{64} << 20;

/// The inputs, of which those in parts are joined.
struct WholeFiles {
  std::vector<std::string> paths;
  std::shared_ptr<const platform::TemporaryFolder> joined;
};

Result<WholeFiles> wholeFiles(const std::vector<std::string>& inputs, Observer& observer) {
  WholeFiles whole{.paths = inputs, .joined = nullptr};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (!formats::isManifest(inputs[i])) continue;
    if (!whole.joined) {
      auto made = platform::TemporaryFolder::create();
      if (!made) return made.error();
      whole.joined = std::make_shared<platform::TemporaryFolder>(std::move(*made));
    }
    const std::string name = fs::path(formats::shownName(inputs[i])).stem().string();
    whole.paths[i] = (whole.joined->path() / fmt::format("{}-{}.t4d", i + 1, name)).string();
    const auto stage = observer.stage("joining");
    const auto joined = formats::joinT4d({inputs[i]}, whole.paths[i], stage->callback());
    if (!joined) return joined.error();
  }
  return whole;
}

Result<void> checkOpens(const std::vector<std::string>& paths,
                        const std::optional<std::uint64_t>& maxCells) {
  for (const std::string& path : paths) {
    const auto opened = openInput(path, {.maxCells = maxCells});
    if (!opened) return opened.error();
  }
  return {};
}

/// Fails if this must not become a folder with the files.
Result<void> checkFolder(const std::string& folder, std::span<const ShownFile> files) {
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) {
    return fail(ErrorCode::Options,
                fmt::format("{} is a file; name a page that ends in .html, or a folder", folder));
  }
  auto checked = checkSite(folder, files);
  if (!checked) checked.error().code = ErrorCode::Options;
  return checked;
}

/// The report of `track`.
Result<std::string> tracksOf(const ViewOptions& options) {
  if (options.tracks.empty()) return std::string();
  if (options.inputs.size() > 1) {
    return fail(ErrorCode::Options, "tracks are those of one file; show it alone");
  }
  const auto file = formats::readInputFile(options.tracks);
  if (!file) return file.error();
  if (auto sound = formats::checkJson(file->bytes, options.tracks); !sound) return sound.error();
  const auto report = nlohmann::ordered_json::parse(file->bytes, nullptr, false);
  const auto hasList = [&](const char* name) {
    return report.is_object() && report.contains(name) && report[name].is_array();
  };
  if (!hasList("tracks") || !hasList("events")) {
    return invalid("no report of `t4d track --json`", options.tracks);
  }
  if (report.contains("part")) {
    return invalid("is the report of a part; `t4d join` the parts first", options.tracks);
  }
  return report.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

Result<void> checkPageSize(const std::string& page, std::span<const ShownFile> files) {
  std::uint64_t total = 0;
  for (const ShownFile& file : files) {
    std::error_code ignored;
    if (file.url.empty()) total += fs::file_size(file.path, ignored);
  }
  if (total <= kMostInPage) return {};
  return fail(ErrorCode::Options,
              fmt::format("{} are too much for one page, which holds {} at most; name a folder "
                          "instead of {}",
                          model::sizeText(total), model::sizeText(kMostInPage), page));
}

Result<std::uint64_t> writePage(const ViewOptions& options, const ViewedFiles& viewed) {
  if (auto good = checkPageSize(options.output, viewed.files); !good) return good.error();
  const auto page = pageWithFiles(options.viewer, viewed.files, viewed.tracks);
  if (!page) return page.error();
  auto out = formats::OutputFile::create(options.output);
  if (!out) return out.error();
  if (auto done = out->finish(*page); !done) return done.error();
  return page->size();
}

}  // namespace

Result<ViewedFiles> viewedFiles(const ViewOptions& options, Observer& observer) {
  auto whole = wholeFiles(options.inputs, observer);
  if (!whole) return whole.error();
  std::vector<ShownFile> files = shownFiles(whole->paths);
  if (!options.output.empty() && !isOnePage(options.output)) {
    if (auto good = checkFolder(options.output, files); !good) return good.error();
  }
  if (auto good = checkOpens(whole->paths, options.maxCells); !good) return good.error();
  auto tracks = tracksOf(options);
  if (!tracks) return tracks.error();
  return ViewedFiles{std::move(files), std::move(*tracks), std::move(whole->joined)};
}

std::vector<std::string> ViewedFiles::names() const {
  std::vector<std::string> names;
  for (const ShownFile& file : files) names.push_back(file.name);
  return names;
}

bool isOnePage(const std::string& output) {
  const std::string extension = formats::lowerCaseExtension(output);
  return output == "-" || extension == ".html" || extension == ".htm";
}

Result<ViewReport> view(const ViewOptions& options, Observer& observer) {
  if (options.output.empty()) return fail(ErrorCode::Options, "no output is given");
  const platform::KeptInputs kept;
  const auto viewed = viewedFiles(options, observer);
  if (!viewed) return viewed.error();
  const auto bytes = isOnePage(options.output)
                         ? writePage(options, *viewed)
                         : writeSite(options.viewer, options.output, viewed->files, viewed->tracks);
  if (!bytes) return bytes.error();
  return ViewReport{.files = viewed->names(), .output = options.output, .bytes = *bytes};
}

void describe(Members& members, const ViewReport& report) {
  const auto orNone = [](const std::string& text) {
    return text.empty() ? std::nullopt : std::optional(text);
  };
  members("url", orNone(report.url), "Address of the served page; null if the page was written.");
  members("files", report.files, "Names of the files on the page.");
  members("output", orNone(report.output),
          "Page or folder that was written; null if the page is served.");
  members("bytes", report.bytes, "Bytes written; null if the page is served.");
}

}  // namespace t4d::verbs
