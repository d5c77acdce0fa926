#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "platform/test_folder.h"
#include "tests/paths.h"

/// Shared by the tests of this folder, which run the program as its users do.
namespace t4d::tools {

namespace fs = std::filesystem;
using nlohmann::json;
using platform::contents;

/// The bytes of a file; none if it cannot be read.
/// Copies the generated inputs, those that t4d-fixtures writes, into a new folder.
inline void copyFixtures(const fs::path& folder) {
  fs::copy(T4D_FIXTURES, folder, fs::copy_options::recursive);
}

/// The end of the program, and its output.
struct Finished {
  int exitCode = -1;  ///< -signal if it was killed
  std::string out;
  std::string err;
  json value() const { return json::parse(out); }
};

/// A test with an empty folder of its own, in which the program runs.
class InFolder : public testing::Test {
 protected:
  /// The arguments are words of a shell, which expands patterns and redirects.
  Finished run(const std::string& arguments) const {
    const int exitCode =
        shell(std::string(T4D_PROGRAM) + " " + arguments + " > stdout.txt 2> stderr.txt");
    return {exitCode, contents(folder_ / "stdout.txt"), contents(folder_ / "stderr.txt")};
  }

  /// Runs a shell script in which "$t4d" is the program. Returns the exit code, or -signal if
  /// killed.
  int shell(const std::string& script) const {
    const std::string command =
        "cd " + folder_.path().string() + " && t4d=" T4D_PROGRAM " && " + script;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  fs::path write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }

  /// Writes a program for /bin/sh. Returns the command that runs it.
  std::string writeScript(const std::string& name, const std::string& script) const {
    fs::permissions(write(name, "#!/bin/sh\n" + script + "\n"), fs::perms::owner_all);
    return "./" + name;
  }

  platform::TestFolder folder_;
};

}  // namespace t4d::tools
