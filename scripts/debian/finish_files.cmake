# Run by CPack on the files of each package, before it is packed: what Debian asks of every package.
file(GLOB packages LIST_DIRECTORIES true "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*")
foreach(package IN LISTS packages)
  get_filename_component(component "${package}" NAME)
  string(TOUPPER "${component}" component)
  set(name "${CPACK_DEBIAN_${component}_PACKAGE_NAME}")
  if(NOT name)
    continue()
  endif()
  set(doc "${package}/usr/share/doc/${name}")
  file(COPY ${CPACK_SPROUT_DEBIAN_FILES} DESTINATION "${doc}")
  file(RENAME "${doc}/CHANGELOG.md" "${doc}/changelog")
  execute_process(COMMAND gzip -9nf "${doc}/changelog" "${doc}/changelog.Debian"
                          COMMAND_ERROR_IS_FATAL ANY)
  # Folders of which no file was taken.
  execute_process(COMMAND find "${package}" -type d -empty -delete COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND chmod -R go-w "${package}" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
