# Debian packages by CPack (scripts/package): sprout (programs, units), sprout-common (presets, which the
# libraries and the Python module need, too, and nothing else of sprout's), libsprout0.2 (shared
# libraries), python3-sprout, libsprout-dev and sprout-doc. Included last.
#
# What only a Debian package has, units, /etc/sprout and the like, is left out of `cmake --install`.
set(SPROUT_MAINTAINER "Sprout maintainers <maintainers@sprout.invalid>"
    CACHE STRING "Maintainer of the Debian packages")
set(debian "${PROJECT_SOURCE_DIR}/scripts/debian")
set(generated "${PROJECT_BINARY_DIR}/debian")
set(soversion "${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
get_property(programs GLOBAL PROPERTY SPROUT_PROGRAMS)
get_property(stages GLOBAL PROPERTY SPROUT_STAGES)

# Man pages and completion, from what --help says. A foreign program cannot be asked.
if(NOT CMAKE_CROSSCOMPILING)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(manual)
  foreach(program IN LISTS programs)
    set(page "${PROJECT_BINARY_DIR}/manual/man1/${program}.1.gz")
    set(completion "${PROJECT_BINARY_DIR}/manual/completions/${program}")
    add_custom_command(
      OUTPUT "${page}" "${completion}"
      COMMAND "${Python3_EXECUTABLE}" "${debian}/make_manual" $<TARGET_FILE:${program}>
              "${PROJECT_VERSION}" "${page}" "${completion}"
      DEPENDS ${program} "${debian}/make_manual"
      VERBATIM)
    list(APPEND manual "${page}" "${completion}")
  endforeach()
  add_custom_target(manual ALL DEPENDS ${manual})
  list(APPEND packaged manual)
  install(DIRECTORY "${PROJECT_BINARY_DIR}/manual/man1" DESTINATION "${CMAKE_INSTALL_MANDIR}")
  install(DIRECTORY "${PROJECT_BINARY_DIR}/manual/completions"
          DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion")
endif()

# What scripts/package builds, which is all but the tests.
foreach(target ${programs} sprout_shared_pipeline sprout_shared_log sprout_lcmtypes_c
               sprout_lcmtypes_java sprout_python)
  if(TARGET ${target})
    list(APPEND packaged ${target})
  endif()
endforeach()
add_custom_target(package_files DEPENDS ${packaged})

# Units: one of each stage, the target that wants them all, the recorder, the stages in one process and
# the door to ROS 2 for who enables them, and the route of the messages. What is special about one stands in NAME.unit and NAME.service.
function(sprout_unit name)
  set(unit_lines)
  set(service_lines)
  if(EXISTS "${debian}/sprout-${name}.unit")
    file(READ "${debian}/sprout-${name}.unit" unit_lines)
  endif()
  if(EXISTS "${debian}/sprout-${name}.service")
    file(READ "${debian}/sprout-${name}.service" service_lines)
  endif()
  configure_file("${debian}/sprout-stage.service.in" "${generated}/units/sprout-${name}.service" @ONLY)
endfunction()
foreach(name IN LISTS stages ITEMS record pipeline ros2 selfcalibrate temporal)
  if(TARGET sprout-${name})
    sprout_unit(${name})
  endif()
endforeach()
list(TRANSFORM stages PREPEND "sprout-" OUTPUT_VARIABLE units)
list(TRANSFORM units APPEND ".service")
list(JOIN units " " units)
configure_file("${debian}/sprout.target.in" "${generated}/units/sprout.target" @ONLY)
configure_file("${debian}/sprout-network.service" "${generated}/units" COPYONLY)
foreach(script postinst prerm postrm)
  configure_file("${debian}/${script}.in" "${generated}/${script}" @ONLY)
endforeach()

# Only in packages.
set(package_only COMPONENT sprout EXCLUDE_FROM_ALL)
install(DIRECTORY "${generated}/units/" DESTINATION lib/systemd/system ${package_only})
install(PROGRAMS "${debian}/loopback-route" DESTINATION lib/sprout ${package_only})
install(FILES "${debian}/50-sprout.conf" DESTINATION lib/sysctl.d ${package_only})
install(FILES "${debian}/sprout.textproto" "${debian}/environment" DESTINATION /etc/sprout
        ${package_only})
install(FILES README.md common/config/sprout.proto common/measure/target_limits.proto common/rig/rig.proto
        DESTINATION share/doc/sprout
        ${package_only})

# Changelogs as Debian wants them: the upstream one, and a short one of the package, whose date is
# that of the newest commit.
set(CPACK_DEBIAN_VERSION "${PROJECT_VERSION}-1")
execute_process(
  COMMAND git -C "${PROJECT_SOURCE_DIR}" log -1 --format=%cD
  OUTPUT_VARIABLE date
  OUTPUT_STRIP_TRAILING_WHITESPACE
  ERROR_QUIET)
if(NOT date)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
configure_file("${debian}/changelog.in" "${generated}/changelog.Debian" @ONLY)
set(overrides share/lintian/overrides)
install(FILES "${debian}/lintian/sprout" DESTINATION ${overrides} ${package_only})
install(FILES "${debian}/lintian/sprout-common" DESTINATION ${overrides} COMPONENT common
        EXCLUDE_FROM_ALL)
install(FILES "${debian}/lintian/sprout-doc" DESTINATION ${overrides} COMPONENT doc EXCLUDE_FROM_ALL)
install(FILES "${debian}/lintian/libsprout" DESTINATION ${overrides} RENAME libsprout${soversion}
        COMPONENT libsprout EXCLUDE_FROM_ALL)
install(FILES "${debian}/lintian/python3-sprout" DESTINATION ${overrides} COMPONENT python
        EXCLUDE_FROM_ALL)
install(FILES "${debian}/lintian/libsprout-dev" DESTINATION ${overrides} COMPONENT dev
        EXCLUDE_FROM_ALL)

# The documents with their pictures and examples, in their folders, so that links between them work.
install(DIRECTORY common lcmtypes logs services tests DESTINATION share/doc/sprout-doc
        COMPONENT doc EXCLUDE_FROM_ALL
        FILES_MATCHING PATTERN "*.md" PATTERN "*.jpg" PATTERN "*.png" PATTERN "*.svg"
        PATTERN "*.proto" PATTERN "example/*" PATTERN "examples/java/*"
        PATTERN "python/examples/*")
install(FILES README.md CONTRIBUTING.md DESTINATION share/doc/sprout-doc COMPONENT doc
        EXCLUDE_FROM_ALL)
install(FILES scripts/debian/README.md DESTINATION share/doc/sprout-doc/scripts/debian
        COMPONENT doc EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sprout)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_CONTACT "${SPROUT_MAINTAINER}")
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL sprout common libsprout dev doc)
if(TARGET sprout_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PRE_BUILD_SCRIPTS "${debian}/finish_files.cmake")
set(CPACK_SPROUT_DEBIAN_FILES "${generated}/changelog.Debian" "${debian}/copyright"
                              "${PROJECT_SOURCE_DIR}/CHANGELOG.md")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEBUGINFO_PACKAGE ON) # strips the programs
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(this_version "(= ${CPACK_DEBIAN_VERSION})")
set(CPACK_DEBIAN_SPROUT_PACKAGE_NAME sprout)
set(CPACK_DEBIAN_SPROUT_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SPROUT_PACKAGE_DEPENDS
    "sprout-common ${this_version}, iproute2, init-system-helpers (>= 1.52)")
set(CPACK_DEBIAN_SPROUT_PACKAGE_RECOMMENDS "liblcm-bin")
set(CPACK_DEBIAN_SPROUT_PACKAGE_SUGGESTS "sprout-doc")
set(CPACK_DEBIAN_SPROUT_PACKAGE_CONTROL_EXTRA
    "${generated}/postinst;${generated}/prerm;${generated}/postrm;${debian}/conffiles")
set(CPACK_COMPONENT_SPROUT_DESCRIPTION
    "What a range sensor (time-of-flight camera or lidar) and a rectified stereo
pair see becomes one depth map of the stereo pair's resolution: a graph of
small processes that talk over LCM, kept running by systemd (sprout.target),
and tools to calibrate, record, replay and evaluate.")

set(CPACK_DEBIAN_COMMON_PACKAGE_NAME sprout-common)
set(CPACK_DEBIAN_COMMON_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_COMMON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_COMPONENT_COMMON_DESCRIPTION
    "Presets: the parameters that programs, libraries and the Python module of
Sprout know by name.")

set(CPACK_DEBIAN_LIBSPROUT_PACKAGE_NAME libsprout${soversion})
set(CPACK_DEBIAN_LIBSPROUT_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBSPROUT_PACKAGE_CONTROL_EXTRA "${debian}/libsprout/triggers")
set(CPACK_DEBIAN_LIBSPROUT_PACKAGE_DEPENDS "sprout-common ${this_version}")
set(CPACK_COMPONENT_LIBSPROUT_DESCRIPTION
    "Shared libraries: the processing chain as one class, and a reader and writer
of LCM logs.")

if(TARGET sprout_python)
  # The extension works with the one minor version of Python that it was built for.
  math(EXPR python_next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-sprout)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "sprout-common ${this_version}, python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${python_next}), python3-numpy"
  )
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-open3d, sprout-doc")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${debian}/python/prerm")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION
    "Module sprout for Python: depth of NumPy arrays, the frames of logs and of
the running graph, stages in Python, and the message types.")
endif()

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsprout-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libsprout${soversion} ${this_version}, liblcm-dev, liblcm-bin, libopencv-dev, libeigen3-dev, libexpected-dev, libprotobuf-dev"
)
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "liblcm-java, python3-sprout")
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "Development files: headers, find_package(sprout), pkg-config, and the LCM
message types with their bindings for C++, C and Java.")

set(CPACK_DEBIAN_DOC_PACKAGE_NAME sprout-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
set(CPACK_COMPONENT_DOC_DESCRIPTION
    "Documents: what each program does, its messages, parameters and limits, what
was measured, and example programs.")
include(CPack)
