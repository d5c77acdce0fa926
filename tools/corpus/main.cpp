#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "conformance/corpus/corpus.h"

/// Writes the file corpus, or says how a folder differs from it.
int main(int argc, char** argv) try {
  using namespace t4d::conformance;
  CLI::App app{"The corpus of .t4d files"};
  app.require_subcommand(1);
  CLI::App* generate = app.add_subcommand("generate", "Write the corpus");
  std::string directory;
  bool verify = false;
  generate->add_option("DIR", directory, "Where to")->required();
  generate->add_flag("--verify", verify,
                     "Write nothing; say what is different in DIR, exit with 1");
  CLI11_PARSE(app, argc, argv);
  if (!verify) {
    const auto written = writeCorpus(directory);
    if (!written) std::fprintf(stderr, "t4d-corpus: %s\n", written.error().text().c_str());
    return written ? 0 : 1;
  }
  const auto differences = verifyCorpus(directory);
  if (!differences) {
    std::fprintf(stderr, "t4d-corpus: %s\n", differences.error().text().c_str());
    return 1;
  }
  for (const std::string& difference : *differences) std::puts(difference.c_str());
  return differences->empty() ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "t4d-corpus: %s\n", error.what());
  return 1;
}
