#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "conformance/answers.h"

/// Our reader as a program for the conformance suite (SPEC.md, appendix "a reader under test").
namespace t4d::conformance {
namespace {

std::optional<double> numberOf(std::string_view text) {
  double number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || !std::isfinite(number)) {
    return std::nullopt;
  }
  return number;
}

/// "x", "y", "z" or four numbers with commas between them.
std::optional<Eigen::Vector4d> normalOf(std::string_view text) {
  constexpr std::string_view kAxes = "xyz";
  if (text.size() == 1 && kAxes.find(text) != std::string_view::npos) {
    return Eigen::Vector4d::Unit(static_cast<int>(kAxes.find(text)));
  }
  Eigen::Vector4d normal;
  for (int axis = 0; axis < 4; ++axis) {
    const std::size_t comma = text.find(',');
    const auto number = numberOf(text.substr(0, comma));
    if (!number || (comma == std::string_view::npos) != (axis == 3)) return std::nullopt;
    normal[axis] = *number;
    if (axis < 3) text.remove_prefix(comma + 1);
  }
  return normal;
}

using Request = std::function<Result<Answer>(const std::string& path)>;

/// Empty if the words are no request: {"describe"}, {"slice", T}, {"slice", AXIS or NORMAL, C}.
Request requestOf(const std::vector<std::string>& words) {
  if (words == std::vector<std::string>{"describe"}) {
    return [](const std::string& path) { return describeFile(path); };
  }
  if (words.size() < 2 || words[0] != "slice") return {};
  const auto number = numberOf(words.back());
  if (!number) return {};
  if (words.size() == 2) {
    return [time = *number](const std::string& path) { return sliceFile(path, time); };
  }
  const auto normal = normalOf(words[1]);
  if (words.size() != 3 || !normal || normal->isZero(0)) return {};
  return [plane = slice::Hyperplane{*normal, *number}](const std::string& path) {
    return sliceFile(path, plane);
  };
}

int usage() {
  std::fputs(
      "Usage: t4d-reader FILE describe\n       t4d-reader FILE slice T\n"
      "       t4d-reader FILE slice x|y|z C\n       t4d-reader FILE slice A,B,C,D E\n"
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

/// Answers requests line by line: "describe FILE", "slice T FILE", "slice x C FILE".
int serve() {
  for (std::string line; std::getline(std::cin, line);) {
    std::vector<std::string> words = {nextWord(line)};
    if (words[0] == "slice") {
      words.push_back(nextWord(line));
      if (!numberOf(words[1])) words.push_back(nextWord(line));
    }
    const Request request = requestOf(words);
    if (!request) return usage();
    const Result<Answer> answer = request(line);
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
  if (argc == 2 && std::string_view(argv[1]) == "--serve") return serve();
  if (argc < 3) return usage();
  const Request request = requestOf(std::vector<std::string>(argv + 2, argv + argc));
  if (!request) return usage();
  const Result<Answer> answer = request(argv[1]);
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
