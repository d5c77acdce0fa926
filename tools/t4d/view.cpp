#include "tools/t4d/view.h"

#include <cstdio>
#include <cstdlib>
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
#include "platform/child_process.h"
#include "platform/kept_inputs.h"
#include "platform/temporary_folder.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/viewer/page_text.h"
#include "tools/viewer/viewer_server.h"

namespace t4d::tools {
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

namespace {

struct ViewArguments {
  ViewOptions view;
  int port = 0;
  bool noOpen = false;
  bool json = false;
};

/// Opens the page in the browser of the desktop, where there is one.
void openBrowser(const std::string& url) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  // It stays when this program is stopped.
  platform::startDetached({"xdg-open", url});
}

int serve(const ViewArguments& options) {
  ConsoleObserver observer;
  const auto viewed = viewedFiles(options.view, observer);
  if (!viewed) return report(viewed.error());
  const auto page = viewerPage(options.view.viewer, viewed->files, viewed->tracks);
  if (!page) return report(page.error());
  std::vector<ServedFile> files;
  for (const ShownFile& file : viewed->files) {
    if (file.url.empty()) files.push_back({file.name, file.path});
  }
  const auto served = serveViewer(*page, files, options.port, [&](const std::string& url) {
    if (options.json) {
      printAsJson(ViewReport{.url = url, .files = viewed->names()});
    } else {
      print("{}\n", url);
      say("serving until Ctrl-C");
    }
    // Whoever started this waits for it.
    std::fflush(stdout);
    if (!options.noOpen) openBrowser(url);
  });
  if (!served) return report(served.error());
  return kDone;
}

int write(const ViewArguments& options) {
  ConsoleObserver observer;
  const auto done = view(options.view, observer);
  if (!done) return report(done.error());
  if (options.json) {
    printAsJson(*done);
    return kDone;
  }
  print("{}: {}{}\n", done->output, sizeText(*done->bytes),
        isOnePage(done->output) ? "; open it in a browser"
                                : "; put the folder on any web server with ranges");
  return kDone;
}

int run(ViewArguments& options) {
  options.view.viewer = pageText();
  if (!options.view.output.empty()) return write(options);
  if (!canServe()) {
    return wrongUsage(
        "this t4d was built without the server (cpp-httplib); write the page with -o, or build "
        "with -DT4D_WITH_HTTPLIB=ON");
  }
  return serve(options);
}

}  // namespace

void addView(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("view", "Show a 4D mesh in a browser");
  auto options = std::make_shared<ViewArguments>();
  command
      ->add_option("FILE", options->view.inputs,
                   "Input file (.t4d, .t4dm), or two to show side by side: paths or URLs")
      ->required()
      ->expected(1, 2);
  command
      ->add_option("--tracks", options->view.tracks,
                   "Colour components and list events of this report of t4d track --json")
      ->check(someName());
  command
      ->add_option("--port", options->port,
                   "Port on this machine to serve at (default: a free one)")
      ->check(wholeNumber(1, 65535));
  command->add_flag("--no-open", options->noOpen, "Do not open a browser");
  command
      ->add_option("-o,--output", options->view.output,
                   "Write a folder, or one .html page, instead of serving; - for standard output")
      ->check(someName());
  addMaxCellsOption(*command, options->view.maxCells);
  addJsonOption<ViewReport>(*command, options->json, "The page that is served or was written.");
  command->footer("Example:\n  t4d view bolt.t4d\n  t4d view bolt.t4d -o bolt.html");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
