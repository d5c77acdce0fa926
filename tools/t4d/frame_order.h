#pragma once

#include <string>
#include <vector>

namespace t4d::tools {

/// Frames stay in the order of the command line, unless it is the one in which a shell sorts what a
/// pattern matches, by text: frame1 frame10 frame2, three names or more that are alike but for
/// numbers. These are put in the order of their numbers. Returns a notice that names the first and
/// the last, or says that numbers go down where the order stands; "" for none.
std::string orderFrames(std::vector<std::string>& files);

}  // namespace t4d::tools
