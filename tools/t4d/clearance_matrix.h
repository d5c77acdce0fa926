#pragma once

#include <string>

#include "tools/t4d/collide.h"

namespace t4d::tools {

/// An <svg> element with a square for each pair of bodies: red where they hit, orange where they
/// touch, cannot be told apart or do not keep the clearance, otherwise the lighter the farther they
/// stay apart; without colour if they were not tested. Titles of squares tell the distances, in
/// `lengthUnit`.
std::string clearanceMatrix(const CollideReport& report, const std::string& lengthUnit);

}  // namespace t4d::tools
