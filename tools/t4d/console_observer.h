#pragma once

#include "tools/verbs/observer.h"

namespace t4d::tools {

/// Shows stages as progress bars and prints notes.
class ConsoleObserver : public verbs::Observer {
 public:
  std::unique_ptr<verbs::Stage> stage(std::string title, std::uint64_t total,
                                      std::string units) override;
  void note(const std::string& notice) override;
};

}  // namespace t4d::tools
