# The page's libraries, from npm: the modules of package-lock.json go into LIB_DIR, and of them what
# the server serves under /lib/. Without npm or a network the build goes on: the page says what is
# missing. cmake -DLIB_DIR=... -P install_lib.cmake
set(served uplot/dist/uPlot.esm.js uplot/dist/uPlot.min.css)

set(modules ${LIB_DIR}/../web_modules)
file(MAKE_DIRECTORY ${LIB_DIR} ${modules})
file(COPY ${CMAKE_CURRENT_LIST_DIR}/package.json ${CMAKE_CURRENT_LIST_DIR}/package-lock.json
  DESTINATION ${modules})
find_program(npm npm)
set(result "npm is not installed")
if(npm)
  execute_process(
    COMMAND ${npm} ci --omit=dev --ignore-scripts --no-audit --no-fund WORKING_DIRECTORY ${modules}
    TIMEOUT 120 RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
endif()
if(NOT result EQUAL 0)
  message(WARNING "The page will have no charts; apt-get install npm, and build again: "
    "${result}\n${said}")
  return()
endif()
list(TRANSFORM served PREPEND ${modules}/node_modules/)
file(COPY ${served} DESTINATION ${LIB_DIR})
file(SHA256 ${CMAKE_CURRENT_LIST_DIR}/package-lock.json lock)
file(WRITE ${LIB_DIR}/installed ${lock})
