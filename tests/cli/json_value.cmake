# cmake -DFILE=f -DKEYS="a;b" -P json_value.cmake: prints "-- " and one value of a JSON file. Fails unless the
# file is a single JSON document.
file(READ "${FILE}" text)
string(JSON value ERROR_VARIABLE problem GET "${text}" ${KEYS})
if(problem)
  message(FATAL_ERROR "${FILE}: ${problem}")
endif()
message(STATUS "${value}")
