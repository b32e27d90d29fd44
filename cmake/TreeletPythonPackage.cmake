# Sets `folders` to where a package of the Python that is first on PATH lies, or to nothing. The package
# itself is not imported: its folders are all that is wanted.
function(treelet_find_python_package package folders)
  set(${folders} "" PARENT_SCOPE)
  find_program(python NAMES "${Python_EXECUTABLE}" python3 python NO_CACHE)
  if(NOT python)
    return()
  endif()
  # A list, whose separator is Python's of statements.
  set(question "from importlib.util import find_spec"
    "print(*find_spec('${package}').submodule_search_locations, sep=';')")
  execute_process(COMMAND "${python}" -c "${question}"
    OUTPUT_VARIABLE answer OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failure)
  if(NOT failure)
    set(${folders} "${answer}" PARENT_SCOPE)
  endif()
endfunction()
