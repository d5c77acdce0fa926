#include <cstdio>

#include <tools/verbs/envelope.h>
#include <tools/verbs/sweep.h>
#include <tools/verbs/validate.h>

/// The verbs of the program, as functions: sweep a solid, check the file, and ask what it passes
/// through.
int main() {
  using namespace t4d;
  verbs::SweepOptions sweep;
  sweep.what = verbs::MotionSweep{"paper-cube.obj", "paper-translation.json"};
  sweep.output.path = "moving.t4d";
  const auto swept = verbs::sweep(sweep);
  if (!swept) {
    std::fprintf(stderr, "%s\n", swept.error().text().c_str());
    return 1;
  }
  const auto found = verbs::validate(sweep.output.path);
  const auto mesh = verbs::openInput(sweep.output.path);
  if (!found || !mesh) return 4;
  verbs::EnvelopeOptions exactly;
  exactly.exact = true;
  const auto made = verbs::envelope(*mesh, exactly);
  if (!made) return 1;
  std::printf("%llu steps, %s, passes through a volume of %.0f\n",
              static_cast<unsigned long long>(swept->steps), found->valid() ? "valid" : "invalid",
              made->passages.all.front().envelope.volume);
  return 0;
}
