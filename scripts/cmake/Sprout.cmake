# How every library, service and test of Sprout is built: one helper each.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
include(GNUInstallDirs)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}")
# What the installed shared libraries are made of is what the programs are made of.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

add_library(sprout_options INTERFACE)
# Eigen and fused multiply-adds, see below; Eigen is on no hot path here.
target_compile_definitions(sprout_options INTERFACE EIGEN_DONT_VECTORIZE)
target_include_directories(sprout_options INTERFACE "${PROJECT_SOURCE_DIR}")
target_compile_options(
  sprout_options
  INTERFACE -Wall -Wextra -Wconversion -Wshadow
            # GCC 12 sees uninitialised members in every move of a std::variant.
            $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
            # Fused multiply-add rounds once where two instructions round twice: without this flag
            # the same input gives other bytes on CPUs that have it.
            -ffp-contract=off
            # No function of ours is ever replaced at run time, so the compiler may inline it.
            -fno-semantic-interposition $<$<BOOL:${SPROUT_WERROR}>:-Werror>)
if(SPROUT_SANITIZE)
  target_compile_options(sprout_options INTERFACE -fsanitize=${SPROUT_SANITIZE}
                                                  -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(sprout_options INTERFACE -fsanitize=${SPROUT_SANITIZE})
endif()

# Every library that `target` links, directly or not, lands in `result`.
function(sprout_link_closure target result)
  set(seen)
  set(todo ${target})
  while(todo)
    list(POP_FRONT todo next)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" next "${next}")
    if(next IN_LIST seen)
      continue()
    endif()
    list(APPEND seen "${next}")
    if(TARGET ${next})
      foreach(property LINK_LIBRARIES INTERFACE_LINK_LIBRARIES)
        get_target_property(links ${next} ${property})
        if(links)
          list(APPEND todo ${links})
        endif()
      endforeach()
    endif()
  endwhile()
  set(${result} "${seen}" PARENT_SCOPE)
endfunction()

# sprout_library(NAME SOURCES ... [DEPS ...]): static library sprout_NAME.
function(sprout_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS" ${ARGN})
  add_library(sprout_${name} STATIC ${arg_SOURCES})
  target_link_libraries(sprout_${name} PUBLIC sprout_options ${arg_DEPS})
endfunction()

# sprout_stage_library(NAME ...): as sprout_library, for a stage. A stage knows no messaging: the
# configuration fails when LCM is anywhere in what it links.
function(sprout_stage_library name)
  sprout_library(${name} ${ARGN})
  sprout_link_closure(sprout_${name} closure)
  foreach(library IN LISTS closure)
    if(library MATCHES "^(LCM::|lcm|sprout_(lcmtypes|messages|bus|app)$)")
      message(FATAL_ERROR "stage library sprout_${name} links ${library}; a stage knows no messaging")
    endif()
  endforeach()
endfunction()

# sprout_service(NAME SOURCES ... [DEPS ...]): program sprout-NAME in bin/.
function(sprout_service name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(sprout-${name} ${arg_SOURCES})
  target_link_libraries(sprout-${name} PRIVATE sprout_options ${arg_DEPS})
  install(TARGETS sprout-${name} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endfunction()

# sprout_test(NAME SOURCES ... [DEPS ...]): GoogleTest program NAME_test, each TEST one ctest entry.
function(sprout_test name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name}_test ${arg_SOURCES})
  target_link_libraries(${name}_test PRIVATE sprout_options ${arg_DEPS} GTest::gmock_main)
  gtest_discover_tests(${name}_test PROPERTIES LABELS unit DISCOVERY_TIMEOUT 60)
  set_property(GLOBAL APPEND PROPERTY SPROUT_UNIT_TESTS ${name}_test)
endfunction()
