# SPDX-License-Identifier: GPL-3.0-or-later
# OpenImageIO of the target Blender, or else the system's. By hand: its own CMake files want everything that it was built
# with (Debian 12, 13, sid).

find_path(OPENIMAGEIO_INCLUDE OpenImageIO/texture.h REQUIRED)
if(PENUMBRA_BLENDER_LIBRARIES)
  file(GLOB OPENIMAGEIO_LIBRARY ${PENUMBRA_BLENDER_LIBRARIES}/libOpenImageIO.so*)
  file(GLOB OPENIMAGEIO_UTIL_LIBRARY ${PENUMBRA_BLENDER_LIBRARIES}/libOpenImageIO_Util.so*)
else()
  find_library(OPENIMAGEIO_LIBRARY OpenImageIO REQUIRED)
  find_library(OPENIMAGEIO_UTIL_LIBRARY OpenImageIO_Util REQUIRED)
endif()
