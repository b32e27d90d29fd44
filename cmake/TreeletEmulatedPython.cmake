# The target treelet_emulated_python: the Python package with the emulator in place of CUDA, so that
# arrays in "device" memory can be tested without a GPU. Not part of any other target.

find_package(Python 3.10 COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
if(NOT Python_FOUND)
  return()
endif()
execute_process(
  COMMAND "${Python_EXECUTABLE}" -m nanobind --cmake_dir
  OUTPUT_VARIABLE nanobind_dir OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE no_nanobind)
if(no_nanobind)
  return()
endif()
find_package(nanobind CONFIG REQUIRED PATHS "${nanobind_dir}" NO_DEFAULT_PATH)

file(GLOB binding_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/python/bindings/*.cpp")
set(package "${PROJECT_BINARY_DIR}/emulated/treelet")
nanobind_add_module(treelet_emulated_core NB_STATIC NOMINSIZE NB_SUPPRESS_WARNINGS ${binding_sources})
set_target_properties(treelet_emulated_core PROPERTIES
  EXCLUDE_FROM_ALL ON
  OUTPUT_NAME _core
  LIBRARY_OUTPUT_DIRECTORY "${package}")
target_link_libraries(treelet_emulated_core PRIVATE treelet_emulated treelet::treelet)
target_compile_definitions(treelet_emulated_core PRIVATE TREELET_VERSION="${PROJECT_VERSION}")

# The package's own files stay where they are: what is edited is what is tested.
add_custom_target(treelet_emulated_python
  COMMAND "${CMAKE_COMMAND}"
    "-DFROM=${PROJECT_SOURCE_DIR}/python/treelet" "-DTO=${package}"
    -P "${CMAKE_CURRENT_LIST_DIR}/link_package.cmake"
  DEPENDS treelet_emulated_core)
