#pragma once

namespace t4d::system {

/// Gives memory that was freed in small pieces back to the system, which malloc keeps otherwise.
/// Takes about a millisecond for each 10 MB; call it when much has been freed.
void giveBackFreedMemory();

}  // namespace t4d::system
