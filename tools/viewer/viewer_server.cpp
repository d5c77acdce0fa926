#include "tools/viewer/viewer_server.h"

#ifdef T4D_WITH_HTTPLIB

#include <algorithm>
#include <chrono>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <httplib.h>

#include "platform/open_file.h"

namespace t4d::tools {
namespace {

/// A file that is served, open all the time: one that takes its name later is another.
struct Served {
  std::string path;  ///< of the URL
  platform::OpenFile file;
  /// Names this version of the file.
  std::string tag() const { return fmt::format("\"{}\"", file.version()); }
};

/// Sends up to a megabyte. False if it cannot be read, or nobody listens any more.
bool send(const platform::OpenFile& file, std::size_t offset, std::size_t length,
          httplib::DataSink& sink) {
  std::vector<char> piece(std::min(length, std::size_t{1} << 20));
  const auto count = file.readAt(offset, std::as_writable_bytes(std::span(piece)));
  return count && *count > 0 && sink.write(piece.data(), *count);
}

/// A connection that says nothing holds a thread until its time is over. Browsers open connections
/// ahead, and another program may leave hundreds half open: with so many threads and so short a
/// time, nobody waits long behind them. A thread that waits takes next to nothing.
constexpr std::size_t kThreads = 512;
constexpr std::chrono::seconds kSilence(1);
/// The time to wait for a browser that does not read on.
constexpr std::chrono::seconds kWriteTime(5);
/// No request here has a body.
constexpr std::size_t kMostBodyBytes = 1 << 16;

/// Only pages of this server may read the files: a page elsewhere whose name was made to lead here
/// (DNS rebinding) says another host.
bool isOwnHost(const std::string& host, int port) {
  return host == fmt::format("127.0.0.1:{}", port) || host == fmt::format("localhost:{}", port);
}

/// Makes the ranges of a request fit what they are of, as RFC 9110 wants it and httplib leaves to
/// us: an end beyond the size is cut, and several ranges are answered with the whole. False for a
/// range outside.
bool fitRanges(const httplib::Request& request, std::size_t size) {
  // The request is the server's own, and not const; it applies the ranges after the handler.
  httplib::Ranges& ranges = const_cast<httplib::Request&>(request).ranges;
  if (ranges.size() != 1) {
    ranges.clear();
    return true;
  }
  auto& [first, last] = ranges.front();
  const auto end = static_cast<ssize_t>(size);
  if (first < 0) {  // the last bytes, as many as `last`
    if (last <= 0) return false;
    first = std::max<ssize_t>(0, end - last);
    last = end - 1;
  } else if (last < 0 || last >= end) {
    last = end - 1;
  }
  return first < end;
}

/// Answers a request for a range outside.
void refuseRange(const httplib::Request& request, httplib::Response& response, std::size_t size) {
  const_cast<httplib::Request&>(request).ranges.clear();
  response.status = 416;
  response.set_header("Content-Range", fmt::format("bytes */{}", size));
}

}  // namespace

bool canServe() { return true; }

Result<void> serveViewer(const std::string& page, std::span<const ServedFile> files, int port,
                         const std::function<void(const std::string& url)>& onReady) {
  httplib::Server server;
  // SO_REUSEADDR, not SO_REUSEPORT, httplib's default: two servers would then share a port.
  int listening = -1;
  server.set_socket_options([&](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    listening = socket;
  });
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_keep_alive_timeout(kSilence.count());
  server.set_read_timeout(kSilence);
  server.set_write_timeout(kWriteTime);
  server.set_payload_max_length(kMostBodyBytes);
  std::vector<Served> opened;
  for (const ServedFile& shown : files) {
    auto file = platform::OpenFile::openRegular(shown.path);
    if (!file) return file.error();
    opened.push_back({"/" + shown.name, std::move(*file)});
  }
  server.set_default_headers(
      {{"Cache-Control", "no-cache"}, {"X-Content-Type-Options", "nosniff"}});
  server.set_pre_routing_handler([&](const httplib::Request& request, httplib::Response& response) {
    if (isOwnHost(request.get_header_value("Host"), port)) {
      return httplib::Server::HandlerResponse::Unhandled;
    }
    response.status = 403;
    return httplib::Server::HandlerResponse::Handled;
  });
  // Providers answer ranges, and are not compressed.
  server.Get("/.*", [&](const httplib::Request& request, httplib::Response& response) {
    if (request.path == "/") {
      if (!fitRanges(request, page.size())) return refuseRange(request, response, page.size());
      response.set_content_provider(
          page.size(), "text/html; charset=utf-8",
          [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
            return sink.write(page.data() + offset, length);
          });
      return;
    }
    const auto found = std::ranges::find(opened, request.path, &Served::path);
    if (found == opened.end()) {
      response.status = 404;
      return;
    }
    const platform::OpenFile& file = found->file;
    const std::string wanted = request.get_header_value("If-Match");
    if (!wanted.empty() && wanted != found->tag()) {
      response.status = 412;
      return;
    }
    response.set_header("ETag", found->tag());
    if (!fitRanges(request, file.size())) return refuseRange(request, response, file.size());
    response.set_content_provider(
        file.size(), "model/vnd.t4d",
        [&file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
          return send(file, offset, length, sink);
        });
  });
  if (port == 0) {
    port = server.bind_to_any_port("127.0.0.1");
    if (port < 0) {
      return fail(ErrorCode::Failed, "no port of this machine can be listened on");
    }
  } else if (!server.bind_to_port("127.0.0.1", port)) {
    return fail(ErrorCode::Failed,
                fmt::format("cannot listen on port {}; another program may use it", port));
  }
  // httplib lets five connections wait to be accepted; the sixth would try again after a second.
  ::listen(listening, SOMAXCONN);
  onReady(fmt::format("http://127.0.0.1:{}/", port));
  if (!server.listen_after_bind()) return fail(ErrorCode::Failed, "the server stopped");
  return {};
}

}  // namespace t4d::tools

#else

namespace t4d::tools {

bool canServe() { return false; }

Result<void> serveViewer(const std::string&, std::span<const ServedFile>, int,
                         const std::function<void(const std::string& url)>&) {
  return fail(ErrorCode::Failed, "built without cpp-httplib, which serves the page");
}

}  // namespace t4d::tools

#endif
