# Finds LCM: its own CMake package (1.4 and later) if there is one, else header, library and lcm-gen
# (Debian's 1.3.1 has no CMake package, and its pkg-config file asks for GLib's development files).
#
# Defines the target LCM::lcm, the variable LCM_GEN (path of lcm-gen) and LCM_FOUND.

find_package(lcm CONFIG QUIET)
if(lcm_FOUND)
  if(TARGET lcm::lcm AND NOT TARGET LCM::lcm)
    add_library(LCM::lcm INTERFACE IMPORTED)
    target_link_libraries(LCM::lcm INTERFACE lcm::lcm)
  endif()
  if(TARGET lcm::lcm-gen)
    get_target_property(LCM_GEN lcm::lcm-gen LOCATION)
  endif()
  get_target_property(LCM_INCLUDE_DIR lcm::lcm INTERFACE_INCLUDE_DIRECTORIES)
  set(LCM_LIBRARY lcm::lcm)
  set(LCM_VERSION "${lcm_VERSION}")
else()
  find_path(LCM_INCLUDE_DIR lcm/lcm.h)
  find_library(LCM_LIBRARY lcm)
endif()
if(NOT LCM_GEN)
  find_program(LCM_GEN lcm-gen)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  LCM
  REQUIRED_VARS LCM_LIBRARY LCM_INCLUDE_DIR LCM_GEN
  VERSION_VAR LCM_VERSION
  REASON_FAILURE_MESSAGE "Debian: apt-get install liblcm-dev liblcm-bin (scripts/setup does it)")

if(LCM_FOUND AND NOT TARGET LCM::lcm)
  add_library(LCM::lcm UNKNOWN IMPORTED)
  set_target_properties(LCM::lcm PROPERTIES IMPORTED_LOCATION "${LCM_LIBRARY}"
                                            INTERFACE_INCLUDE_DIRECTORIES "${LCM_INCLUDE_DIR}")
endif()
mark_as_advanced(LCM_INCLUDE_DIR LCM_LIBRARY LCM_GEN)
