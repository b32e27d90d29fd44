# The test `headers_are_self_contained`: each public header compiles as the first include of a file
# of its own, and a second include of it changes nothing.

set(header_files)
foreach(header IN LISTS treelet_headers)
  string(MAKE_C_IDENTIFIER "${header}" stem)
  set(source "${PROJECT_BINARY_DIR}/header_test/${stem}.cpp")
  file(CONFIGURE OUTPUT "${source}" CONTENT "#include <@header@>\n#include <@header@>\n" @ONLY)
  list(APPEND header_files "${source}")
endforeach()

add_library(treelet_header_test OBJECT EXCLUDE_FROM_ALL ${header_files})
target_link_libraries(treelet_header_test PRIVATE treelet::treelet)
treelet_warnings(treelet_header_test)
if(NOT MSVC)
  target_compile_options(treelet_header_test PRIVATE -O0)
endif()

add_test(NAME headers_are_self_contained
  COMMAND "${CMAKE_COMMAND}" --build "${PROJECT_BINARY_DIR}" --target treelet_header_test)
set_tests_properties(headers_are_self_contained PROPERTIES RESOURCE_LOCK build_folder)
