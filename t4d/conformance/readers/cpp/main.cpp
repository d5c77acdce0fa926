#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>

#include <nlohmann/json.hpp>

#include "t4d/conformance/answers.h"

/// Our reader, as one under test: `t4d-reader FILE describe`, `t4d-reader FILE slice T`.
int main(int argc, char** argv) try {
  using namespace t4d;
  using namespace t4d::conformance;
  Result<Answer> answer;
  double time = 0;
  if (argc == 3 && std::strcmp(argv[2], "describe") == 0) {
    answer = describeFile(argv[1]);
  } else if (argc == 4 && std::strcmp(argv[2], "slice") == 0 &&
             std::from_chars(argv[3], argv[3] + std::strlen(argv[3]), time).ec == std::errc()) {
    answer = sliceFile(argv[1], time);
  } else {
    std::fputs("Usage: t4d-reader FILE describe\n       t4d-reader FILE slice T\n", stderr);
    return 2;
  }
  if (!answer) {
    std::fprintf(stderr, "t4d-reader: %s\n", answer.error().text().c_str());
    return 1;
  }
  std::puts(answer->json.c_str());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "t4d-reader: %s\n", error.what());
  return 3;
}
