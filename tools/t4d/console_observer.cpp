#include "tools/t4d/console_observer.h"

#include "tools/t4d/console.h"
#include "tools/t4d/progress_bar.h"

namespace t4d::tools {

std::unique_ptr<Stage> ConsoleObserver::stage(std::string title, std::uint64_t total,
                                              std::string units) {
  return std::make_unique<ProgressBar>(shownLine(title), total, std::move(units));
}

void ConsoleObserver::note(const std::string& notice) { printNotices({notice}); }

}  // namespace t4d::tools
