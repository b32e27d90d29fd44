# Whether the library's CUDA half is compiled, by which nvcc, and how. Sets TREELET_HAS_CUDA.
#
# An nvcc is looked for in CMAKE_CUDA_COMPILER, CUDACXX, CUDA_PATH and PATH. With TREELET_CUDA=ON the
# toolkit of PyPI serves as well, where the Python that is first on PATH has it installed.

include(TreeletPythonPackage)

set(TREELET_CUDA AUTO CACHE STRING
  "Compile the CUDA code: ON, OFF, or AUTO, which means where a CUDA toolkit is installed")
set_property(CACHE TREELET_CUDA PROPERTY STRINGS AUTO ON OFF)

set(oldest_nvcc 12.8)  # has C++20 and the scoped atomics __nv_atomic_*
set(oldest_cmake_for_cuda 3.26)  # earlier ones pass nvcc no -std=c++20 and do not know CUDA 13
set(toolkit_requirement "cuda-toolkit[nvcc,cccl]==13.0.*")  # as in pyproject.toml

# Sets `result` to the version of an nvcc, or to nothing when it does not run or is none.
function(treelet_nvcc_version nvcc result)
  set(${result} "" PARENT_SCOPE)
  execute_process(COMMAND "${nvcc}" --version
    OUTPUT_VARIABLE answer ERROR_QUIET RESULT_VARIABLE failure)
  if(NOT failure AND answer MATCHES "release ([0-9]+\\.[0-9]+)")
    set(${result} "${CMAKE_MATCH_1}" PARENT_SCOPE)
  endif()
endfunction()

# Sets `nvcc` to one that is new enough, or to nothing and `reason` to why.
function(treelet_find_nvcc nvcc reason)
  set(names nvcc)
  if(CMAKE_CUDA_COMPILER)
    set(names "${CMAKE_CUDA_COMPILER}")
  elseif(DEFINED ENV{CUDACXX})
    set(names "$ENV{CUDACXX}")
  endif()
  find_program(found NAMES ${names}
    HINTS ENV CUDA_PATH PATHS /usr/local/cuda /opt/cuda PATH_SUFFIXES bin NO_CACHE)
  set(${nvcc} "" PARENT_SCOPE)
  if(NOT found)
    set(${reason} "no ${names} was found" PARENT_SCOPE)
    return()
  endif()
  treelet_nvcc_version("${found}" version)
  if(version VERSION_LESS oldest_nvcc)
    set(${reason} "${found} is not the nvcc of CUDA ${oldest_nvcc} or later" PARENT_SCOPE)
    return()
  endif()
  set(${nvcc} "${found}" PARENT_SCOPE)
endfunction()

# Sets `folder` to where the toolkit of PyPI lies, or to nothing.
function(treelet_find_python_toolkit folder)
  set(${folder} "" PARENT_SCOPE)
  treelet_find_python_package(nvidia.cu13 candidates)
  foreach(candidate IN LISTS candidates)
    if(EXISTS "${candidate}/bin/nvcc" AND EXISTS "${candidate}/include/cccl")
      set(${folder} "${candidate}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()

# Links the toolkit of PyPI into `tree` the way CMake and nvcc want to see one. There, the libraries
# lie in lib and have no unversioned names; nvcc wants lib64, and takes its own folder as it was
# called, so that linking each program is enough to move it.
function(treelet_link_toolkit toolkit tree)
  file(REMOVE_RECURSE "${tree}")
  file(MAKE_DIRECTORY "${tree}/bin" "${tree}/lib64")
  foreach(folder IN ITEMS include nvvm)
    file(CREATE_LINK "${toolkit}/${folder}" "${tree}/${folder}" SYMBOLIC)
  endforeach()
  file(GLOB programs "${toolkit}/bin/*")
  file(GLOB libraries "${toolkit}/lib/lib*")
  foreach(file IN LISTS programs libraries)
    string(REPLACE "${toolkit}/lib/" "lib64/" name "${file}")
    string(REPLACE "${toolkit}/" "" name "${name}")
    file(CREATE_LINK "${file}" "${tree}/${name}" SYMBOLIC)
    if(name MATCHES "(.*\\.so)\\.[0-9.]+$")
      file(CREATE_LINK "${file}" "${tree}/${CMAKE_MATCH_1}" SYMBOLIC)
    endif()
  endforeach()
endfunction()

# Sets `nvcc` to the one to compile with, or to nothing and `reason` to why there will be no CUDA.
function(treelet_choose_nvcc nvcc reason)
  treelet_find_nvcc(found why)
  if(NOT found AND NOT TREELET_CUDA STREQUAL "AUTO")
    treelet_find_python_toolkit(toolkit)
    if(toolkit)
      set(found "${PROJECT_BINARY_DIR}/cuda-toolkit/bin/nvcc")
      treelet_link_toolkit("${toolkit}" "${PROJECT_BINARY_DIR}/cuda-toolkit")
    else()
      string(APPEND why ". Install a CUDA toolkit, or into the Python that is first on PATH:\n"
        "  python -m pip install \"${toolkit_requirement}\"")
    endif()
  endif()
  if(found AND CMAKE_VERSION VERSION_LESS oldest_cmake_for_cuda)
    set(found "")
    set(why "it needs CMake ${oldest_cmake_for_cuda} or later, not ${CMAKE_VERSION}: pip install cmake")
  endif()
  if(TREELET_SANITIZE)
    set(found "")
    set(why "the sanitizers of TREELET_SANITIZE do not go together with CUDA's driver")
  endif()
  set(${nvcc} "${found}" PARENT_SCOPE)
  set(${reason} "${why}" PARENT_SCOPE)
endfunction()

# How .cu files are compiled.
function(treelet_cuda_options target)
  set_target_properties(${target} PROPERTIES
    CUDA_STANDARD 20 CUDA_STANDARD_REQUIRED ON CUDA_EXTENSIONS OFF)
  # Host and device must round alike, or their trees would differ: neither fuses a * b + c.
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANGUAGE:CUDA>:-fmad=false;--expt-relaxed-constexpr>"
    "$<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<NOT:$<CXX_COMPILER_ID:MSVC>>>:-Xcompiler=-ffp-contract=off,-Wall,-Wextra,-Wconversion,-Wno-sign-conversion,-Wshadow>")
endfunction()

# The kernels are an object library: so they can be compiled alone.
function(treelet_add_kernels target)
  file(GLOB kernels CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/treelet/*/*.cu")
  add_library(treelet_kernels OBJECT ${kernels})
  treelet_cuda_options(treelet_kernels)
  set_target_properties(treelet_kernels PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(treelet_kernels PRIVATE "${PROJECT_SOURCE_DIR}/src")
  target_compile_definitions(treelet_kernels PRIVATE
    "$<TARGET_PROPERTY:${target},INTERFACE_COMPILE_DEFINITIONS>")
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:treelet_kernels>)
  # A static cudart loads on machines without a driver, too.
  target_link_libraries(${target} PRIVATE $<LINK_ONLY:CUDA::cudart_static>)
endfunction()

# The tests that the emulator runs on the host, as a program for the GPU; not for ctest, which also
# runs where there is none. Those with kernels of their own are compiled through a .cu file.
function(treelet_add_gpu_tests support)
  if(NOT TREELET_HAS_CUDA)
    return()
  endif()
  add_executable(treelet_gpu_tests)
  file(GLOB tests CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tests/cuda/*_test.cpp")
  foreach(test IN LISTS tests)
    file(STRINGS "${test}" device_headers REGEX "#include <treelet/.*\\.cuh>")
    if(device_headers)
      get_filename_component(name "${test}" NAME_WE)
      set(wrapper "${PROJECT_BINARY_DIR}/gpu_tests/${name}.cu")
      file(CONFIGURE OUTPUT "${wrapper}" CONTENT "#include \"@test@\"\n" @ONLY)
      set(test "${wrapper}")
    endif()
    target_sources(treelet_gpu_tests PRIVATE "${test}")
  endforeach()
  target_link_libraries(treelet_gpu_tests PRIVATE ${support})
  treelet_warnings(treelet_gpu_tests)
  treelet_cuda_options(treelet_gpu_tests)
endfunction()

set(TREELET_HAS_CUDA OFF)
string(TOUPPER "${TREELET_CUDA}" TREELET_CUDA)
if(NOT TREELET_CUDA)
  return()
endif()

treelet_choose_nvcc(chosen_nvcc reason)
if(NOT chosen_nvcc)
  if(NOT TREELET_CUDA STREQUAL "AUTO")
    message(FATAL_ERROR "TREELET_CUDA=${TREELET_CUDA}, but ${reason}")
  endif()
  message(STATUS "treelet: without CUDA: ${reason}")
  return()
endif()

set(CMAKE_CUDA_COMPILER "${chosen_nvcc}")
if(NOT CMAKE_CUDA_HOST_COMPILER AND NOT DEFINED ENV{CUDAHOSTCXX} AND NOT MSVC)
  set(CMAKE_CUDA_HOST_COMPILER "${CMAKE_CXX_COMPILER}")
endif()
if(NOT CMAKE_CUDA_ARCHITECTURES AND NOT DEFINED ENV{CUDAARCHS})
  # Turing to Hopper; the last is also kept as PTX, which the driver compiles for later ones.
  set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90)
endif()
enable_language(CUDA)
find_package(CUDAToolkit REQUIRED)
set(TREELET_HAS_CUDA ON)
message(STATUS "treelet: with CUDA ${CMAKE_CUDA_COMPILER_VERSION} for ${CMAKE_CUDA_ARCHITECTURES}")
