# The target treelet_embree: Embree 4 as the system has it, else as the Python package embreex brings
# it along. Neither needs headers (bench/peers/embree_api.h).

include(TreeletPythonPackage)

add_library(treelet_embree INTERFACE)

find_package(embree 4 CONFIG QUIET)
if(embree_FOUND)
  message(STATUS "treelet: races Embree ${embree_VERSION} of ${embree_DIR}")
  target_link_libraries(treelet_embree INTERFACE embree)
  return()
endif()

# Sets `library` to Embree's inside the package of the Python that is first on PATH, or to nothing.
function(treelet_find_embreex library)
  set(${library} "" PARENT_SCOPE)
  treelet_find_python_package(embreex package)
  if(NOT package)
    return()
  endif()
  file(GLOB found "${package}.libs/libembree4*.so*" "${package}/.dylibs/libembree4*.dylib")
  if(found)
    list(GET found 0 first)
    set(${library} "${first}" PARENT_SCOPE)
  endif()
endfunction()

treelet_find_embreex(embreex_library)
if(NOT embreex_library)
  message(FATAL_ERROR "TREELET_BUILD_PEERS=ON, but there is no Embree 4. Install it where CMake finds "
    "its package (embree_DIR), or into the Python that is first on PATH:\n"
    "  python -m pip install \"embreex>=4.4\"")
endif()
message(STATUS "treelet: races ${embreex_library}")
target_link_libraries(treelet_embree INTERFACE "${embreex_library}")
