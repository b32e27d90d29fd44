# The extension module treelet._core and its type stub.

find_package(Python 3.10 REQUIRED
  COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
execute_process(
  COMMAND "${Python_EXECUTABLE}" -m nanobind --cmake_dir
  OUTPUT_VARIABLE nanobind_dir OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
find_package(nanobind CONFIG REQUIRED PATHS "${nanobind_dir}" NO_DEFAULT_PATH)

file(GLOB binding_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/python/bindings/*.cpp")

# nanobind's split mode: its compiled half comes from the package nanobind-backend at run time.
# Only so does one wheel (stable ABI of Python 3.10) serve 3.10 and all later versions: linked in,
# nanobind needs 3.12 for that, so 3.10 and 3.11 would want a wheel each and twice the build time.
# Outside of a wheel it may be linked in: a machine that only tests need not have that package.
execute_process(COMMAND "${Python_EXECUTABLE}" -c "import nanobind_backend"
  OUTPUT_QUIET ERROR_QUIET RESULT_VARIABLE lacks_backend)
set(nanobind_mode BACKEND_MODULE nanobind_backend)
if(lacks_backend AND NOT DEFINED SKBUILD)
  set(nanobind_mode NB_STATIC)
endif()
nanobind_add_module(_core
  ${nanobind_mode}
  NOMINSIZE  # inlined parts of the library should be as fast here as in the library
  NB_SUPPRESS_WARNINGS
  ${binding_sources})
target_link_libraries(_core PRIVATE treelet::treelet)
# The library's symbols stay inside the module: another module may carry another treelet.
target_link_options(_core PRIVATE "$<$<PLATFORM_ID:Linux>:LINKER:--exclude-libs,ALL>")
target_compile_definitions(_core PRIVATE TREELET_VERSION="${PROJECT_VERSION}")
treelet_warnings(_core)

nanobind_add_stub(_core_stub
  MODULE _core
  OUTPUT "${PROJECT_BINARY_DIR}/_core.pyi"
  PYTHON_PATH "$<TARGET_FILE_DIR:_core>"
  DEPENDS _core)

install(TARGETS _core LIBRARY DESTINATION treelet COMPONENT python)
install(FILES "${PROJECT_BINARY_DIR}/_core.pyi" DESTINATION treelet COMPONENT python)
