// Slices a file on four threads. A source may be read from any number of threads at once.
#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

#include <t4d/file.h>
#include <t4d/slice.h>

int main() {
  using namespace t4d;
  const auto reader = formats::T4dReader::open("paper-cube.t4d");
  if (!reader) return 4;
  const model::Source& mesh = reader->body(0);
  std::vector<double> volumes(mesh.slabCount());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < volumes.size(); i = next++) {
      const auto [begin, end] = mesh.timeSpan(i);
      const auto slice = slice::sliceAtTime(mesh, (begin + end) / 2);
      volumes[i] = slice ? signedVolume(slice->mesh) : -1;
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  threads.clear();  // waits for them
  for (std::size_t i = 0; i < volumes.size(); ++i) std::printf("slab %zu %.9g\n", i, volumes[i]);
}
