#pragma once

#include <openvdb/openvdb.h>

// libopenvdb registers these grids, and so has their virtual functions compiled. Without the
// declarations every source that makes a grid compiles them again: 30 seconds each time.
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
