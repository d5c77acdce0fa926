#pragma once

#include <vector>

#include "conformance/corpus/corpus.h"
#include "conformance/corpus/image.h"

/// The corpus in parts, and what these share.
namespace t4d::conformance {

std::vector<CorpusFile> validFiles();
std::vector<CorpusFile> invalidFiles();
std::vector<CorpusFile> implFiles();

/// Fills in what a reader must answer of a file of these bodies: the description and slices at
/// `times`. The positions are given in binary64, and are rounded here for `float32`.
void expect(CorpusFile& file, const std::vector<BodySlabs>& bodies,
            const std::vector<std::string>& features, const std::vector<double>& times,
            const ImageOptions& options = {});

}  // namespace t4d::conformance
