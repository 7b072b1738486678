# Writes the files of cases/materials into a list of texts, for src/scene/material_library.cpp.
# SPDX-License-Identifier: BSD-3-Clause
file(GLOB materials CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/cases/materials/*.toml)
set(lines "")
foreach(material IN LISTS materials)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${material})
  get_filename_component(name ${material} NAME_WE)
  file(READ ${material} text)
  string(APPEND lines "{\"${name}\", R\"toml(${text})toml\"},\n")
endforeach()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/material_library.inc CONTENT "${lines}" @ONLY)
