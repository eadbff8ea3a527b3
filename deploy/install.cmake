# cmake --install build: the programs, and the manual pages and shell completions that are made of their --help.
include(GNUInstallDirs)
install(TARGETS photond photond-worker photonctl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
find_package(Python3 COMPONENTS Interpreter)
if(Python3_Interpreter_FOUND)
  install(CODE "execute_process(COMMAND \"${Python3_EXECUTABLE}\" \"${CMAKE_CURRENT_LIST_DIR}/manual_pages.py\"
    \"$<TARGET_FILE_DIR:photonctl>\" \"${CMAKE_BINARY_DIR}/manual_pages\" COMMAND_ERROR_IS_FATAL ANY)")
  install(DIRECTORY ${CMAKE_BINARY_DIR}/manual_pages/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR})
else()
  message(STATUS "Python is not here: no manual pages and no completions will be installed")
endif()
