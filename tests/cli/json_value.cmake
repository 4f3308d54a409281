# Prints one value of a JSON file; fails unless the file is JSON and nothing else. cmake -DFILE=f -DKEYS="a;b" -P json_value.cmake
file(READ "${FILE}" text)
string(JSON value ERROR_VARIABLE problem GET "${text}" ${KEYS})
if(problem)
  message(FATAL_ERROR "${FILE}: ${problem}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} -E echo "${value}")
