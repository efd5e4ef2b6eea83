# Debian packages by cpack: the program, the library for others' C++, the Python module. Parts that name no component belong
# to the program.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME slicemorph)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "slicemorph maintainers <maintainers@slicemorph.invalid>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_COMPONENTS_ALL program development)
if(TARGET slicemorph_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME slicemorph)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "volumetric morphing of OpenVDB grids, meshes and scans
 Turns one volume into another, or blends several: cuts each into oriented slices, matches the contours on them, and
 rebuilds the in-betweens as VDB level sets, smoke with all its grids, label maps, scans or meshes.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS ffmpeg)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libslicemorph-dev)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "library that morphs volumes - for C++ programs
 Headers, archives and a CMake package: slicemorph::engine morphs OpenVDB grids, slicemorph::io reads and writes files.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# What slicemorphConfig.cmake looks for, and the plug-ins, which lie in the program's package.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "slicemorph (= ${PROJECT_VERSION}), libopenvdb-dev, libboost-iostreams-dev, libtbb-dev, libimath-dev, libopenexr-dev, libpng-dev, zlib1g-dev, libtinygltf-dev, libdraco-dev, libmeshoptimizer-dev, liblog4cplus-dev, libnifti2-dev, libznz-dev, libbz2-dev")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-slicemorph)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "volumetric morphing of OpenVDB grids, meshes and scans - for Python
 The module slicemorph: morphs of numpy arrays, images, OpenVDB grids and meshes, with all options of the program.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
# The plug-ins lie in the program's package.
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "slicemorph (= ${PROJECT_VERSION}), python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-nibabel, python3-openvdb, python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/tools/packages/python/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
