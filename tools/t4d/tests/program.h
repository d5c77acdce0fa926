#pragma once

#include <cstdio>
#include <fstream>
#include <string>

#include "tools/t4d/tests/test_folder.h"

namespace t4d::tools {

/// The program from the user's point of view: its output, its files, its exit codes. Each test has
/// all fixtures in the folder fx.
class Program : public InFolder {
 protected:
  void SetUp() override {
    InFolder::SetUp();
    copyFixtures(folder_ / "fx");
  }

  /// Invalid input: exit 4, an error that names what and where, and no output file.
  void refuses(const std::string& arguments, const std::string& expected, int exitCode = 4) const {
    SCOPED_TRACE(arguments);
    const Finished done = run(arguments);
    EXPECT_EQ(done.exitCode, exitCode) << done.err;
    EXPECT_NE(done.err.find(expected), std::string::npos) << done.err;
    EXPECT_FALSE(fs::exists(folder_ / "out.t4d"));
    EXPECT_FALSE(fs::exists(folder_ / "out.glb"));
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
    }
  }

  /// Wrong usage: exit 2, and the option is named.
  void misused(const std::string& arguments, const std::string& expected) const {
    refuses(arguments, expected, 2);
  }

  /// An output that cannot be written: exit 1.
  void cannot(const std::string& arguments, const std::string& expected) const {
    refuses(arguments, expected, 1);
  }

  /// Writes fx/NAME.obj with every vertex times `scale` plus `offset`, as NAME-placed.obj.
  void placeFixture(const std::string& name, double scale, double offset) const {
    std::ifstream in(folder_ / "fx" / (name + ".obj"));
    std::ofstream out(folder_ / (name + "-placed.obj"));
    out.precision(17);
    for (std::string line; std::getline(in, line);) {
      double x = 0;
      double y = 0;
      double z = 0;
      if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3) {
        out << "v " << x * scale + offset << " " << y * scale + offset << " " << z * scale + offset
            << "\n";
      } else {
        out << line << "\n";
      }
    }
  }
};

/// Makes cube.t4d, the cube of the paper, of side 20, which moves by 64 along z from time 0 to 64.
inline constexpr const char* kPaper =
    "sweep fx/paper-cube.obj -m fx/paper-translation.json -o cube.t4d";

}  // namespace t4d::tools
