#pragma once

#include <treelet/file/byte_stream.h>
#include <treelet/pipeline/bvh.h>

namespace treelet {

/// What a file says of a tree beside its arrays: the layout's bounds, depth and number of
/// triangles, costs, placement, and what the report cannot take from the layout.
void put_facts(const Bvh& bvh, ByteWriter& writer);

/// The same in that order; the tree has a layout of the right kind. Throws FileError.
void take_facts(ByteReader& reader, Bvh& bvh);

}  // namespace treelet
