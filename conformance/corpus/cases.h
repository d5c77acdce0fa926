#pragma once

#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "conformance/corpus/corpus.h"
#include "conformance/corpus/image.h"

/// The corpus in parts, with the details its tests need.
namespace t4d::conformance {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A file that a reader may accept.
struct AcceptedCase {
  CorpusFile file;
  std::vector<BodySlabs> bodies;
  /// Closed forms, if known: the total over all bodies, and their slices.
  std::optional<double> hypervolume;
  std::function<double(double time)> sliceVolume;
};

/// A file with one fault.
struct InvalidCase {
  CorpusFile file;
  std::string repaired;  ///< the file without the fault
};

std::vector<AcceptedCase> validCases();
std::vector<InvalidCase> invalidCases();
std::vector<AcceptedCase> implCases();

/// Builds a file that a reader may accept.
class AcceptedBuilder {
 public:
  /// `id` as in CorpusFile, `what` its `fault`.
  AcceptedBuilder(const std::string& id, Validity validity, const std::string& what);

  /// Sets the file to Image::of, with `head` as HEAD if given.
  AcceptedBuilder& of(const std::vector<BodySlabs>& bodies, const ImageOptions& options = {},
                      const std::optional<std::string>& head = {});
  /// Sets the file to `image`, which holds `bodies`.
  AcceptedBuilder& of(const Image& image, const std::vector<BodySlabs>& bodies,
                      const ImageOptions& options = {});
  /// The features that HEAD names, if more than are used.
  AcceptedBuilder& naming(const std::vector<std::string>& features);
  /// Features that the file demonstrates, besides those visible in its slabs and options.
  AcceptedBuilder& shows(const std::vector<std::string>& features);
  AcceptedBuilder& slicedAt(const std::vector<double>& times);
  /// Hyperplanes to slice the bodies by, besides those by which all are sliced.
  AcceptedBuilder& slicedBy(const std::vector<slice::Hyperplane>& hyperplanes);
  AcceptedBuilder& encloses(double hypervolume,
                            std::function<double(double time)> sliceVolume = {});
  AcceptedBuilder& leftOpenIn(const std::string& heading);
  AcceptedBuilder& at(std::uint64_t offset);

  AcceptedCase finish() const;

 private:
  AcceptedCase case_;
  ImageOptions options_;
  std::vector<std::string> named_;
  std::vector<std::string> shown_;
  std::vector<double> times_;
  std::vector<slice::Hyperplane> hyperplanes_;
};

/// A list of files being built, all of one validity: Valid or Either.
class AcceptedCases {
 public:
  explicit AcceptedCases(Validity validity) : validity_(validity) {}

  /// The reference stays valid after further calls.
  AcceptedBuilder& add(const std::string& name, const std::string& what);
  std::vector<AcceptedCase> finish() const;

 private:
  Validity validity_;
  std::deque<AcceptedBuilder> builders_;
};

/// Files at the limits of what rules allow, and beside what they forbid.
void addLimits(AcceptedCases& cases);

/// The features of SPEC.md that the bodies need if stored this way.
std::vector<std::string> neededFeatures(const std::vector<BodySlabs>& bodies,
                                        const ImageOptions& options);

}  // namespace t4d::conformance
