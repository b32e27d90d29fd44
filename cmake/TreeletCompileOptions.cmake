# How treelet's own code is compiled: float semantics, warnings, sanitizers.

# Forbids the fusing of a * b + c into one rounding. Two triangles that share an edge must compute
# the same bits for it, or rays slip through between them; compilers that fuse do so per expression.
# PUBLIC for the library: its headers hold inline float code, and the linker keeps any one of the
# copies that the program's files compiled, perhaps the consumer's.
function(treelet_exact_floats target visibility)
  target_compile_options(${target} ${visibility}
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang,AppleClang>:-ffp-contract=off>"
    "$<$<COMPILE_LANG_AND_ID:CXX,IntelLLVM>:-ffp-contract=off;-fp-model=precise>"
    "$<$<COMPILE_LANG_AND_ID:CXX,MSVC>:/fp:precise>")
endfunction()

function(treelet_warnings target)
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang,AppleClang>:-Wall;-Wextra;-Wpedantic;-Wconversion;-Wno-sign-conversion;-Wshadow>"
    "$<$<COMPILE_LANG_AND_ID:CXX,MSVC>:/W4;/utf-8>")
endfunction()

# Every file of a program must agree on its sanitizers, so these are PUBLIC inside the build; an
# installed library does not pass them on.
function(treelet_sanitize target visibility)
  if(NOT TREELET_SANITIZE)
    return()
  endif()
  foreach(name IN LISTS TREELET_SANITIZE)
    if(NOT name MATCHES "^(address|undefined|thread)$")
      message(FATAL_ERROR "TREELET_SANITIZE: unknown sanitizer \"${name}\"; "
        "choose from address, undefined, thread")
    endif()
  endforeach()
  list(JOIN TREELET_SANITIZE "," names)
  # -g1: functions and lines, what their reports name. All of -g is a quarter of the compile time.
  target_compile_options(${target} ${visibility}
    "$<BUILD_INTERFACE:-fsanitize=${names};-fno-sanitize-recover=all;-fno-omit-frame-pointer;-g1>")
  target_link_options(${target} ${visibility} "$<BUILD_INTERFACE:-fsanitize=${names}>")
endfunction()
