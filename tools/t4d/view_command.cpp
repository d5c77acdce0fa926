#include <cstdio>
#include <cstdlib>

#include "platform/child_process.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/verbs/view.h"
#include "tools/viewer/page_text.h"
#include "tools/viewer/viewer_server.h"

namespace t4d::tools {
namespace {

struct ViewArguments {
  verbs::ViewOptions view;
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
  const auto viewed = verbs::viewedFiles(options.view, observer);
  if (!viewed) return report(viewed.error());
  const auto page = verbs::viewerPage(options.view.viewer, viewed->files, viewed->tracks);
  if (!page) return report(page.error());
  std::vector<ServedFile> files;
  for (const verbs::ShownFile& file : viewed->files) {
    if (file.url.empty()) files.push_back({file.name, file.path});
  }
  const auto served = serveViewer(*page, files, options.port, [&](const std::string& url) {
    if (options.json) {
      printAsJson(verbs::ViewReport{.url = url, .files = viewed->names()});
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
  const auto done = verbs::view(options.view, observer);
  if (!done) return report(done.error());
  if (options.json) {
    printAsJson(*done);
    return kDone;
  }
  print("{}: {}{}\n", done->output, sizeText(*done->bytes),
        verbs::isOnePage(done->output) ? "; open it in a browser"
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
  addJsonOption<verbs::ViewReport>(*command, options->json,
                                   "The page that is served or was written.");
  command->footer("Example:\n  t4d view bolt.t4d\n  t4d view bolt.t4d -o bolt.html");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
