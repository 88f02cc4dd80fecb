# Debian packages of the parts, by `cpack` in the build folder: taut, libtaut0, libtaut-dev, python3-taut.
set(TAUT_MAINTAINER "The taut authors <taut@example.org>" CACHE STRING "Name and address in the packages")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_DEBIAN_PACKAGE_RELEASE 0taut1)
set(package_version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(doc ${CMAKE_CURRENT_BINARY_DIR}/doc)
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(changelog.in ${doc}/changelog.Debian @ONLY)
file(READ ${PROJECT_SOURCE_DIR}/LICENSE licence)
string(REGEX REPLACE "^MIT License\n\nCopyright[^\n]*\n\n" "" licence "${licence}")
string(REGEX REPLACE "\n$" "" licence "${licence}")
string(REPLACE "\n\n" "\n.\n" licence "${licence}")
string(REPLACE "\n" "\n " licence "${licence}")
configure_file(copyright.in ${doc}/copyright @ONLY)
execute_process(COMMAND gzip -9nf ${doc}/changelog.Debian)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME taut)
set(CPACK_PACKAGE_CONTACT ${TAUT_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL program library development)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# What each is called and needs beside what its files are linked with.
macro(taut_package component name section)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_PACKAGE_PRIORITY optional)
  install(FILES ${doc}/copyright ${doc}/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endmacro()
taut_package(program taut graphics)
taut_package(library libtaut0 libs)
taut_package(development libtaut-dev libdevel)
if(TAUT_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  taut_package(python python3-taut python)
endif()

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each has its own
set(about "taut simulates flexible connectors (ropes, chains, cords and hoses) between
bodies by several methods of the literature and one of its own, tells how far
each is from the exact solution, and renders films without a display.")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "simulator and renderer of ropes, chains and cords\n${about}\n\nThis package has the program, its scenes and models.")
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "simulation of ropes, chains and cords - shared library\n${about}\n\nThis package has the library of the methods.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "simulation of ropes, chains and cords - development files\n${about}\n\nThis package has headers, archives, and files for CMake and pkg-config.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "simulation of ropes, chains and cords - Python module\n${about}\n\nThis package has the module taut, which shows states and pictures as arrays of\nnumpy.")

# GL and FFmpeg are opened or started when they are needed.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "fonts-dejavu-core, fonts-lato, libegl1, libegl-mesa0, libgl1-mesa-dri")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "ffmpeg, gnuplot-nox | gnuplot, libosmesa6")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${TAUT_PYTHON_DEPENDS}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "taut (= ${package_version})")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libtaut0 (= ${package_version}), libeigen3-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "libassimp-dev, libdeflate-dev, libfmt-dev, libfreetype-dev, libjpeg-dev, libpng-dev, libsimbody-dev, libtomlplusplus-dev")

set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
file(WRITE ${doc}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${doc}/triggers)
file(WRITE ${doc}/libtaut0 "# The library is called after its room, the package after the project.
libtaut0: package-name-doesnt-match-sonames libtaut-sim0
# CPack writes the scripts.
libtaut0: maintscript-calls-ldconfig *
")
install(FILES ${doc}/libtaut0 DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides COMPONENT library)
include(CPack)
