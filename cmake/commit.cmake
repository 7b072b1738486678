# Writes the header OUT with the commit of the tree SOURCE; it is touched only where that has changed.
# SPDX-License-Identifier: BSD-3-Clause
# usage: cmake -D SOURCE=... -D OUT=... -P commit.cmake
set(commit unknown)
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${SOURCE}/bench/commit.sh OUTPUT_VARIABLE told ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(told MATCHES "^[0-9a-f]+(-dirty)?$")
    set(commit ${told})
  endif()
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "#define SPALL_COMMIT \"${commit}\"\n" @ONLY)
