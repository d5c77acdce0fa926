#pragma once

#include <optional>
#include <string>

#include "t4d/formats/t4d/metadata.h"

/// What the details of bodies say of a mechanism that they are part of.
namespace t4d::formats {

/// The rigid link that the body is a part of, beside others perhaps; by default the body itself.
std::string linkOf(const BodyInfo& body);
void setLink(BodyInfo& body, const std::string& link);

/// How far slices can be from the true solid at their time, and the other way round, in length
/// units, where poses do not tell: the motion from one to the next is not a screw. Nothing if it
/// is not stated.
std::optional<double> chordBoundOf(const BodyInfo& body);
void setChordBound(BodyInfo& body, double bound);

}  // namespace t4d::formats
