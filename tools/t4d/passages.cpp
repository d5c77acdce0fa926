#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "measure/chord_bound.h"
#include "tools/t4d/body_passage.h"
#include "tools/t4d/envelope.h"

namespace t4d::tools {
namespace {

Result<Passage> passageOf(const model::Body& body, const Passages& passages,
                          const EnvelopeOptions& options, Stage& stage) {
  const Input& input = passages.input;
  const auto inBody = [&](Error error) {
    error.where =
        placeIn(input.name, fmt::format("body '{}'{}{}", body.name, error.where.empty() ? "" : ", ",
                                        error.where.text()));
    return error;
  };
  measure::SilhouetteBuilder builder;
  if (auto put = putWithin(body, options.window, passages.span, builder,
                           stage.part(body.source->slabCount()));
      !put) {
    return inBody(put.error());
  }
  auto silhouette = builder.finish();
  if (!silhouette) return inBody(silhouette.error());
  Passage passage{body.name, std::move(*silhouette)};
  if (!options.part) {
    const auto chords = measure::chordBound(*body.source, passages.span, motionOf(input, body.name),
                                            stage.part(body.source->slabCount()));
    if (!chords) return inBody(chords.error());
    if (*chords) passage.chordBound = (*chords)->bound;
  }
  return passage;
}

void unite(Passage& all, const Passage& one) {
  edit::add(all.silhouette, one.silhouette);
  all.chordBound =
      all.chordBound && one.chordBound ? std::max(all.chordBound, one.chordBound) : std::nullopt;
  all.name = "envelope";
}

}  // namespace

Result<void> putWithin(const model::Body& body, const TimeWindow& window,
                       const model::TimeSpan& span, model::Sink& sink,
                       const model::Progress& progress) {
  if (window.isWhole()) return model::pump(*body.source, sink, progress);
  const auto clip = edit::clipTime(*body.source, span, sink, progress);
  if (!clip) return clip.error();
  return {};
}

Result<Passages> passagesOf(const Input& input, const EnvelopeOptions& options,
                            Observer& observer) {
  const auto span = options.window.spanIn(input);
  if (!span) return span.error();
  Passages passages{input, *span, {}};
  std::vector<std::string> notices;
  keepThoseWithin(*span, passages.input, notices);
  for (const std::string& notice : notices) observer.note(notice);
  const std::vector<model::Body>& bodies = passages.input.bodies;
  // Bounds of chords are read off the same slabs again; those are of the surface.
  const auto stage = observer.stage("finding the silhouette",
                                    (options.part ? 1 : 2) * slabCountOf(bodies), "slabs");
  for (const model::Body& body : bodies) {
    auto passage = passageOf(body, passages, options, *stage);
    if (!passage) return passage.error();
    if (options.each || passages.all.empty()) {
      passages.all.push_back(std::move(*passage));
    } else {
      unite(passages.all[0], *passage);
    }
  }
  return passages;
}

std::optional<std::string> doubtOfHypervolume(const Passage& passage, const model::TimeSpan& span) {
  const measure::Silhouette& silhouette = passage.silhouette;
  const double error = std::abs(silhouette.hypervolume - silhouette.hypervolumeByFlux);
  // Coordinates are rounded, however small the solid is.
  constexpr double kMost = 1e-9;
  constexpr double kRounding = 1e-14;
  const double most = kMost * std::abs(silhouette.hypervolumeByFlux) +
                      kRounding * silhouette.visitsVolume * (span.end - span.begin);
  if (error <= most) return std::nullopt;
  return fmt::format("the hypervolume is {} as the integral of dwell, but {} as a flux",
                     silhouette.hypervolume, silhouette.hypervolumeByFlux);
}

}  // namespace t4d::tools
