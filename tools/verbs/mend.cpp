#include "tools/verbs/mend.h"

#include <utility>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/gltf/gltf_writer.h"
#include "model/amount_text.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "t4d/surface.h"
#include "tools/verbs/members.h"
#include "tools/verbs/mending.h"
#include "tools/verbs/solid_input.h"

namespace t4d::verbs {

Result<MendReport> mend(const MendOptions& options, Observer& observer) {
  const platform::KeptInputs kept;
  const platform::Stopwatch stopwatch;
  auto loaded = readSolidInput({options.input, options.bodies, options.limits, /*attributes=*/true},
                               observer);
  if (!loaded) return loaded.error();
  MendReport report;
  report.mended = std::move(loaded->mended);
  for (formats::NamedMesh& body : loaded->bodies) {
    body.ownCorners = true;
    report.vertices += body.mesh.vertices.size();
    report.triangles += body.mesh.triangles.size();
  }
  report.losses = std::move(loaded->losses);
  const auto lost = [&] {
    const auto stage = observer.stage("writing " + options.output);
    return formats::writeTriangleMeshes(options.output, loaded->bodies,
                                        {.attributes = true, .materials = loaded->materials});
  }();
  if (!lost) return lost.error();
  report.losses.insert(report.losses.end(), lost->begin(), lost->end());
  const std::string extension = formats::lowerCaseExtension(options.output);
  if (loaded->materials.size() > 1 && !formats::isGltf(options.output) && extension != ".obj") {
    const std::string count = model::counted(loaded->materials.size() - 1, "material");
    report.losses.push_back(fmt::format("the names of {}: {} has none", count, extension));
  }
  report.seconds = stopwatch.seconds();
  return report;
}

void describe(Members& members, const MendReport& report) {
  addMending(members, report.mended);
  members("vertices", report.vertices, "Vertices written.").atLeast(4);
  members("triangles", report.triangles, "Triangles written.").atLeast(4);
  addCosts(members, report.seconds);
}

}  // namespace t4d::verbs
