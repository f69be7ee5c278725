# What `cmake --install` puts where, for other people's programs: find_package(sprout) gives
# sprout::pipeline, sprout::log and sprout::lcmtypes. Programs install themselves, see
# sprout_service(). Included last, when all targets are there.

# The shared libraries export namespace sprout only. What Eigen and CGAL leave in them stays inside:
# a program may use the same templates with other flags.
function(sprout_shared_library name)
  cmake_parse_arguments(arg "" "" "OBJECTS_OF;PRIVATE;PUBLIC" ${ARGN})
  set(objects)
  foreach(library IN LISTS arg_OBJECTS_OF)
    list(APPEND objects $<TARGET_OBJECTS:${library}>)
  endforeach()
  add_library(sprout_shared_${name} SHARED ${objects})
  target_link_libraries(sprout_shared_${name} PRIVATE ${arg_PRIVATE} PUBLIC ${arg_PUBLIC})
  set(exports "${PROJECT_SOURCE_DIR}/scripts/cmake/exports.map")
  target_link_options(sprout_shared_${name} PRIVATE "LINKER:--version-script=${exports}"
                      "LINKER:--as-needed")
  # A sanitizer's functions come from the program.
  if(NOT SPROUT_SANITIZE)
    target_link_options(sprout_shared_${name} PRIVATE "LINKER:--no-undefined")
  endif()
  # Before 1.0 every minor version may change the interface.
  set_target_properties(
    sprout_shared_${name}
    PROPERTIES OUTPUT_NAME sprout_${name} EXPORT_NAME ${name} LINKER_LANGUAGE CXX
               VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
               LINK_DEPENDS "${exports}")
  target_include_directories(sprout_shared_${name}
                             INTERFACE "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  target_compile_features(sprout_shared_${name} INTERFACE cxx_std_20)
  install(TARGETS sprout_shared_${name} EXPORT sprout
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT libsprout NAMELINK_COMPONENT dev)
endfunction()

# Installs headers of the source tree and all of ours that they include as <sprout/NAME.h>.
function(sprout_install_headers)
  set(todo ${ARGN})
  set(seen)
  while(todo)
    list(POP_FRONT todo header)
    if(header IN_LIST seen OR header MATCHES "[.]pb[.]h$")
      continue()
    endif()
    list(APPEND seen "${header}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${header}")
    file(READ "${PROJECT_SOURCE_DIR}/${header}" text)
    string(REGEX MATCHALL "#include \"[^\"]+\"" includes "${text}")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "#include \"(.*)\"" "\\1" path "${include}")
      list(APPEND todo "${path}")
    endforeach()
    string(REGEX REPLACE "#include \"[^\"]*/([^\"/]+)\"" "#include <sprout/\\1>" text "${text}")
    get_filename_component(name "${header}" NAME)
    if(name IN_LIST names)
      message(FATAL_ERROR "two headers to install are called ${name}")
    endif()
    list(APPEND names "${name}")
    file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/include/sprout/${name}" CONTENT "${text}" @ONLY)
  endwhile()
  install(DIRECTORY "${PROJECT_BINARY_DIR}/include/sprout"
          DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT dev)
endfunction()

sprout_shared_library(
  pipeline
  OBJECTS_OF sprout_core sprout_config_proto sprout_config sprout_confidence_model_proto sprout_geometry sprout_depth_filter
             sprout_inputs sprout_refine sprout_triangulation sprout_prior sprout_grow sprout_temporal sprout_pipeline
  PRIVATE CGAL::CGAL fmt::fmt PkgConfig::hwy opencv_imgproc opencv_calib3d opencv_features2d PkgConfig::xxhash
  PUBLIC opencv_core Eigen3::Eigen tl::expected protobuf::libprotobuf)
sprout_shared_library(
  log
  OBJECTS_OF sprout_logfile
  PRIVATE sprout_core
  PUBLIC tl::expected)
sprout_install_headers(
  services/pipeline/pipeline.h common/geometry/projection.h common/logfile/log_reader.h
  common/logfile/log_writer.h)
install(FILES "${PROJECT_BINARY_DIR}/common/generated/common/config/sprout.pb.h"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/sprout" COMPONENT dev)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/sprout")
install(EXPORT sprout NAMESPACE sprout:: FILE sproutTargets.cmake DESTINATION "${package_dir}"
        COMPONENT dev)
include(CMakePackageConfigHelpers)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/sproutConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_SOURCE_DIR}/scripts/cmake/sproutConfig.cmake"
              "${PROJECT_SOURCE_DIR}/scripts/cmake/FindLCM.cmake"
              "${PROJECT_BINARY_DIR}/sproutConfigVersion.cmake"
        DESTINATION "${package_dir}" COMPONENT dev)
file(RELATIVE_PATH prefix_from_pkgconfig "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file("${PROJECT_SOURCE_DIR}/scripts/cmake/sprout.pc.in" "${PROJECT_BINARY_DIR}/sprout.pc"
               @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/sprout.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
        COMPONENT dev)
