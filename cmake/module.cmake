# SPDX-License-Identifier: GPL-3.0-or-later
# The native module penumbra_native, for the Python that the target Blender has; the add-on's zips; the wheel's files.

set(PENUMBRA_PYTHON "/usr/bin/python3" CACHE FILEPATH "The Python that the target Blender runs on")
set(folder ${CMAKE_SOURCE_DIR}/addon/penumbra)  # so that the add-on works from the source tree
if(SKBUILD)
  set(folder ${CMAKE_BINARY_DIR}/wheel)
endif()
set(PENUMBRA_MODULE_FOLDER ${folder} CACHE PATH "Where the native module goes")

# Of the interpreter that Blender has, which need not be the first one on the PATH.
if(NOT Python_EXECUTABLE AND EXISTS ${PENUMBRA_PYTHON})
  set(Python_EXECUTABLE ${PENUMBRA_PYTHON})
endif()
find_package(Python 3.10 REQUIRED COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.9 REQUIRED CONFIG)

# NO_EXTRAS: no link-time optimisation, which the hot loops in the core do not need.
file(GLOB PENUMBRA_BINDINGS CONFIGURE_DEPENDS native/python/*.cpp)
pybind11_add_module(penumbra_native MODULE NO_EXTRAS ${PENUMBRA_BINDINGS})
target_link_libraries(penumbra_native PRIVATE penumbra_core)
if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
  # Nothing to be seen but the init function: Blender has libraries of its own in the same process.
  file(WRITE ${CMAKE_BINARY_DIR}/exports.map "{ global: PyInit_penumbra_native; local: *; };\n")
  target_link_options(penumbra_native PRIVATE -Wl,--exclude-libs,ALL -Wl,--version-script,${CMAKE_BINARY_DIR}/exports.map)
  # An older CPU gets an error from the loader instead of dying of an illegal instruction.
  include(CheckLinkerFlag)
  check_linker_flag(CXX -Wl,-z,x86-64-v2 PENUMBRA_LINKER_MARKS_CPU)
  if(PENUMBRA_LINKER_MARKS_CPU AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_link_options(penumbra_native PRIVATE -Wl,-z,x86-64-v2)
  endif()
endif()
target_compile_definitions(penumbra_native PRIVATE
  PENUMBRA_VERSION="${PROJECT_VERSION}"
  PENUMBRA_BUILD="${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}, Embree ${embree_VERSION}, ${CMAKE_BUILD_TYPE}")
set_target_properties(penumbra_native PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PENUMBRA_MODULE_FOLDER})

# For Blender up to 4.1 and since: cmake --build --preset release --target zip
add_custom_target(zip
  COMMAND ${Python_EXECUTABLE} ${CMAKE_SOURCE_DIR}/addon/make_zip.py ${CMAKE_BINARY_DIR}
  DEPENDS penumbra_native
  COMMENT "The add-on as a legacy zip and as an extension"
  VERBATIM)

# The wheel (pyproject.toml), with type stubs made from the module's own signatures and documentation. Blender's
# libraries, if it was built for them, are found where they were.
if(SKBUILD)
  add_custom_command(TARGET penumbra_native POST_BUILD
    COMMAND ${CMAKE_COMMAND} -E env "PYTHONPATH=${PENUMBRA_MODULE_FOLDER}:$ENV{PYTHONPATH}"
      ${Python_EXECUTABLE} -m pybind11_stubgen penumbra_native --exit-code --output-dir ${PENUMBRA_MODULE_FOLDER}
    VERBATIM)
  set_target_properties(penumbra_native PROPERTIES INSTALL_RPATH "${PENUMBRA_BLENDER_LIBRARIES}")
  install(TARGETS penumbra_native DESTINATION .)
  install(FILES ${PENUMBRA_MODULE_FOLDER}/penumbra_native.pyi DESTINATION penumbra_native-stubs RENAME __init__.pyi)
endif()
