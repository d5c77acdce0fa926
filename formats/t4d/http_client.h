#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "formats/t4d/byte_source.h"
#include "t4d/error.h"

namespace t4d::formats {

/// Limits after which a server is given up.
struct HttpTimeouts {
  int connectSeconds = 15;
  int stalledSeconds = 30;  ///< at less than `leastBytesPerSecond`
  int leastBytesPerSecond = 1024;
};

/// A part of a file, as a server sent it.
struct HttpPart {
  std::vector<std::byte> bytes;
  ByteRange range;          ///< of the bytes, in the file
  std::uint64_t total = 0;  ///< bytes of the file
  std::string etag;         ///< empty if the server names none
  std::string lastModified;
};

/// Requests parts of one file from a web server. Follows redirects, and repeats a request whose
/// connection is dropped. A request takes the time to connect and to stall, and that of its bytes
/// at the least speed, at most; what a redirect sends beside its address is limited too. Not safe
/// from several threads.
class HttpClient {
 public:
  explicit HttpClient(std::string url, HttpTimeouts timeouts = {});
  ~HttpClient();

  /// The name for messages: the URL without credentials.
  const std::string& name() const { return name_; }

  /// Requests `range`, such as "0-99" or, for the last 100 bytes, "-100": at most `most` bytes.
  /// `ifMatch`, unless empty, is the ETag that the file must still have. Errors: no connection, any
  /// answer that is not a part of the file, more bytes or fewer than the answer says.
  Result<HttpPart> get(const std::string& range, std::uint64_t most, const std::string& ifMatch);

  /// The number of requests, with redirects and repeated ones.
  std::uint64_t requests() const { return requests_; }
  std::uint64_t bytesReceived() const { return bytesReceived_; }

 private:
  struct Answer;
  struct Session;
  Result<void> request(Answer& answer, const std::string& range, const std::string& ifMatch);
  Result<HttpPart> judge(Answer& answer, const std::string& range) const;
  Error refused(const std::string& message) const;

  std::string name_;
  HttpTimeouts timeouts_;
  std::unique_ptr<Session> session_;
  std::uint64_t requests_ = 0;
  std::uint64_t bytesReceived_ = 0;
};

}  // namespace t4d::formats
