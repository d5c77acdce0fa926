#pragma once

#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "t4d/conformance/corpus/corpus.h"
#include "t4d/conformance/corpus/image.h"

/// The corpus in parts, with what tests of it want to know.
namespace t4d::conformance {

/// A file that can be accepted.
struct AcceptedCase {
  CorpusFile file;
  std::vector<BodySlabs> bodies;
  /// The closed forms, where there is one: what all bodies together enclose, and their slices.
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

/// A file in the making that can be accepted.
class AcceptedBuilder {
 public:
  /// `id` as in CorpusFile, `what` its `fault`.
  AcceptedBuilder(const std::string& id, Validity validity, const std::string& what);

  /// The file as Image::of makes it, with `head` for HEAD where it is given.
  AcceptedBuilder& of(const std::vector<BodySlabs>& bodies, const ImageOptions& options = {},
                      const std::optional<std::string>& head = {});
  /// The file `image`, which holds `bodies`.
  AcceptedBuilder& of(const Image& image, const std::vector<BodySlabs>& bodies,
                      const ImageOptions& options = {});
  /// What HEAD names, where that is more than is used.
  AcceptedBuilder& naming(const std::vector<std::string>& features);
  /// What the file shows, beside what is seen from its slabs and options.
  AcceptedBuilder& shows(const std::vector<std::string>& features);
  AcceptedBuilder& slicedAt(const std::vector<double>& times);
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
};

/// Files in the making, of one validity: Valid or Either.
class AcceptedCases {
 public:
  explicit AcceptedCases(Validity validity) : validity_(validity) {}

  /// Further calls do not move it.
  AcceptedBuilder& add(const std::string& name, const std::string& what);
  std::vector<AcceptedCase> finish() const;

 private:
  Validity validity_;
  std::deque<AcceptedBuilder> builders_;
};

/// The features of SPEC.md that the bodies need when they are stored so.
std::vector<std::string> neededFeatures(const std::vector<BodySlabs>& bodies,
                                        const ImageOptions& options);

}  // namespace t4d::conformance
