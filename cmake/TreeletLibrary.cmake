# The library target `treelet`, known to consumers as treelet::treelet.

include(TreeletCompileOptions)
include(TreeletCuda)
find_package(Threads REQUIRED)

file(GLOB_RECURSE treelet_sources CONFIGURE_DEPENDS
  "${PROJECT_SOURCE_DIR}/src/treelet/*.cpp")
file(GLOB_RECURSE treelet_headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}/src"
  "${PROJECT_SOURCE_DIR}/src/treelet/*.h")
if(TREELET_HAS_CUDA)
  # x_no_cuda.cpp takes the place of x.cu where there is no CUDA.
  list(FILTER treelet_sources EXCLUDE REGEX "_no_cuda\\.cpp$")
endif()

add_library(treelet ${treelet_sources})
add_library(treelet::treelet ALIAS treelet)

# Kernels are compiled once an instruction set and chosen at run time (core/isa.h).
set(processor "${CMAKE_SYSTEM_PROCESSOR}")
if(CMAKE_OSX_ARCHITECTURES)
  set(processor "${CMAKE_OSX_ARCHITECTURES}")  # a universal build gets the baseline alone
endif()
if(processor MATCHES "^(x86_64|AMD64)$")
  file(GLOB avx2_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/treelet/*/*_avx2.cpp")
  file(GLOB avx512_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/treelet/*/*_avx512.cpp")
  # Just what core/isa.cpp asks the processor for. Never without optimisation: inline functions of
  # the standard library would stay behind as symbols that the linker may give to all files.
  set(avx2_flags -mavx2 -mfma -mbmi -mbmi2)
  set(avx512_flags ${avx2_flags} -mavx512f -mavx512bw -mavx512cd -mavx512dq -mavx512vl)
  set(optimised "$<$<CONFIG:Debug,>:-O1>")
  set_source_files_properties(${avx2_sources} PROPERTIES COMPILE_OPTIONS "${avx2_flags};${optimised}")
  set_source_files_properties(${avx512_sources} PROPERTIES COMPILE_OPTIONS "${avx512_flags};${optimised}")
endif()

target_compile_features(treelet PUBLIC cxx_std_20)
set_target_properties(treelet PROPERTIES
  CXX_EXTENSIONS OFF
  UNITY_BUILD OFF  # files have constants of the same name
  POSITION_INDEPENDENT_CODE ON  # the static library also goes into Python's extension module
  WINDOWS_EXPORT_ALL_SYMBOLS ON
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

# A file set, so that installing keeps the folders and the include root follows the package.
list(TRANSFORM treelet_headers PREPEND "${PROJECT_SOURCE_DIR}/src/" OUTPUT_VARIABLE header_paths)
target_sources(treelet PUBLIC FILE_SET HEADERS
  BASE_DIRS "${PROJECT_SOURCE_DIR}/src" FILES ${header_paths})

target_link_libraries(treelet PUBLIC Threads::Threads)
target_compile_definitions(treelet PRIVATE TREELET_VERSION="${PROJECT_VERSION}")
if(TREELET_VALIDATE_STAGES)
  target_compile_definitions(treelet PUBLIC TREELET_VALIDATE_STAGES=1)
endif()

treelet_exact_floats(treelet PUBLIC)
treelet_sanitize(treelet PUBLIC)
treelet_warnings(treelet)
if(TREELET_HAS_CUDA)
  treelet_add_kernels(treelet)
endif()
