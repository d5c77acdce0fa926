#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "platform/child_process.h"
#include "tests/paths.h"

/// For tests.
namespace t4d::formats {

/// web_server.py, which serves the files of a folder, with the fault that a URL names.
class WebServer {
 public:
  struct Request {
    std::string path;
    std::string range;
    std::string match;  ///< the ETag that the file must have
    int status = 0;
    std::uint64_t bytes = 0;
  };

  explicit WebServer(const std::filesystem::path& folder) : log_(folder / "requests.jsonl") {
    std::filesystem::remove(log_);
    auto words = platform::splitCommand("python3 " T4D_SOURCE_DIR "/tests/web_server.py");
    EXPECT_TRUE(words);
    words->push_back(folder.string());
    auto started = platform::ChildProcess::start(*words, {});
    EXPECT_TRUE(started);
    process_.emplace(std::move(*started));
    constexpr double kSeconds = 60;
    process_->wait(kSeconds, nullptr, [&] { return process_->output().ends_with('\n'); });
    port_ = process_->output().substr(0, process_->output().find('\n'));
    EXPECT_FALSE(port_.empty()) << process_->message();
  }

  std::string url(const std::string& path, const std::string& user = {}) const {
    return "http://" + user + "127.0.0.1:" + port_ + "/" + path;
  }

  /// The requests so far, whose path begins with this.
  std::vector<Request> requests(const std::string& path) const {
    std::vector<Request> found;
    std::ifstream lines(log_);
    for (std::string line; std::getline(lines, line);) {
      const auto said = nlohmann::json::parse(line);
      if (!said["path"].get<std::string>().starts_with("/" + path)) continue;
      found.push_back({said["path"], said["range"], said["match"], said["status"], said["bytes"]});
    }
    return found;
  }

 private:
  std::filesystem::path log_;
  std::optional<platform::ChildProcess> process_;
  std::string port_;
};

}  // namespace t4d::formats
