// Slices a file at a hundred times and prints the volume of the solid at each.
#include <cstdio>
#include <vector>

#include <t4d/file.h>
#include <t4d/slice.h>

int main() {
  using namespace t4d;
  const auto reader = formats::T4dReader::open("paper-cube.t4d");
  if (!reader) return 4;
  const model::Source& mesh = reader->body(0);
  const model::TimeSpan span = timeSpanOf(mesh);
  std::vector<double> times;
  for (int i = 0; i < 100; ++i) times.push_back(span.begin + i * (span.end - span.begin) / 99);
  // One pass over the slabs, however many times there are. Each time has its own result.
  const auto slices = slice::sliceAtTimes(mesh, times);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!slices[i]) {
      std::fprintf(stderr, "%s\n", slices[i].error().text().c_str());
      return 1;
    }
    std::printf("%g %.9g\n", times[i], signedVolume(slices[i]->mesh));
  }
}
