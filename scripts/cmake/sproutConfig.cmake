# find_package(sprout): targets sprout::pipeline (range and stereo to depth), sprout::log (LCM event
# logs) and sprout::lcmtypes (the messages).
include(CMakeFindDependencyMacro)
find_dependency(OpenCV COMPONENTS core)
find_dependency(Eigen3)
find_dependency(tl-expected)
find_dependency(Protobuf)
list(PREPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_LIST_DIR}")
find_dependency(LCM)
list(POP_FRONT CMAKE_MODULE_PATH)
include("${CMAKE_CURRENT_LIST_DIR}/sproutTargets.cmake")

# Components are names of targets.
foreach(component IN LISTS sprout_FIND_COMPONENTS)
  if(TARGET sprout::${component})
    set(sprout_${component}_FOUND ON)
  elseif(sprout_FIND_REQUIRED_${component})
    set(sprout_FOUND OFF)
    set(sprout_NOT_FOUND_MESSAGE "no component ${component}; allowed: pipeline, log, lcmtypes, lcmtypes_c")
  endif()
endforeach()
