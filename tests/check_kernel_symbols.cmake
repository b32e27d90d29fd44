# Run by ctest: kernels for newer processors must leave no symbol that the linker could give to all
# files (core/lanes.inl). NM lists OBJECTS, the library's object files.

foreach(object IN LISTS OBJECTS)
  if(NOT object MATCHES "_(avx2|avx512)\\.cpp")
    continue()
  endif()
  execute_process(COMMAND "${NM}" -C "${object}"
    OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* [WVu] [^\n]*" shared "${symbols}")
  if(shared)
    message(SEND_ERROR "${object} leaves shared symbols:\n${shared}")
  endif()
  math(EXPR checked "${checked} + 1")
endforeach()
if(NOT checked)
  message(SEND_ERROR "no kernel among the objects")
endif()
