#include "t4d/formats/t4d/http_files.h"

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace t4d::formats {
namespace {

/// Clients that no request uses.
class IdleClients {
 public:
  explicit IdleClients(HttpTimeouts timeouts) : timeouts_(timeouts) {}

  std::unique_ptr<HttpClient> take(const std::string& url) {
    const std::scoped_lock lock(mutex_);
    if (clients_.empty()) return std::make_unique<HttpClient>(url, timeouts_);
    auto client = std::move(clients_.back());
    clients_.pop_back();
    client->goTo(url);
    return client;
  }
  void giveBack(std::unique_ptr<HttpClient> client) {
    const std::scoped_lock lock(mutex_);
    clients_.push_back(std::move(client));
  }

 private:
  HttpTimeouts timeouts_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<HttpClient>> clients_;
};

}  // namespace

system::WebFiles httpFiles(HttpTimeouts timeouts) {
  return [idle = std::make_shared<IdleClients>(timeouts)](
             const std::string& url, const std::string& range, std::uint64_t most) {
    auto client = idle->take(url);
    auto file = client->getFile(range, most);
    idle->giveBack(std::move(client));
    return file;
  };
}

}  // namespace t4d::formats
