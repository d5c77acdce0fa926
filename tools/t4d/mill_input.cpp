#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "edit/surface_crossings.h"
#include "formats/motion/basic_solids.h"
#include "formats/toolpath/cutter_location_reader.h"
#include "formats/toolpath/gcode_reader.h"
#include "model/amount_text.h"
#include "platform/stopwatch.h"
#include "t4d/motion.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/mill.h"
#include "tools/t4d/wall.h"

namespace t4d::tools {
namespace {

/// A notice if the surface crosses itself; nothing if it does not, or where nobody can tell.
void noteCrossings(const std::string& path, const model::TriangleMesh& mesh, Observer& observer) {
  constexpr std::size_t kMost = 1000;
  const auto found = [&] {
    const auto stage = observer.stage("checking " + path);
    return edit::findCrossings(mesh, kMost);
  }();
  if (!found || found->pairs.empty()) return;
  observer.note(fmt::format(
      "{} crosses itself, in {}{}; where it overlaps itself it counts once, and where it is inside "
      "out it is empty",
      path, found->complete ? "" : "more than ",
      model::counted(found->pairs.size(), "pair of triangles", "pairs of triangles")));
}

/// Of "box:100,60,20": the middle of its top is the origin; or of "box:100,60,20@0,0,-20", whose
/// lowest corner is there.
Result<LoadedSolid> boxStock(std::string_view text) {
  const auto wrong = [&] {
    return fail(ErrorCode::Options,
                fmt::format("'{}' is no stock; expected box:LENGTH,WIDTH,HEIGHT, as in "
                            "box:100,60,20, or with its lowest corner, box:100,60,20@0,0,-20",
                            text));
  };
  constexpr std::string_view kBox = "box:";
  if (!text.starts_with(kBox)) return wrong();
  const std::string_view sizes = text.substr(kBox.size());
  const auto at = std::min(sizes.find('@'), sizes.size());
  const auto size = formats::parsePoint(sizes.substr(0, at));
  if (!size || !(size->minCoeff() > 0)) return wrong();
  model::Point3 middle(0, 0, -size->z() / 2);
  if (at < sizes.size()) {
    const auto corner = formats::parsePoint(sizes.substr(at + 1));
    if (!corner) return wrong();
    middle = *corner + *size / 2;
  }
  LoadedSolid stock;
  stock.bodies.push_back({.name = "stock", .mesh = formats::boxMesh(*size)});
  for (model::Point3& vertex : stock.bodies.front().mesh.vertices) vertex += middle;
  return stock;
}

/// The stock, in which voxels of this size find room.
Result<model::TriangleMesh> readStock(const MillFiles& files, const MillOptions& options,
                                      std::vector<std::string>& losses, Observer& observer) {
  auto stock = files.box.empty() ? readSolidInput(files.stock, observer) : boxStock(files.box);
  if (!stock) return stock.error();
  observer.noteEach(noticesOf(stock->mended));
  losses.insert(losses.end(), stock->losses.begin(), stock->losses.end());
  model::TriangleMesh& mesh = stock->bodies.front().mesh;
  noteCrossings(files.stock.path, mesh, observer);
  // Each ray is a two thousandth of the surface.
  if (const double thin = thinWalls(mesh, options.voxelSize); thin > 0) {
    losses.push_back(fmt::format(
        "{}: walls thinner than a voxel ({:g}), behind {:.2g} % of the surface, may be lost",
        files.stock.path, options.voxelSize, 100 * thin));
  }
  if (auto sized = mill::checkVoxelSize(mesh, options.voxelSize, options.memory); !sized) {
    Error error = sized.error();
    if (error.where.empty() || error.where == "stock") error.where = files.stock.path;
    return error;
  }
  return std::move(mesh);
}

/// What G-code and cutter locations are read with: the tools, the lengths that the table has, and
/// how far the longest one reaches.
formats::ToolPathOptions programOptions(const MillFiles& files, const MillOptions& options,
                                        const model::TriangleMesh& stock,
                                        const std::vector<mill::Tool>& tools) {
  formats::ToolPathOptions how = files.program;
  how.tolerance = options.toleranceOr();
  if (tools.front().number != 0) how.tools.emplace();
  how.reach = 0;
  const auto reach = [&](const model::TriangleMesh& mesh) {
    for (const auto& vertex : mesh.vertices) how.reach = std::max(how.reach, vertex.norm());
  };
  for (const mill::Tool& tool : tools) {
    if (how.tools) how.tools->push_back(tool.number);
    reach(tool.mesh);
    double radius = 0;
    for (const auto& vertex : tool.mesh.vertices) {
      radius = std::max(radius, std::hypot(vertex.x(), vertex.y()));
    }
    how.diameters.emplace(tool.number, 2 * radius);
    for (const mill::Guard& guard : tool.guards) reach(guard.mesh);
  }
  for (const auto& [number, tool] : files.toolTable) how.lengths.emplace(number, tool.length);
  const model::Bounds3 bounds = model::boundsOf(stock);
  how.assumedStart = 0.5 * (bounds.min + bounds.max);
  how.assumedStart.z() = bounds.max.z();
  return how;
}

/// A motion as a path of one tool, with notices.
Result<formats::ToolPath> readMotionPath(const MillFiles& files) {
  formats::ToolPath path;
  std::string form;
  auto motion = formats::readMotion(files.path, &form, files.table);
  if (!motion) return motion.error();
  if (!form.empty()) path.notices.push_back(files.path + ": " + form);
  if (const std::string notice = model::noticeOfHalfTurns(motion->halfTurns); !notice.empty()) {
    path.notices.push_back(files.path + ": " + notice);
  }
  path.motion = std::move(*motion);
  return path;
}

Result<formats::ToolPath> readToolPath(const MillFiles& files,
                                       const formats::ToolPathOptions& how) {
  if (files.kind == ToolPathKind::Gcode) return formats::readGcode(files.path, how);
  if (files.kind == ToolPathKind::Locations) return formats::readCutterLocations(files.path, how);
  return readMotionPath(files);
}

}  // namespace

Result<MillInput> readMilling(const MillFiles& files, const MillOptions& options,
                              Observer& observer) {
  const platform::Stopwatch stopwatch;
  if (files.tools.empty()) return fail(ErrorCode::Options, "no tool is given");
  if (files.kind == ToolPathKind::Motion && !files.tools.contains(0)) {
    return fail(ErrorCode::Options,
                "tools with numbers are mounted by G-code or cutter locations, not by a motion");
  }
  MillInput input{.files = files, .stock = {}, .tools = {}, .path = {}};
  auto stock = readStock(files, options, input.losses, observer);
  if (!stock) return stock.error();
  auto tools = readMillTools(files.tools, options.toleranceOr(), input.losses, observer);
  if (!tools) return tools.error();
  auto path = readToolPath(files, programOptions(files, options, *stock, *tools));
  if (!path) return path.error();
  observer.noteEach(path->notices);
  input.stock = std::move(*stock);
  input.tools = std::move(*tools);
  input.path = std::move(*path);
  input.seconds = stopwatch.seconds();
  return input;
}

}  // namespace t4d::tools
