# The layers, from what each file includes: common/ knows no service, a process of the graph knows no tool,
# no service reaches into another one, and no two folders include each other. See CONTRIBUTING.md.

# Who may know other services: pipeline and the Python module are made of the stages, tools look at all of
# them, and selfcalibrate is sprout-calibrate's estimator in the running graph.
set(SPROUT_LAYER_USERS "^services/(pipeline|python|tools/[a-z]+)$")
set(SPROUT_LAYER_ALLOWED "services/selfcalibrate services/tools/calibrate")

function(sprout_check_layers)
  file(GLOB_RECURSE files RELATIVE "${PROJECT_SOURCE_DIR}"
       "${PROJECT_SOURCE_DIR}/common/*.h" "${PROJECT_SOURCE_DIR}/common/*.cc"
       "${PROJECT_SOURCE_DIR}/services/*.h" "${PROJECT_SOURCE_DIR}/services/*.cc")
  set(folder_of "^(common/[a-z0-9_]+|services/tools/[a-z0-9_]+|services/[a-z0-9_]+)/")
  set(pairs)
  foreach(file IN LISTS files)
    string(REGEX MATCH "${folder_of}" from "${file}")
    string(REGEX REPLACE "/$" "" from "${from}")
    file(STRINGS "${PROJECT_SOURCE_DIR}/${file}" includes REGEX "^#include \"(common|services)/")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "^#include \"([^\"]*)\".*" "\\1" include "${include}")
      string(REGEX MATCH "${folder_of}" to "${include}")
      string(REGEX REPLACE "/$" "" to "${to}")
      if(from STREQUAL to OR "${from} ${to}" STREQUAL SPROUT_LAYER_ALLOWED)
        continue()
      endif()
      if(to MATCHES "^services/" AND NOT from MATCHES "${SPROUT_LAYER_USERS}")
        message(FATAL_ERROR "${file} includes ${include}: ${from} may not know ${to} (CONTRIBUTING.md, layers)")
      elseif(to MATCHES "^services/tools/" AND NOT from MATCHES "^services/tools/")
        message(FATAL_ERROR "${file} includes ${include}: ${from} may not know a tool (CONTRIBUTING.md, layers)")
      endif()
      if("${to} ${from}" IN_LIST pairs)
        message(FATAL_ERROR "${file} includes ${include}, and ${to} includes ${from}: no two folders may "
                            "include each other")
      endif()
      list(APPEND pairs "${from} ${to}")
    endforeach()
    list(REMOVE_DUPLICATES pairs)
  endforeach()
endfunction()
