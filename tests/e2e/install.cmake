# The browser tests' modules, and a look whether the programs they run are there.
# cmake -DSOURCE_DIR=... -DMODULES_DIR=... -P install.cmake
include(${CMAKE_CURRENT_LIST_DIR}/../support/npm_install.cmake)
expect_program(node nodejs)
if(NOT DEFINED ENV{CHROMIUM})
  expect_program(chromium chromium)
elseif(NOT EXISTS $ENV{CHROMIUM})
  message(FATAL_ERROR "CHROMIUM names no file: $ENV{CHROMIUM}")
endif()
