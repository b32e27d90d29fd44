#pragma once

namespace treelet {

/// Whether every stage of a build is followed by a check; the CMake option TREELET_VALIDATE_STAGES.
#if defined(TREELET_VALIDATE_STAGES) && TREELET_VALIDATE_STAGES
inline constexpr bool kValidateStages = true;
#else
inline constexpr bool kValidateStages = false;
#endif

}  // namespace treelet
