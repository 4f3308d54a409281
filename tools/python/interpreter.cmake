# lamella_find_python(PREFIX): sets PREFIX to an interpreter that has numpy, the headers of Python and those of pybind11,
# PREFIX_INCLUDES and PREFIX_SUFFIX to where the headers are and how modules end; PREFIX is empty where there is none.
#
# The first python3 on the path may be one of a version manager, without numpy: all are tried. LAMELLA_PYTHON names one.
set(LAMELLA_PYTHON "" CACHE FILEPATH "Python interpreter to build the Python package for (empty: the first that has numpy)")

function(lamella_find_python prefix)
  set(question "import numpy, os, sys, sysconfig
paths = [sysconfig.get_path('include')]
try:
    import pybind11
    paths.append(pybind11.get_include())
except ImportError:
    paths += [p for p in ('/usr/include', '/usr/local/include') if os.path.exists(p + '/pybind11/pybind11.h')][:1]
if not os.path.exists(paths[0] + '/Python.h') or len(paths) < 2:
    sys.exit(1)
print(';'.join(paths), end='|' + sysconfig.get_config_var('EXT_SUFFIX'))")
  set(candidates ${LAMELLA_PYTHON})
  if(NOT LAMELLA_PYTHON)
    file(TO_CMAKE_PATH "$ENV{PATH}" folders)
    list(TRANSFORM folders APPEND /python3 OUTPUT_VARIABLE candidates)
    list(APPEND candidates /usr/bin/python3)
    list(REMOVE_DUPLICATES candidates)
  endif()
  set(${prefix} "" PARENT_SCOPE)
  foreach(candidate ${candidates})
    if(NOT EXISTS ${candidate})
      continue()
    endif()
    execute_process(COMMAND ${candidate} -c "${question}" RESULT_VARIABLE failed OUTPUT_VARIABLE answer ERROR_QUIET)
    if(NOT failed)
      string(REGEX MATCH "^(.*)[|](.*)$" ignored "${answer}")
      set(${prefix} ${candidate} PARENT_SCOPE)
      set(${prefix}_INCLUDES "${CMAKE_MATCH_1}" PARENT_SCOPE)
      set(${prefix}_SUFFIX "${CMAKE_MATCH_2}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()
