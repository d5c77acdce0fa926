#pragma once

namespace t4d::tools {

/// From here on, a signal that ends the program (Ctrl-C, say) removes what it has half written and
/// ends the processes that it has started (system::cleanUp), and then ends it as before. A signal
/// that is ignored stays ignored (nohup). A limit on the size of files is a write that fails, not a
/// signal.
void cleanUpOnSignals();

}  // namespace t4d::tools
