#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/error.h"

/// The viewer: a page that needs nothing else, and cuts 4D meshes in a browser. Its text, `viewer`,
/// is that of web/viewer/dist/viewer.html with the element t4d-view.js in it.
namespace t4d::tools {

/// A file that the page opens, beside those before it.
struct ShownFile {
  std::string name;              ///< what the page calls it, and its address beside the page
  std::string url;               ///< its address if it is on a web server; else empty
  std::filesystem::path path{};  ///< where it is if it is not
  bool isCopy = false;           ///< it is beside the page because the page's writer put it there
};

/// The files of these paths and URLs, each with a name of its own.
std::vector<ShownFile> shownFiles(std::span<const std::string> inputs);

/// The page that opens these files, by their URLs or beside itself, and shows the tracks of the
/// first: a report of `track` as JSON; none if empty. Fails (Options) if the text is not that of
/// the viewer; so do the others.
Result<std::string> viewerPage(std::string_view viewer, std::span<const ShownFile> files,
                               std::string_view tracks = {});

/// The page with the files in it, but for those with a URL. Errors: a file cannot be read.
Result<std::string> pageWithFiles(std::string_view viewer, std::span<const ShownFile> files,
                                  std::string_view tracks = {});

/// Fails if `writeSite` would replace a symbolic link, or a file that is not of a site it wrote
/// before: an index.html that is not its own, or a file that its own does not list as a copy.
Result<void> checkSite(const std::filesystem::path& folder, std::span<const ShownFile> files);

/// Writes a folder that any web server can hold: index.html and copies of the files. It may be
/// there already; its other files stay. Returns the bytes written. Errors: checkSite's; a file
/// cannot be read or written.
Result<std::uint64_t> writeSite(std::string_view viewer, const std::filesystem::path& folder,
                                std::span<const ShownFile> files, std::string_view tracks = {});

}  // namespace t4d::tools
