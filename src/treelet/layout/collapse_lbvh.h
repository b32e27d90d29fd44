#pragma once

#include <treelet/layout/wide_collapse.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// collapse_wide(build_lbvh(references), ...) in one go: decisions are made while the nodes are
/// emitted, which need not be written, nor read again. No face may be repeated.
WideCollapse collapse_lbvh(const References& references, const WideCostModel& model,
                           const SahModel& sah = {});

}  // namespace treelet
