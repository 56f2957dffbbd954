# SPDX-License-Identifier: GPL-3.0-or-later
# The target `embree`: the one that the target Blender has, or else the system's version 4, or 3.

set(PENUMBRA_BLENDER_LIBRARIES "" CACHE PATH
  "Folder of the libraries that a Blender not of the distribution brings (BLENDER/lib, site-packages/bpy/lib)")

if(NOT PENUMBRA_BLENDER_LIBRARIES)
  # A static Embree 4 of your own (see README.md beside this file) is found through embree_DIR.
  find_package(embree 4 QUIET CONFIG)
  if(NOT embree_FOUND)
    find_package(embree 3 REQUIRED CONFIG)
  endif()
  return()
endif()

# Blender ships no headers: take the system's, of the same major version.
find_path(PENUMBRA_EMBREE_HEADERS embree4/rtcore.h REQUIRED)
find_file(PENUMBRA_EMBREE_LIBRARY NAMES libembree4.so.4 libembree4.4.dylib
  PATHS ${PENUMBRA_BLENDER_LIBRARIES} NO_DEFAULT_PATH REQUIRED)
file(STRINGS ${PENUMBRA_EMBREE_HEADERS}/embree4/rtcore_config.h version REGEX "define RTC_VERSION_STRING")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" embree_VERSION "${version}")
add_library(embree SHARED IMPORTED)
set_target_properties(embree PROPERTIES
  IMPORTED_LOCATION ${PENUMBRA_EMBREE_LIBRARY}
  INTERFACE_INCLUDE_DIRECTORIES ${PENUMBRA_EMBREE_HEADERS}
  INTERFACE_LINK_OPTIONS -Wl,-rpath-link,${PENUMBRA_BLENDER_LIBRARIES})
