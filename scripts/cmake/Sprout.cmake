# How every library, service and test of Sprout is built: one helper each.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
# Debian's place of libraries, which its linker knows below /usr/local, too.
if(CMAKE_LIBRARY_ARCHITECTURE AND EXISTS /etc/debian_version)
  set(CMAKE_INSTALL_LIBDIR "lib/${CMAKE_LIBRARY_ARCHITECTURE}" CACHE PATH "Object code libraries")
endif()
include(GNUInstallDirs)
# The Debian package of whatever does not say otherwise; others: libsprout, dev, doc.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME sprout)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}")
# What the installed shared libraries are made of is what the programs are made of.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

add_library(sprout_options INTERFACE)
# Eigen and fused multiply-adds, see below; Eigen is on no hot path here.
target_compile_definitions(sprout_options INTERFACE EIGEN_DONT_VECTORIZE)
target_include_directories(sprout_options INTERFACE "${PROJECT_SOURCE_DIR}")
target_compile_options(
  sprout_options
  INTERFACE -Wall -Wextra -Wconversion
            # What GLib asks for: one set of flags for all, as precompiled headers must have.
            -pthread
            # Files compiled as one: what one calls kNan may be a local name of another.
            $<$<NOT:$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>>:-Wshadow>
            # GCC 12 sees uninitialised members in every move of a std::variant.
            $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
            # Fused multiply-add rounds once where two instructions round twice: without this flag
            # the same input gives other bytes on CPUs that have it.
            -ffp-contract=off
            # No function of ours is ever replaced at run time, so the compiler may inline it.
            -fno-semantic-interposition $<$<BOOL:${SPROUT_WERROR}>:-Werror>)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
  # Makes Highway build for NEON alone, which every 64-bit Arm has. Its choice at run time takes NEON
  # only with AES, which a Raspberry Pi 4 lacks, and SVE, whose vectors cannot be elements of arrays.
  target_compile_definitions(sprout_options INTERFACE TOOLCHAIN_MISS_SYS_AUXV_H)
endif()
if(SPROUT_SANITIZE)
  # Test programs without UndefinedBehaviorSanitizer, which doubles the time to compile them: it
  # looks at what the tests call, not at the tests.
  string(REPLACE "," ";" sanitizers "${SPROUT_SANITIZE}")
  list(REMOVE_ITEM sanitizers undefined)
  if(SPROUT_SANITIZE MATCHES undefined)
    target_compile_options(
      sprout_options
      INTERFACE $<$<NOT:$<BOOL:$<TARGET_PROPERTY:SPROUT_IS_TEST>>>:-fsanitize=undefined>)
  endif()
  list(TRANSFORM sanitizers PREPEND -fsanitize=)
  target_compile_options(sprout_options INTERFACE ${sanitizers} -fno-omit-frame-pointer
                                                  -fno-sanitize-recover=all)
  # Boost's fences, which ThreadSanitizer does not know, are nothing that we could mend.
  target_compile_options(sprout_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-error=tsan>)
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

function(sprout_compile_as_one target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
endfunction()

# With SPROUT_UNITY=ALL, what most files include is parsed once for all libraries and once for all test
# programs, which are compiled with -fPIE. A sanitizer's flags are not the same everywhere.
set(SPROUT_PRECOMPILE OFF)
if(SPROUT_UNITY STREQUAL ALL AND NOT SPROUT_SANITIZE)
  set(SPROUT_PRECOMPILE ON)
endif()
function(sprout_precompiled_headers name pic)
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/nothing.cc" CONTENT "")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL "${PROJECT_BINARY_DIR}/nothing.cc")
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(${name} PRIVATE ${pic})
  target_link_libraries(${name} PRIVATE sprout_options opencv_core opencv_imgproc Eigen3::Eigen
                                        tl::expected protobuf::libprotobuf)
  target_precompile_headers(${name} PRIVATE "${PROJECT_SOURCE_DIR}/scripts/cmake/precompiled.h" ${ARGN})
endfunction()

# sprout_library(NAME SOURCES ... [APART ...] [DEPS ...]): static library sprout_NAME. APART: sources
# that have names in common with others, or are compiled once an instruction set; never as one with
# others. Target libraries builds all of them.
add_custom_target(libraries)
function(sprout_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;APART;DEPS" ${ARGN})
  add_library(sprout_${name} STATIC ${arg_SOURCES} ${arg_APART})
  add_dependencies(libraries sprout_${name})
  target_link_libraries(sprout_${name} PUBLIC sprout_options ${arg_DEPS})
  set_source_files_properties(${arg_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(SPROUT_UNITY STREQUAL ALL)
    sprout_compile_as_one(sprout_${name})
  endif()
  if(SPROUT_PRECOMPILE)
    target_precompile_headers(sprout_${name} REUSE_FROM sprout_library_headers)
  endif()
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

# sprout_service(NAME [STAGE] SUMMARY TEXT SOURCES ... [DEPS ...]): program sprout-NAME in bin/, with a man
# page and completion. STAGE: it is a part of the running graph, and systemd looks after it (sprout.target).
# SUMMARY: what `sprout` says of it, in at most 70 characters, without semicolons.
function(sprout_service name)
  cmake_parse_arguments(arg "STAGE" "SUMMARY" "SOURCES;DEPS" ${ARGN})
  string(LENGTH "${arg_SUMMARY}" length)
  if(length EQUAL 0 OR length GREATER 70)
    message(FATAL_ERROR "sprout_service(${name}): SUMMARY of 1 to 70 characters is missing")
  endif()
  set_property(GLOBAL APPEND_STRING PROPERTY SPROUT_SUMMARIES
                                    "    {\"${name}\", \"${arg_SUMMARY}\"},\n")
  add_executable(sprout-${name} ${arg_SOURCES})
  target_link_libraries(sprout-${name} PRIVATE sprout_options ${arg_DEPS})
  if(SPROUT_UNITY STREQUAL ALL)
    sprout_compile_as_one(sprout-${name})
  endif()
  install(TARGETS sprout-${name} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  set_property(GLOBAL APPEND PROPERTY SPROUT_PROGRAMS sprout-${name})
  if(arg_STAGE)
    set_property(GLOBAL APPEND PROPERTY SPROUT_STAGES ${name})
  endif()
endfunction()

# sprout_test_program(NAME SOURCES ... [DEPS ...]): program NAME of the tests, with GoogleTest.
function(sprout_test_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE sprout_options ${arg_DEPS} GTest::gmock_main)
  set_target_properties(${name} PROPERTIES SPROUT_IS_TEST ON)
  if(SPROUT_UNITY)
    sprout_compile_as_one(${name})
  endif()
  if(SPROUT_PRECOMPILE)
    target_link_libraries(${name} PRIVATE $<TARGET_PROPERTY:sprout_test_headers,LINK_LIBRARIES>)
    target_precompile_headers(${name} REUSE_FROM sprout_test_headers)
  endif()
endfunction()

# sprout_test(NAME SOURCES ... [DEPS ...] [LABELS ...]): GoogleTest program NAME_test, each TEST one ctest
# entry; with sanitizers or an emulator, under which a program takes seconds to load, each program. Labels, each with a
# target LABEL_tests: threads, for programs with threads of ours (ThreadSanitizer); border, for those that
# read foreign bytes (AddressSanitizer in CI).
function(sprout_test name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS;LABELS" ${ARGN})
  sprout_test_program(${name}_test SOURCES ${arg_SOURCES} DEPS ${arg_DEPS})
  set(labels unit ${arg_LABELS})
  if(SPROUT_SANITIZE OR CMAKE_CROSSCOMPILING)
    add_test(NAME ${name}_test COMMAND ${name}_test)
    set_tests_properties(
      ${name}_test PROPERTIES LABELS "${labels}" TIMEOUT 900 ENVIRONMENT
      "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/tsan.supp;LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/lsan.supp")
  else()
    gtest_discover_tests(${name}_test PROPERTIES LABELS unit DISCOVERY_TIMEOUT 60)
  endif()
  foreach(label IN LISTS labels)
    set_property(GLOBAL APPEND PROPERTY SPROUT_TESTS_${label} ${name}_test)
  endforeach()
endfunction()
