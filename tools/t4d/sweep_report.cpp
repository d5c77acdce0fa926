#include <algorithm>
#include <array>

#include "tools/t4d/members.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/sweep.h"

namespace t4d::tools {
namespace {

std::array<double, 2> pairOf(const model::TimeSpan& span) { return {span.begin, span.end}; }

constexpr const char* kMeshesOf =
    "Of an animated glTF: its nodes with a mesh. Of a mechanism: its bodies with a solid. With "
    "--bodies: the objects or groups of the .obj.";

void describeSweptBody(Members& members, const SweptBody& body) {
  members("name", body.name, "Name of the body, after the node, object or group.");
  members("vertices", body.vertices, "Vertices of the body.").atLeast(5);
  members("tetrahedra", body.tetrahedra, "Cells of the body, caps included.").atLeast(5);
  members("steps", body.steps, "Steps of the body.").atLeast(1);
  members(
      "runs", body.runs,
      "Closed pieces of the body, one after the other: more than one where it jumps or is hidden "
      "for a while.")
      .atLeast(1);
  members.ifKnown("tolerance", body.tolerance, "Of an animation: that of this body.").above(0);
}

void describeHalfTurns(Members& members, const std::vector<model::HalfTurn>& turns) {
  constexpr std::size_t kMost = 100;
  members("count", turns.size(), "Number of pairs of poses.").atLeast(1);
  members(
      "first", std::span(turns).first(std::min(turns.size(), kMost)), "The first 100 of them.",
      [](Members& own, const model::HalfTurn& turn) {
        own("time", pairOf(turn.time), "Times of the two poses.");
        own("between", turn.between,
            "The two poses: lines of a table, poses of a JSON file, or the node whose keys they "
            "are.");
        own("axis", turn.axis,
            "Axis of the turn taken, which is right-handed; of a node, in the coordinates of its "
            "parent.");
      })
      .itemsFrom(1);
}

void addBody(Members& members, const std::string& body) {
  members("body", body, "Of an animated glTF: the body.").onlyIf(!body.empty());
}

void describeFolds(Members& members, const SweepFolds& folds) {
  members("prisms", folds.prisms, "How many: one is a triangle during a step.");
  members("steps", folds.steps, "How many steps have such prisms.");
  members("first", folds.first, "One prism of each of the first 100 of these steps.",
          [](Members& own, const FoundInBody<mesh4d::Fold>& one) {
            own("time", pairOf(one.found.time), "When the step begins and ends.");
            own("prisms", one.found.prisms, "How many fold in this step.").atLeast(1);
            own("triangle", one.found.triangle, "Number of the prism's triangle, from 0.");
            own("place", one.found.place, "The middle of the prism.");
            addBody(own, one.body);
          });
}

void describeCrossings(Members& members, const SweepCrossings& crossings) {
  members("pairs", crossings.pairs, "How many pairs of triangles, counted once in each step.");
  members("steps", crossings.steps, "How many steps have such pairs.");
  members("unfinished_steps", crossings.unfinishedSteps,
          "In how many steps the search ended early: so many paths overlap.");
  members("first", crossings.first, "The earliest pair of each of the first 100 of these steps.",
          [](Members& own, const FoundInBody<mesh4d::StepCrossing>& one) {
            own("time", pairOf(one.found.time), "When the step begins and ends.");
            own("pairs", one.found.pairs, "How many pairs meet in this step.").atLeast(1);
            own("at", one.found.at, "A time when this pair meets.");
            own("triangles", one.found.triangles, "Numbers of the two triangles, from 0.");
            own("place", one.found.place, "About where they meet then.");
            addBody(own, one.body);
          });
}

}  // namespace

void describe(Members& members, const SweepReport& report) {
  members("vertices", report.vertices, "Vertices of the 4D mesh, each once.").atLeast(5);
  members("tetrahedra", report.tetrahedra, "Cells of the 4D mesh, caps included.").atLeast(5);
  members("steps", report.steps,
          "Steps of all segments; with the backend voxel4d one less than its frames.")
      .atLeast(1);
  members("cap_tetrahedra", report.capTetrahedra,
          "Cells that close the mesh at its first and at its last time.");
  members
      .ifKnown("chord_bound", report.chordBound,
               "With --motion and the backend mesh4d, and of a mechanism: no point of a slice is "
               "farther "
               "from the true solid at that time, nor the other way round, in length units.")
      .atLeast(0);
  members
      .ifKnown("tolerance", report.tolerance,
               "Of an animation: no point of a slice is farther from the true solid at that time, "
               "nor the "
               "other way round, in length units; the largest of all bodies.")
      .above(0);
  members
      .ifKnown("voxel_size", report.voxelSize, "Of --union: edge of the voxels, in length units.")
      .above(0);
  members("bodies", report.bodies, kMeshesOf, describeSweptBody)
      .itemsFrom(1)
      .onlyIf(!report.bodies.empty());
  members(
      "half_turns", report.halfTurns,
      "Poses, or keys of an animated glTF, that are half a turn apart, so that they do not tell "
      "the direction of the turn; left out if there are none.",
      describeHalfTurns)
      .onlyIf(!report.halfTurns.empty());
  members.ifKnown(
      "folds", report.folds,
      "Of a deformation or an animation: prisms that turn over or collapse, so that slices cross "
      "themselves there.",
      describeFolds);
  members(
      "crossings", report.crossings,
      "Of a deformation or an animation: triangles that meet between keys, so that slices cross "
      "themselves there; null if not searched for, as for nodes that only move, or in a build "
      "without CGAL.",
      describeCrossings)
      .onlyIf(report.folds.has_value());
  members("mend", report.mended,
          "With --mend, and of a mechanism: what was done to the solids first, as t4d mend --json "
          "says it.",
          addMending)
      .onlyIf(!report.mended.empty());
  addCosts(members, report.seconds);
  members("bytes", report.bytes, "Size of the file, in bytes.");
}

}  // namespace t4d::tools
