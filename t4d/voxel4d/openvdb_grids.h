#pragma once

#include <openvdb/openvdb.h>

// libopenvdb registers these grids, so it has their virtual functions. Without the declarations g++
// would compile them again in every source that makes a grid, which takes 30 seconds. clang would
// expect the library to have all inline members as well, and it does not.
#if defined(__GNUC__) && !defined(__clang__)
namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

namespace tree {
extern template class Tree<FloatTree::RootNodeType>;
extern template class Tree<DoubleTree::RootNodeType>;
extern template class Tree<Int32Tree::RootNodeType>;
extern template class Tree<BoolTree::RootNodeType>;
extern template class Tree<MaskTree::RootNodeType>;
extern template class Tree<Vec3STree::RootNodeType>;
}  // namespace tree

extern template class Grid<FloatTree>;
extern template class Grid<DoubleTree>;
extern template class Grid<Int32Tree>;
extern template class Grid<BoolTree>;
extern template class Grid<MaskTree>;
extern template class Grid<Vec3STree>;

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb
#endif
