#pragma once

namespace treelet {

/// Debug builds check the tree after every stage of a build.
#if defined(TREELET_VALIDATE_STAGES) && TREELET_VALIDATE_STAGES
inline constexpr bool kValidateStages = true;
#else
inline constexpr bool kValidateStages = false;
#endif

}  // namespace treelet
