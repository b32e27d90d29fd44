# CUDA kernels without a GPU: `treelet_emulator` runs them on the host (tests/emulator/README.md), and
# `treelet_emulated` is the library's .cu files compiled as C++ with its headers.

set(emulator_folder "${PROJECT_SOURCE_DIR}/tests/emulator")

file(GLOB emulator_sources CONFIGURE_DEPENDS "${emulator_folder}/runtime/*.cpp")
add_library(treelet_emulator STATIC ${emulator_sources})
target_include_directories(treelet_emulator
  SYSTEM INTERFACE "${emulator_folder}/include"
  PRIVATE "${emulator_folder}/include" "${emulator_folder}/runtime")
target_compile_features(treelet_emulator PUBLIC cxx_std_20)
set_target_properties(treelet_emulator PROPERTIES POSITION_INDEPENDENT_CODE ON)  # also for Python
target_link_libraries(treelet_emulator PUBLIC Threads::Threads ${CMAKE_DL_LIBS})
treelet_exact_floats(treelet_emulator PUBLIC)
treelet_sanitize(treelet_emulator PUBLIC)
treelet_warnings(treelet_emulator)

# The engine tells ThreadSanitizer of its fibers; its own accesses are none of those to be checked.
if("thread" IN_LIST TREELET_SANITIZE)
  target_compile_definitions(treelet_emulator PRIVATE TREELET_EMULATOR_TSAN=1)
  foreach(name IN ITEMS context engine fence report stack_switch symbol_name warp_collectives)
    set_source_files_properties("${emulator_folder}/runtime/${name}.cpp"
      TARGET_DIRECTORY treelet_emulator
      PROPERTIES COMPILE_OPTIONS "-fno-sanitize=thread")
  endforeach()
endif()

# Compiles .cu files as C++ into a target that it makes.
function(treelet_emulate target)
  add_library(${target} OBJECT ${ARGN})
  set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES LANGUAGE CXX)
  target_link_libraries(${target} PUBLIC treelet_emulator treelet::treelet)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  treelet_warnings(${target})
  target_compile_options(${target} PRIVATE -Wno-unknown-pragmas)  # #pragma unroll
endfunction()

# Objects, not an archive: they are linked first, so that of treelet's archive the members which stand
# in for them in builds without CUDA (x_no_cuda.cpp) are never pulled in.
file(GLOB cuda_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/treelet/*/*.cu")
if(cuda_sources)
  treelet_emulate(treelet_emulated ${cuda_sources})
else()
  add_library(treelet_emulated INTERFACE)
  target_link_libraries(treelet_emulated INTERFACE treelet_emulator treelet::treelet)
endif()

# The tests `planted.x.*`: what a sanitizer says of a program with a bug, and of the same one mended.
function(treelet_add_planted_bugs message)
  foreach(name IN LISTS ARGN)
    set(program treelet_planted_${name})
    add_executable(${program} "${emulator_folder}/planted/${name}.cpp")
    target_link_libraries(${program} PRIVATE treelet_emulator)
    treelet_warnings(${program})
    foreach(seed RANGE 3)
      add_test(NAME planted.${name}.${seed} COMMAND ${program} planted ${seed})
      add_test(NAME planted.${name}.${seed}.mended COMMAND ${program} mended ${seed})
      set_tests_properties(planted.${name}.${seed} PROPERTIES PASS_REGULAR_EXPRESSION "${message}")
      set_tests_properties(planted.${name}.${seed}.mended PROPERTIES
        FAIL_REGULAR_EXPRESSION "Sanitizer")
      set_tests_properties(planted.${name}.${seed} planted.${name}.${seed}.mended PROPERTIES
        LABELS emulator TIMEOUT 60 ENVIRONMENT "TSAN_OPTIONS=halt_on_error=1 atexit_sleep_ms=0")
    endforeach()
  endforeach()
endfunction()

function(treelet_add_sanitizer_tests)
  if("thread" IN_LIST TREELET_SANITIZE)
    treelet_add_planted_bugs("ThreadSanitizer: data race"
      missing_acquire_fence missing_release_fence missing_syncthreads missing_syncwarp
      race_between_blocks)
  endif()
  if("address" IN_LIST TREELET_SANITIZE)
    treelet_add_planted_bugs("AddressSanitizer|index [0-9]+ out of bounds"
      global_overrun host_reads_device_memory shared_overrun stack_overrun use_after_free)
  endif()
endfunction()
