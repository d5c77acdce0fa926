#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "platform/kept_inputs.h"
#include "platform/process.h"
#include "platform/signals.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/help_json.h"
#include "tools/t4d/python_inputs.h"
#include "tools/t4d/shell_word.h"
#include "tools/t4d/similar_words.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

/// The last verb recognised in the arguments.
const CLI::App& lastCommand(const CLI::App& app) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  return chosen.empty() ? app : lastCommand(*chosen.front());
}

/// Help that says `FILE [FILE]` of an argument that is given once or twice.
class HelpFormat : public CLI::Formatter {
 public:
  std::string make_option_usage(const CLI::Option* option) const override {
    if (option->get_expected_max() != 2) return CLI::Formatter::make_option_usage(option);
    return fmt::format("{0} [{0}]", make_option_name(option, true));
  }
};

/// Which option was meant by an unknown one; "" if none is similar.
std::string guessOf(const std::string& word, const CLI::App& command) {
  if (!word.starts_with("--")) return {};
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return didYouMean(std::string_view(word).substr(0, word.find('=')), names);
}

/// If these words weave what the program does not read, says which command does; its exit code.
std::optional<int> leftToPython(std::span<const std::string> words) {
  const auto asksForHelp = [](const std::string& word) { return word == "-h" || word == "--help"; };
  if (words.empty() || words.front() != "weave" || std::ranges::any_of(words, asksForHelp)) {
    return std::nullopt;
  }
  const auto found = firstPythonInput(words.subspan(1));
  if (!found) return std::nullopt;
  std::string command = kPythonWeave;
  for (const std::string& word : words.subspan(1)) command += " " + shellWord(word);
  say(fmt::format("{}: is {}, which Python's libraries read", found->file, found->kind));
  sayHint("try: " + command);
  return kInvalid;
}

int run(int argc, char** argv) {
  CLI::App app(
      "t4d: 4D meshes, the boundary of a moving solid in space-time (x, y, z, t).\n"
      "Sweep a solid along a motion, save the result as .t4d, slice it, animate it, check it.");
  app.name("t4d");
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormat>());
  app.get_formatter()->column_width(34);
  app.set_version_flag("--version", std::string(versionText()));
  app.footer(
      "Example:\n"
      "  t4d sweep bolt.obj --motion screw-in.json -o bolt.t4d\n"
      "  t4d slice bolt.t4d --time 2.5 -o bolt-at-2.5.glb\n\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 done with loss, 4 the input is invalid.\n"
      "`t4d VERB --help` prints the options of a verb; with --json, as JSON.");
  int exitCode = kDone;
  addVerbs(app, exitCode);
  // CLI11 takes the words from the last to the first.
  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  if (const auto code = leftToPython(words)) return *code;
  const bool asksForJson = std::ranges::find(words, "--json") != words.end();
  std::reverse(words.begin(), words.end());
  try {
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    if (asksForJson && error.get_name() == "CallForHelp") {
      printJson(helpJson(lastCommand(app)));
      return kDone;
    }
    if (error.get_exit_code() != 0) {
      const std::vector<std::string> unknown = app.remaining(true);
      const CLI::App& last = lastCommand(app);
      const bool isVerb = unknown.empty() || !unknown.front().starts_with('-');
      if (last.get_require_subcommand_min() > 0 && isVerb) {
        return wrongUsage(wrongVerb(last, unknown.empty() ? std::string() : unknown.front()));
      }
      // If something else is missing, CLI11 reports only that.
      const bool told = error.get_name() == "ExtrasError";
      for (const std::string& word : unknown) {
        const std::string guess = guessOf(word, last);
        if (!told || !guess.empty()) say("not understood: " + word + guess);
      }
    }
    std::ostringstream help;
    std::ostringstream wrong;
    const int code = app.exit(error, help, wrong);
    printResult(help.str());
    sayAsIs(wrong.str());
    return code == 0 ? kDone : kUsage;
  }
  return exitCode;
}

/// The files among the arguments, for an error that cannot say which it is about.
std::string filesAmong(int argc, char** argv) {
  std::string files;
  for (int i = 1; i < argc; ++i) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(argv[i], ignored)) continue;
    files += files.empty() ? argv[i] : std::string(", ") + argv[i];
  }
  return files;
}

/// A run whose results did not reach standard output has failed, unless whoever reads them has
/// closed the pipe, as `head` does once it has read enough.
int exitCodeOf(int exitCode) {
  const int reason = printError();
  if (reason == EPIPE || (reason == 0 && std::ferror(stdout) == 0)) return exitCode;
  say(reason == 0 ? "cannot write to standard output"
                  : fmt::format("cannot write to standard output: {}", std::strerror(reason)));
  return exitCode == kDone || exitCode == kLoss ? kFailed : exitCode;
}

}  // namespace
}  // namespace t4d::tools

int main(int argc, char** argv) {
  using namespace t4d::tools;
  t4d::platform::keepStandardStreams();
  t4d::platform::cleanUpOnSignals();
  t4d::formats::readUrls();
  const t4d::platform::KeptInputs kept;
  int exitCode = kFailed;
  try {
    exitCode = run(argc, argv);
  } catch (const std::bad_alloc&) {
    const std::string files = filesAmong(argc, argv);
    say(files.empty() ? "out of memory" : "out of memory, working on " + files);
  } catch (const std::exception& error) {
    say(error.what());
  }
  return exitCodeOf(exitCode);
}
