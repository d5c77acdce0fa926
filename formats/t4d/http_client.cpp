#include "formats/t4d/http_client.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string_view>
#include <thread>

#include <curl/curl.h>
#include <fmt/format.h>

#include "formats/t4d/url.h"
#include "model/number.h"

namespace t4d::formats {

namespace {

constexpr long kPartialContent = 206;
constexpr long kPreconditionFailed = 412;
constexpr long kRangeNotSatisfiable = 416;

/// The header of an answer, and no more than this.
constexpr std::size_t kMostHeaderBytes = 1 << 16;

/// The page that a redirect sends to people, and no more than this.
constexpr std::uint64_t kMostDiscardedBytes = 1 << 16;

bool sameIgnoringCase(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

/// The words of a server, fit for a message.
std::string quotable(std::string_view words) {
  constexpr std::size_t kMost = 100;
  std::string text(words.substr(0, kMost));
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

/// "bytes 0-99/1234"; nothing for anything else, such as an unknown length.
struct ContentRange {
  ByteRange range;
  std::uint64_t total = 0;
};
std::optional<ContentRange> contentRangeOf(std::string_view text) {
  constexpr std::string_view kUnit = "bytes ";
  if (!sameIgnoringCase(text.substr(0, kUnit.size()), kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  std::array<std::uint64_t, 3> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0 && !text.starts_with(i == 1 ? '-' : '/')) return std::nullopt;
    if (i > 0) text.remove_prefix(1);
    const auto number = model::takeNumber<std::uint64_t>(text);
    if (!number) return std::nullopt;
    numbers[i] = *number;
  }
  if (!text.empty()) return std::nullopt;
  const auto [first, last, total] = numbers;
  if (first > last || last >= total) return std::nullopt;
  return ContentRange{{first, last + 1}, total};
}

/// Whether the connection broke, rather than was refused or slow.
bool isDropped(CURLcode code) {
  constexpr std::array kDropped = {CURLE_PARTIAL_FILE, CURLE_RECV_ERROR, CURLE_SEND_ERROR,
                                   CURLE_GOT_NOTHING,  CURLE_HTTP2,      CURLE_HTTP2_STREAM};
  return std::ranges::find(kDropped, code) != kDropped.end();
}

}  // namespace

/// An answer while it arrives; that of the last request if there were redirects.
struct HttpClient::Answer {
  CURL* curl = nullptr;
  std::uint64_t most = 0;
  std::string header;
  std::vector<std::byte> body;
  bool tooLong = false;
  bool wordy = false;  ///< a redirect sends more than anybody reads
  bool longHeader = false;

  long status() const {
    long code = 0;
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &code);
    return code;
  }
  /// The bytes that an answer of this status may have.
  std::uint64_t mostOf(long code) const { return code == kPartialContent ? most : 0; }
  std::string_view statusLine() const {
    const std::string_view all(header);
    return trimmed(all.substr(0, all.find('\n')));
  }
  std::string field(std::string_view name) const {
    for (std::string_view rest(header); !rest.empty();) {
      const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
      const std::string_view line = rest.substr(0, end);
      rest.remove_prefix(end + 1);
      const std::size_t colon = line.find(':');
      if (colon != line.npos && sameIgnoringCase(line.substr(0, colon), name)) {
        return std::string(trimmed(line.substr(colon + 1)));
      }
    }
    return {};
  }

  static std::size_t takeHeader(const char* data, std::size_t one, std::size_t size, void* self) {
    auto& answer = *static_cast<Answer*>(self);
    const std::string_view line(data, one * size);
    if (line.starts_with("HTTP/")) answer.header.clear();
    answer.longHeader = answer.header.size() + line.size() > kMostHeaderBytes;
    if (answer.longHeader) return 0;
    answer.header += line;
    return line.size();
  }
  /// Stops at once where the answer is not what was requested.
  static std::size_t takeBody(const char* data, std::size_t one, std::size_t size, void* self) {
    auto& answer = *static_cast<Answer*>(self);
    const std::size_t bytes = one * size;
    const long code = answer.status();
    if (answer.mostOf(code) == 0) return 0;
    answer.tooLong = bytes > answer.mostOf(code) - answer.body.size();
    if (answer.tooLong) return 0;
    const auto* from = reinterpret_cast<const std::byte*>(data);
    answer.body.insert(answer.body.end(), from, from + bytes);
    return bytes;
  }
  /// libcurl reads the bodies of redirects itself.
  static int watch(void* self, curl_off_t, curl_off_t received, curl_off_t, curl_off_t) {
    auto& answer = *static_cast<Answer*>(self);
    answer.wordy = answer.mostOf(answer.status()) == 0 &&
                   static_cast<std::uint64_t>(received) > kMostDiscardedBytes;
    return answer.wordy ? 1 : 0;
  }
};

struct HttpClient::Session {
  explicit Session(const std::string& url) : url(url) {
    static const CURLcode ready = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (ready == CURLE_OK) curl = curl_easy_init();
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() { curl_easy_cleanup(curl); }

  std::string url;
  CURL* curl = nullptr;
};

HttpClient::HttpClient(std::string url, HttpTimeouts timeouts)
    : name_(shownName(url)), timeouts_(timeouts), session_(std::make_unique<Session>(url)) {}

HttpClient::~HttpClient() = default;

Error HttpClient::refused(const std::string& message) const {
  return fail(ErrorCode::Io, message, name_);
}

Result<void> HttpClient::request(Answer& answer, const std::string& range,
                                 const std::string& ifMatch) {
  CURL* const curl = session_->curl;
  if (curl == nullptr) return refused("libcurl cannot be used");
  constexpr int kAttempts = 3;
  constexpr long kMostRedirects = 5;
  const bool secure = schemeOf(session_->url) == "https";
  const auto mostSeconds =
      static_cast<long>(timeouts_.connectSeconds + timeouts_.stalledSeconds +
                        answer.most / static_cast<std::uint64_t>(timeouts_.leastBytesPerSecond));
  answer.curl = curl;
  for (int attempt = 1;; ++attempt) {
    answer.header.clear();
    answer.body.clear();
    std::array<char, CURL_ERROR_SIZE> words{};
    curl_slist* fields = curl_slist_append(nullptr, "Accept-Encoding: identity");
    if (!ifMatch.empty()) fields = curl_slist_append(fields, ("If-Match: " + ifMatch).c_str());
    // A reset keeps the connection.
    curl_easy_reset(curl);
    curl_easy_setopt(curl, CURLOPT_URL, session_->url.c_str());
    if (!range.empty()) curl_easy_setopt(curl, CURLOPT_RANGE, range.c_str());
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, fields);
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "t4d");
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_REDIR_PROTOCOLS_STR, secure ? "https" : "http,https");
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(curl, CURLOPT_MAXREDIRS, kMostRedirects);
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, static_cast<long>(timeouts_.connectSeconds));
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT,
                     static_cast<long>(timeouts_.leastBytesPerSecond));
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, static_cast<long>(timeouts_.stalledSeconds));
    curl_easy_setopt(curl, CURLOPT_TIMEOUT, mostSeconds);
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, &Answer::watch);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, &answer);
    curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, words.data());
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, &Answer::takeHeader);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, &answer);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &Answer::takeBody);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &answer);
    const CURLcode code = curl_easy_perform(curl);
    curl_slist_free_all(fields);
    long redirects = 0;
    curl_easy_getinfo(curl, CURLINFO_REDIRECT_COUNT, &redirects);
    requests_ += 1 + static_cast<std::uint64_t>(redirects);
    bytesReceived_ += answer.body.size();
    // libcurl puts a line together before it passes it on. If that gets too long, it says so from
    // version 8.6 on, and before that memory is out, once an answer has begun.
    constexpr int kTooLarge = 100;  // CURLE_TOO_LARGE
    curl_off_t untilAnswer = 0;
    curl_easy_getinfo(curl, CURLINFO_STARTTRANSFER_TIME_T, &untilAnswer);
    if (answer.longHeader || code == kTooLarge ||
        (code == CURLE_OUT_OF_MEMORY && untilAnswer > 0 && answer.body.empty())) {
      return refused(
          fmt::format("the server's answer has a header of more than {} bytes", kMostHeaderBytes));
    }
    if (code == CURLE_OK || (code == CURLE_WRITE_ERROR && !answer.header.empty())) {
      return {};
    }
    if (answer.wordy) {
      return refused(
          fmt::format("the server sends a redirect with more than {} bytes", kMostDiscardedBytes));
    }
    if (isDropped(code) && attempt < kAttempts) {
      std::this_thread::sleep_for(std::chrono::milliseconds(250 * attempt));
      continue;
    }
    std::string message = quotable(words[0] != 0 ? words.data() : curl_easy_strerror(code));
    if (attempt > 1) message += fmt::format("; it was tried {} times", attempt);
    return refused(message);
  }
}

Result<HttpPart> HttpClient::get(const std::string& range, std::uint64_t most,
                                 const std::string& ifMatch) {
  Answer answer;
  answer.most = most;
  if (auto done = request(answer, range, ifMatch); !done) return done.error();
  return judge(answer, range);
}

Result<HttpPart> HttpClient::judge(Answer& answer, const std::string& range) const {
  const long status = answer.status();
  const std::string words = quotable(answer.statusLine());
  if (status == kPreconditionFailed) {
    return refused("the file has changed while it was read; start again");
  }
  if (status == kRangeNotSatisfiable) {
    return refused(
        fmt::format("the server answers {}: the file is empty, or has become shorter", words));
  }
  if (status >= 200 && status < 300 && status != kPartialContent) {
    return refused(fmt::format(
        "the server answers {} where a part of the file is requested: it sends files only as a "
        "whole; download the file first",
        words));
  }
  if (status != kPartialContent) return refused(fmt::format("the server answers {}", words));
  if (answer.tooLong) {
    return refused(fmt::format("the server sends more than the {} bytes requested", answer.most));
  }
  const std::string encoding = answer.field("Content-Encoding");
  if (!encoding.empty() && !sameIgnoringCase(encoding, "identity")) {
    return refused(
        fmt::format("the server sends parts of the file encoded as {}, which cannot be put "
                    "together; download the file first",
                    quotable(encoding)));
  }
  const std::string said = answer.field("Content-Range");
  const auto found = contentRangeOf(said);
  if (!found) {
    return refused(fmt::format("the server sends '{}' as the Content-Range of bytes={}",
                               quotable(said), range));
  }
  const std::uint64_t bytes = found->range.end - found->range.begin;
  if (bytes != answer.body.size()) {
    return refused(
        fmt::format("the server sends {} bytes and says '{}'", answer.body.size(), quotable(said)));
  }
  return HttpPart{std::move(answer.body), found->range, found->total, answer.field("ETag"),
                  answer.field("Last-Modified")};
}

}  // namespace t4d::formats
