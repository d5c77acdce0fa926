#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/t4d/observer.h"
#include "tools/t4d/viewer_page.h"

namespace t4d::tools {

class Members;

struct ViewOptions {
  /// .t4d and .t4dm files to show side by side: paths or URLs.
  std::vector<std::string> inputs = {};
  std::optional<std::uint64_t> maxCells = {};  ///< as T4dReader::open takes it
  std::string viewer = {};                     ///< the text of the page (viewer_page.h)
  std::string tracks = {};                     ///< a report of `track` on the only input, as JSON
  /// One page, if it ends in .html or .htm or is "-", the standard output; or else a folder.
  std::string output = {};
};

struct ViewReport {
  std::string url = {};                     ///< where the page is served; "" if it is written
  std::vector<std::string> files;           ///< what the page calls them
  std::string output = {};                  ///< the page or folder that was written
  std::optional<std::uint64_t> bytes = {};  ///< written
};

/// The inputs as the viewer reads them.
struct ViewedFiles {
  std::vector<ShownFile> files;
  std::string tracks;                  ///< the report
  std::shared_ptr<const void> joined;  ///< while it lives, those that were in parts are files

  /// The names of the files on the page.
  std::vector<std::string> names() const;
};

/// Joins files in parts, and checks that all can be opened. Fails if the tracks are of one of two
/// inputs (Options), or no report of `track` (Invalid).
Result<ViewedFiles> viewedFiles(const ViewOptions& options, Observer& observer = nobody());

/// Whether one page is to be written, and not a folder.
bool isOnePage(const std::string& output);

/// Writes a page that shows 4D meshes in a browser, with the files in it; or a folder for a web
/// server, with the page and the files. Fails (Options) if the output is one of the inputs, if the
/// files are too large for one page, and if the folder is a file, or has files of other origin that
/// would be replaced.
Result<ViewReport> view(const ViewOptions& options, Observer& observer = nobody());

void describe(Members& members, const ViewReport& report);

}  // namespace t4d::tools
