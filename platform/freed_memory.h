#pragma once

namespace t4d::platform {

/// Returns memory that was freed in small pieces to the system; malloc would keep it. Takes about a
/// millisecond per 10 MB. Call it after much has been freed.
void giveBackFreedMemory();

}  // namespace t4d::platform
