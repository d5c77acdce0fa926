#pragma once

#include "tools/t4d/observer.h"

namespace t4d::tools {

/// Shows stages as progress bars and prints notes.
class ConsoleObserver : public Observer {
 public:
  std::unique_ptr<Stage> stage(std::string title, std::uint64_t total, std::string units) override;
  void note(const std::string& notice) override;
};

}  // namespace t4d::tools
