# Installs the npm modules of SOURCE_DIR/package-lock.json into MODULES_DIR, unless these very ones
# are there. cmake -DSOURCE_DIR=... -DMODULES_DIR=... -P npm_install.cmake
function(expect_program name package)
  find_program(found_${name} ${name})
  if(NOT found_${name})
    message(FATAL_ERROR "${name} is not installed: apt-get install ${package}")
  endif()
endfunction()
expect_program(npm npm)

file(MAKE_DIRECTORY ${MODULES_DIR})
file(LOCK ${MODULES_DIR}/install.lock GUARD PROCESS TIMEOUT 100)
file(SHA256 ${SOURCE_DIR}/package-lock.json wanted)
if(EXISTS ${MODULES_DIR}/installed)
  file(READ ${MODULES_DIR}/installed have)
  if(have STREQUAL wanted)
    return()
  endif()
endif()
file(COPY ${SOURCE_DIR}/package.json ${SOURCE_DIR}/package-lock.json DESTINATION ${MODULES_DIR})
execute_process(
  COMMAND npm ci --ignore-scripts --no-audit --no-fund
  WORKING_DIRECTORY ${MODULES_DIR} RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "npm ci failed (${result}):\n${said}")
endif()
file(WRITE ${MODULES_DIR}/installed ${wanted})
