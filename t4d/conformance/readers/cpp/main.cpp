#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "t4d/conformance/answers.h"

/// Our reader as a program for the conformance suite: `t4d-reader FILE describe`,
/// `t4d-reader FILE slice T` and `t4d-reader --serve`.
namespace t4d::conformance {
namespace {

std::optional<double> timeOf(std::string_view text) {
  double time = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), time);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return time;
}

int usage() {
  std::fputs(
      "Usage: t4d-reader FILE describe\n       t4d-reader FILE slice T\n"
      "       t4d-reader --serve\n",
      stderr);
  return 2;
}

/// Removes the first word and the space after it, and returns the word.
std::string nextWord(std::string& text) {
  const std::size_t space = text.find(' ');
  std::string word = text.substr(0, space);
  text.erase(0, space == std::string::npos ? space : space + 1);
  return word;
}

/// Answers requests line by line: "describe FILE", "slice T FILE".
int serve() {
  for (std::string line; std::getline(std::cin, line);) {
    const std::string verb = nextWord(line);
    Result<Answer> answer;
    if (verb == "describe") {
      answer = describeFile(line);
    } else {
      const auto time = timeOf(nextWord(line));
      if (verb != "slice" || !time) return usage();
      answer = sliceFile(line, *time);
    }
    if (answer) {
      std::cout << "accept " << nlohmann::ordered_json::parse(answer->json).dump() << std::endl;
    } else {
      std::string why = answer.error().text();
      std::replace(why.begin(), why.end(), '\n', ' ');
      std::cout << "refuse " << why << std::endl;
    }
  }
  return 0;
}

int run(int argc, char** argv) {
  const std::string_view request = argc > 2 ? argv[2] : "";
  Result<Answer> answer;
  if (argc == 2 && std::string_view(argv[1]) == "--serve") return serve();
  if (argc == 3 && request == "describe") {
    answer = describeFile(argv[1]);
  } else if (argc == 4 && request == "slice" && timeOf(argv[3])) {
    answer = sliceFile(argv[1], *timeOf(argv[3]));
  } else {
    return usage();
  }
  if (!answer) {
    std::fprintf(stderr, "t4d-reader: %s\n", answer.error().text().c_str());
    return 1;
  }
  std::puts(answer->json.c_str());
  return 0;
}

}  // namespace
}  // namespace t4d::conformance

int main(int argc, char** argv) try {
  return t4d::conformance::run(argc, argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "t4d-reader: %s\n", error.what());
  return 3;
}
