#include <cstdio>
#include <cstdlib>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <unistd.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/join.h"
#include "t4d/formats/t4d/manifest.h"
#include "t4d/formats/t4d/url.h"
#include "t4d/system/temporary_folder.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/viewer/viewer_page.h"
#include "tools/viewer/viewer_server.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// Browsers take pages of this size; a folder has no limit.
constexpr std::uint64_t kMostInPage = std::uint64_t{64} << 20;

struct ViewArguments {
  std::vector<std::string> inputs;
  std::optional<std::uint64_t> maxCells;
  int port = 0;
  bool noOpen = false;
  std::string output;
  bool json = false;
};

/// Opens the page in the browser of the desktop, where there is one.
void openBrowser(const std::string& url) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // It stays when this program is stopped.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string program = "xdg-open";
  std::string argument = url;
  char* const words[] = {program.data(), argument.data(), nullptr};
  pid_t pid = 0;
  posix_spawnp(&pid, program.c_str(), &files, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
}

ordered_json namesOf(std::span<const ShownFile> files) {
  ordered_json names = ordered_json::array();
  for (const ShownFile& file : files) names.push_back(file.name);
  return names;
}

int serve(const ViewArguments& options, std::span<const ShownFile> files) {
  const auto served = serveViewer(files, options.port, [&](const std::string& url) {
    if (options.json) {
      printJson({{"url", url}, {"files", namesOf(files)}, {"output", nullptr}, {"bytes", nullptr}});
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

/// Whether one page is to be written, and not a folder.
bool isPage(const std::string& output) {
  const std::string extension = formats::lowerCaseExtension(output);
  return output == "-" || extension == ".html" || extension == ".htm";
}

/// The error message if this must not become a folder with the files.
std::optional<std::string> misuseOfFolder(const std::string& folder,
                                          std::span<const ShownFile> files) {
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) {
    return fmt::format("{} is a file; name a page that ends in .html, or a folder", folder);
  }
  const auto checked = checkSite(folder, files);
  return checked ? std::nullopt : std::optional(checked.error().text());
}

/// The inputs as the viewer reads them: a file in parts is joined, into `folder`, which is made for
/// it.
Result<std::vector<std::string>> joinedInputs(const std::vector<std::string>& inputs,
                                              std::optional<system::TemporaryFolder>& folder) {
  std::vector<std::string> whole = inputs;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (!formats::isManifest(inputs[i])) continue;
    if (!folder) {
      auto made = system::TemporaryFolder::create();
      if (!made) return made.error();
      folder.emplace(std::move(*made));
    }
    const std::string name = fs::path(formats::shownName(inputs[i])).stem().string();
    whole[i] = (folder->path() / fmt::format("{}-{}.t4d", i + 1, name)).string();
    ProgressBar bar("joining");
    const auto joined = formats::joinT4d({inputs[i]}, whole[i], bar.callback());
    if (!joined) return joined.error();
  }
  return whole;
}

Result<std::uint64_t> writePage(const std::string& path, std::span<const ShownFile> files) {
  const auto page = pageWithFiles(files);
  if (!page) return page.error();
  auto out = formats::OutputFile::create(path);
  if (!out) return out.error();
  if (auto put = out->write(page->data(), page->size()); !put) return put.error();
  if (auto done = out->commit(); !done) return done.error();
  return page->size();
}

int run(const ViewArguments& options) {
  if (!options.output.empty()) {
    if (const auto misuse = misuseOfOutput(options.output, options.inputs)) {
      return wrongUsage(*misuse);
    }
  } else if (!canServe()) {
    return wrongUsage(
        "this t4d was built without the server (cpp-httplib); write the page with -o, or build "
        "with -DT4D_WITH_HTTPLIB=ON");
  }
  std::optional<system::TemporaryFolder> folder;
  const auto inputs = joinedInputs(options.inputs, folder);
  if (!inputs) return report(inputs.error());
  const std::vector<ShownFile> files = shownFiles(*inputs);
  const bool writesPage = isPage(options.output);
  if (!options.output.empty() && !writesPage) {
    if (const auto misuse = misuseOfFolder(options.output, files)) return wrongUsage(*misuse);
  }
  for (const std::string& input : *inputs) {
    InputOptions all;
    all.maxCells = options.maxCells;
    const auto opened = verbs::openInput(input, all);
    if (!opened) return report(opened.error());
  }
  if (options.output.empty()) return serve(options, files);

  if (writesPage) {
    std::uint64_t total = 0;
    for (const ShownFile& file : files) {
      std::error_code ignored;
      if (file.url.empty()) total += fs::file_size(file.path, ignored);
    }
    if (total > kMostInPage) {
      return wrongUsage(fmt::format(
          "{} are too much for one page, which holds {} at most; name a folder instead of {}",
          sizeText(total), sizeText(kMostInPage), options.output));
    }
  }
  const auto bytes =
      writesPage ? writePage(options.output, files) : writeSite(options.output, files);
  if (!bytes) return report(bytes.error());
  if (options.json) {
    printJson({{"url", nullptr},
               {"files", namesOf(files)},
               {"output", options.output},
               {"bytes", *bytes}});
    return kDone;
  }
  print("{}: {}{}\n", options.output, sizeText(*bytes),
        writesPage ? "; open it in a browser" : "; put the folder on any web server with ranges");
  return kDone;
}

}  // namespace

void addView(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("view", "Show a 4D mesh in a browser");
  auto options = std::make_shared<ViewArguments>();
  command
      ->add_option("FILES", options->inputs,
                   "Input file (.t4d, .t4dm), or two to show side by side: paths or URLs")
      ->required()
      ->expected(1, 2);
  command
      ->add_option("--port", options->port,
                   "Port on this machine to serve at (default: a free one)")
      ->check(wholeNumber(1, 65535));
  command->add_flag("--no-open", options->noOpen, "Do not open a browser");
  command
      ->add_option("-o,--output", options->output,
                   "Write a folder, or one .html page, instead of serving; - for standard output")
      ->check(someName());
  addMaxCellsOption(*command, options->maxCells);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  t4d view bolt.t4d\n  t4d view bolt.t4d -o bolt.html");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
