#pragma once

namespace t4d::tools {

/// From here on, a signal that ends the program (Ctrl-C, say) first removes partly written files
/// and ends the processes that the program has started (platform::cleanUp); then the program ends
/// by that signal. A signal that is ignored stays ignored (nohup). Exceeding the file size limit is
/// a write error, not a signal.
void cleanUpOnSignals();

}  // namespace t4d::tools
